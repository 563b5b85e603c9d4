#pragma once

#include <filesystem>

#include "app/demo/reference.h"

namespace pliant {

/// The same motion, known of about `count` particles that are evenly spread.
ReferenceMotion thinned(const ReferenceMotion& motion, size_t count);

/// simulate_reference() with the motion of about `stored` particles, from a file in `cache` where one of the same body,
/// script and options lies there; else it is computed, and put there where that is possible.  An empty `cache`: none.
ReferenceMotion cached_reference(const std::filesystem::path& cache, const ReferenceBody& body,
                                 const std::vector<Interaction>& interactions, const ReferenceOptions& options,
                                 size_t stored);

/// Folder of this program in the user's cache ($XDG_CACHE_HOME, else ~/.cache); empty where there is neither.
std::filesystem::path demo_cache_folder();

}  // namespace pliant

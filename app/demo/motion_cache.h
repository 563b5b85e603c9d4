#pragma once

#include <filesystem>
#include <string>

#include "app/demo/reference.h"

namespace pliant {

/// The same motion, known of about `count` particles that are evenly spread.
ReferenceMotion thinned(const ReferenceMotion& motion, size_t count);

/// A short motion of a small body by which the cache knows the solver: 576 particles, the first 240 of them a pinned
/// foot, then 112 of each of three plates.  The first two are thrown against each other; a force, a gust and a grab act
/// besides.
ReferenceMotion solver_sample();
/// Digest of all bits of places, velocities and deformations.
std::string digest_of(const ReferenceMotion& motion);

/// simulate_reference() with the motion of about `stored` particles, from a file in `cache` where one of the same body,
/// script and options lies there, written where solver_sample() has the same bits; else it is computed, and put there
/// where that is possible.  An empty `cache`: none.
ReferenceMotion cached_reference(const std::filesystem::path& cache, const ReferenceBody& body,
                                 const std::vector<Interaction>& interactions, const ReferenceOptions& options,
                                 size_t stored);

/// Folder of this program in the user's cache ($XDG_CACHE_HOME, else ~/.cache); empty where there is neither.
std::filesystem::path demo_cache_folder();

}  // namespace pliant

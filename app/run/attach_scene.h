#pragma once

#include <filesystem>
#include <string>

#include "app/run/run_directory.h"
#include "gaussians/io/scene/scene.h"

namespace pliant {

/// Loads the scene that a run directory was made from.
Scene load_run_scene(const RunDirectory& run);
/// Records `source` in the run directory and loads it.
Scene attach_scene(const Context& context, RunDirectory& run, const std::filesystem::path& source,
                   const LoadOptions& options);

/// Folder of the extracted object, relative to the run directory.
std::string object_folder(const RunDirectory& run);

/// Whether this run has been fitted.
bool is_fitted(const RunDirectory& run);

}  // namespace pliant

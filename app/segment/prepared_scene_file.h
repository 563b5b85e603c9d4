#pragma once

#include "app/run/run_directory.h"
#include "gaussians/io/scene/scene.h"
#include "segmentation/select/gesture.h"

namespace pliant {

/// What selecting needs of the scene, from prepared_scene.bin of the run directory where that was made of the same
/// splats and cameras by this version; else it is prepared, and the file written.  One that cannot be written is
/// warned of.
PreparedScene prepared_scene(const Context& context, const RunDirectory& run, const Scene& scene);

/// How gestures select in a scene.
GestureOptions gesture_options(const Context& context, const Scene& scene);

/// The file: `key` says what it was made of.  Reading gives nothing where the key is another one or the file is
/// damaged.
void write_prepared_scene(const std::filesystem::path& file, const std::string& key, const PreparedScene& scene);
std::optional<PreparedScene> read_prepared_scene(const std::filesystem::path& file, const std::string& key,
                                                 const PrepareOptions& options, const std::vector<Camera>& cameras);

}  // namespace pliant

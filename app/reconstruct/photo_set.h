#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <vector>

#include "gaussians/io/cameras/camera_file.h"
#include "gaussians/io/scene/scene.h"

namespace pliant {

/// Photos with cameras: a folder that holds both, a camera file or COLMAP model, or a folder with a scene.json whose
/// cameras and photos are taken.
struct PhotoSet {
  std::filesystem::path source;   ///< what the user named
  std::filesystem::path cameras;  ///< camera file or COLMAP model
  std::filesystem::path photos;   ///< folder in which photos are looked for first; empty = beside the cameras
  SceneFile settings;             ///< of scene.json
  nlohmann::json scene;           ///< scene.json as it is written; null when there is none
};

/// `photos` (may be empty) is a folder that the user named besides.  `splats` (may be empty) are the files of a trained
/// scene that is trained on, as ReadReport::files has them: where `source` leads to no cameras, theirs are taken.
/// Throws Error{kInput}; without cameras it says how to get them.
PhotoSet find_photo_set(const std::filesystem::path& source, const std::filesystem::path& photos = {},
                        const std::vector<std::filesystem::path>& splats = {});

/// Whether a source of `run` is to be reconstructed first: it has cameras or photos, but no Gaussians.
bool lacks_splats(const std::filesystem::path& source);

/// The cameras of a set, to be fitted to each photo; at least one photo is on disk.
CameraFile read_photo_cameras(const PhotoSet& set);

}  // namespace pliant

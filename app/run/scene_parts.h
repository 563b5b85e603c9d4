#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <set>
#include <string>

#include "app/run/run_directory.h"
#include "gaussians/io/scene/scene.h"

namespace pliant {

/// What a stage may read of a scene.
enum class ScenePart {
  kSplats,   ///< cloud, report, settings.splats, and kDrawing
  kDrawing,  ///< report.antialiased and settings.background: how the scene is drawn, also from other files
  kCameras,  ///< cameras, cameras_are_orbit; without photos
  kPhotos,   ///< the photos of the cameras
  kUp,
  kMetresPerUnit,
  kFolder,  ///< source, for what a scene folder of PhysDreamer holds besides
  kMasks,   ///< settings.masks, and so on
  kLabels,
  kSupport,
  kObject,
  kPinned,
  kMaterial,
  kVideo,       ///< the file, camera and frame rate; a stage that reads the file has it among its inputs
  kVideoCamera  ///< of that the camera alone
};

using ScenePartSet = std::set<ScenePart>;

/// The scene with these parts alone; all else is as in an empty scene.
Scene only(const ScenePartSet& parts, const Scene& scene);

/// The values and the files of parts of a scene that decide what follows from them.
struct SceneRecord {
  nlohmann::json values;
  InputFiles files;
};
SceneRecord record_of(const ScenePartSet& parts, const Scene& scene);

/// Of the recorded inputs of a stage, the hashes of files of splats.
nlohmann::json splats_of(const nlohmann::json& inputs);

}  // namespace pliant

#pragma once

#include <filesystem>
#include <string>

#include "app/fit/fit_stage.h"

namespace pliant {

/// The video that a stage names, or else the scene.
struct NamedVideo {
  std::filesystem::path file;
  std::string camera;        ///< empty = to be found
  double fps = 0;            ///< that the stage or the scene tells
  bool fps_holds = false;    ///< against the file's
  bool physdreamer = false;  ///< of such a folder: it has the horizontal field of view of its camera
};

/// Throws Error{kUsage} where neither names one.
NamedVideo named_video(const Scene& scene, const FitStage& stage);

/// The name of the camera, empty where it is to be found.
std::string known_camera(const Scene& scene, const FitStage& stage);

}  // namespace pliant

#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "gaussians/base/camera.h"
#include "gaussians/base/image.h"

namespace pliant {

/// What a fit is to explain: pictures of the object in motion from one fixed camera.
struct ReferenceVideo {
  Camera camera;               ///< size of the frames
  double fps = 0;              ///< of the frames
  std::vector<ImageF> frames;  ///< [T] of [H, W, 3]
  std::vector<std::string> warnings;
};

}  // namespace pliant

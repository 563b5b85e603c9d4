#pragma once

#include <string>
#include <vector>

#include "gaussians/base/camera.h"

namespace pliant {

/// Three views of the origin from three sides.
inline std::vector<Camera> some_cameras() {
  std::vector<Camera> cameras;
  for (int i = 0; i < 3; ++i) {
    cameras.push_back(look_at({3.0 - i, 1.0 + i, 2.0 - 2 * i}, {0.1, 0, 0}, {0, -1, 0.1}, 640, 480, 500));
    cameras.back().name = "view_" + std::to_string(i);
    cameras.back().cx = 310;
    cameras.back().cy = 250;
    cameras.back().fy = 510;
  }
  return cameras;
}

}  // namespace pliant

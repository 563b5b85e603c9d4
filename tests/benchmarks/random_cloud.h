#pragma once

#include <cmath>

#include "gaussians/base/gaussian_cloud.h"
#include "gaussians/base/random.h"

namespace pliant {

/// Gaussians uniform in a cube, log-uniform anisotropic scales, random rotations and colours without view dependence.
struct RandomCloudOptions {
  int gaussians = 100'000;
  double smallest = 0.004, largest = 0.02;  ///< standard deviations
  double side = 2.6;                        ///< of the cube, around the origin
  double least_opacity = 0.05, most_opacity = 0.95;
};

inline GaussianCloud random_cloud(const RandomCloudOptions& options) {
  GaussianCloud cloud;
  cloud.resize(options.gaussians);
  for (int i = 0; i < options.gaussians; ++i) {
    Random random(1, i);
    for (int k = 0; k < 3; ++k) {
      cloud.position[i][k] = static_cast<float>(random.uniform(-options.side / 2, options.side / 2));
      cloud.log_scale[i][k] = static_cast<float>(random.uniform(std::log(options.smallest), std::log(options.largest)));
    }
    for (int k = 0; k < 4; ++k) cloud.rotation[i][k] = static_cast<float>(random.normal());
    cloud.opacity_logit[i] = logit(static_cast<float>(random.uniform(options.least_opacity, options.most_opacity)));
    for (int k = 0; k < 3; ++k) cloud.sh_of(i)[k] = static_cast<float>(random.uniform(-1.7, 1.7));
  }
  return cloud;
}

}  // namespace pliant

#pragma once

#include <cmath>

#include "gaussians/base/gaussian_cloud.h"
#include "gaussians/base/random.h"

namespace pliant::fixture {

struct RandomCloudOptions {
  double half_width = 1.3;
  double min_log_scale = std::log(0.01), max_log_scale = std::log(0.15);
  double min_opacity_logit = -3, max_opacity_logit = 5;
  double color = 1, shine = 0.3;  ///< standard deviations of the first and of the other spherical harmonics
};

/// `n` Gaussians in a cube about the origin, every parameter drawn at random.
inline GaussianCloud random_cloud(int n, int degree, uint64_t seed, const RandomCloudOptions& options = {}) {
  const RandomCloudOptions& o = options;
  GaussianCloud cloud;
  cloud.sh_degree = degree;
  cloud.resize(n);
  for (int i = 0; i < n; ++i) {
    Random random(seed, i);
    for (int k = 0; k < 3; ++k) {
      cloud.position[i][k] = static_cast<float>(random.uniform(-o.half_width, o.half_width));
      cloud.log_scale[i][k] = static_cast<float>(random.uniform(o.min_log_scale, o.max_log_scale));
    }
    for (int k = 0; k < 4; ++k) cloud.rotation[i][k] = static_cast<float>(random.normal());
    cloud.opacity_logit[i] = static_cast<float>(random.uniform(o.min_opacity_logit, o.max_opacity_logit));
    for (int k = 0; k < 3 * cloud.sh_count(); ++k)
      cloud.sh_of(i)[k] = static_cast<float>(random.normal() * (k < 3 ? o.color : o.shine));
  }
  return cloud;
}

}  // namespace pliant::fixture

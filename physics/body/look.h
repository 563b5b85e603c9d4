#pragma once

#include "gaussians/base/gaussian_cloud.h"

namespace pliant {

/// What a Gaussian shows of the surface around it.
struct Look {
  Vec3f color, normal;  ///< normal zero for a needle
};
Look look_of(const GaussianCloud& cloud, int i);

}  // namespace pliant

#pragma once

#include "gaussians/base/gaussian_cloud.h"

namespace pliant {

/// The same parameters in another precision.
template <class T, class S>
CloudOf<T> cloud_cast(const CloudOf<S>& cloud) {
  CloudOf<T> out;
  out.sh_degree = cloud.sh_degree;
  out.resize(cloud.size());
  for (size_t i = 0; i < cloud.size(); ++i) {
    out.position[i] = cloud.position[i].template cast<T>();
    out.rotation[i] = cloud.rotation[i].template cast<T>();
    out.log_scale[i] = cloud.log_scale[i].template cast<T>();
    out.opacity_logit[i] = static_cast<T>(cloud.opacity_logit[i]);
  }
  for (size_t k = 0; k < cloud.sh.size(); ++k) out.sh[k] = static_cast<T>(cloud.sh[k]);
  return out;
}

}  // namespace pliant

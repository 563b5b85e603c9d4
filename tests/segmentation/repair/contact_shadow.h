#pragma once

#include "tests/segmentation/made_scene.h"

namespace pliant {

inline const Vec3f kFoot(-0.35f, 0.1f, 0);  // of the first of two_balls()
constexpr float kFootRadius = 0.26f;        // where it meets the table

/// Light left on the table beside that ball: soft, half at the rim, stronger on one side.
inline float soft_gain(const Vec3f& x) {
  const float d = std::max(0.0f, (x - kFoot).norm() - kFootRadius) / (0.09f + 0.03f * (x - kFoot).normalized().x());
  return 1 - 0.5f * std::exp(-d * d);
}

/// Multiplies the colours of what lies on the table's plane by gain(x), a Vec3f.
template <class Gain>
void shade_table(GaussianCloud& cloud, Gain&& gain) {
  for (size_t p = 0; p < cloud.size(); ++p) {
    if (std::abs(cloud.position[p].z()) > 1e-4f) continue;
    float* sh = cloud.sh_of(p);
    const Vec3f g = gain(cloud.position[p]);
    for (int k = 0; k < 3; ++k) sh[k] = ((0.5f + kSh0 * sh[k]) * g[k] - 0.5f) / kSh0;
  }
}

}  // namespace pliant

#pragma once

#include "gaussians/base/gaussian_cloud.h"
#include "physics/body/samples.h"

namespace pliant::fixture {

/// Flat Gaussians of a leaf in the plane z = `height`, `length` long from x = `begin` on and .08 wide.
inline void add_leaf(float begin, float length, float height, const Vec3f& color, GaussianCloud& cloud) {
  constexpr float kAlong = 0.01f, kAcross = 0.02f;
  for (float x = begin; x < begin + length; x += kAlong)
    for (const float y : {-0.03f, -0.01f, 0.01f, 0.03f}) {
      const size_t i = cloud.size();
      cloud.resize(i + 1);
      cloud.position[i] = Vec3f(x, y, height);
      cloud.log_scale[i] = Vec3f(kAlong, kAcross / 2, 0.0005f).array().log();
      cloud.opacity_logit[i] = 3;
      for (int c = 0; c < 3; ++c) cloud.sh_of(i)[c] = (color[c] - 0.5f) / kSh0;
    }
}

inline SolidSamples samples_at(const GaussianCloud& cloud) {
  SolidSamples samples;
  samples.position = cloud.position;
  samples.volume.assign(cloud.size(), 1e-6f);
  samples.thickness.assign(cloud.size(), 0.002f);
  samples.spacing = 0.01f;
  return samples;
}

}  // namespace pliant::fixture

#pragma once

#include <cstdint>
#include <span>

#include "gaussians/base/gaussian_cloud.h"
#include "gaussians/io/splats/read_report.h"

namespace pliant {

/// One Gaussian as a file gives it, in the stored spaces of GaussianCloud.  +infinity of `opacity_logit` and -infinity
/// of `log_scale` are legal.
struct SplatRow {
  Vec3f position = Vec3f::Zero(), log_scale = Vec3f::Zero();
  Vec4f rotation = Vec4f(1, 0, 0, 0);  ///< w, x, y, z, of any length
  float opacity_logit = 0;
  float sh[48] = {};  ///< [K, 3]
};

/// Collects the rows of a splat file; the one place that decides which values a Gaussian can have.
class CloudBuilder {
 public:
  /// Call it only after `rows` was compared with the size of the file.
  CloudBuilder(int sh_degree, size_t rows, int object_channels = 0);

  /// Appends the row unless it holds NaN, infinite or absurd values; then false.
  bool add(const SplatRow& row, std::span<const float> object_features = {});

  /// The cloud; counts and warnings go to `report`.
  GaussianCloud finish(ReadReport& report);

 private:
  GaussianCloud cloud_;
  std::vector<float> features_;
  int channels_;
  size_t rows_ = 0, dropped_ = 0, zero_rotations_ = 0;
};

// Values of the formats with 8 bits per value.
float logit_of_byte(uint8_t alpha);  ///< of alpha / 255, kept off the asymptotes
uint8_t byte_of(float value);        ///< 255 * value, clamped and rounded

}  // namespace pliant

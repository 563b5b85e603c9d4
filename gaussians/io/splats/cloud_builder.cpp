#include "gaussians/io/splats/cloud_builder.h"

#include <algorithm>
#include <cmath>

#include "gaussians/base/error.h"

namespace pliant {
namespace {

constexpr float kOpaqueLogit = 20.0f;        // stands for +infinity: sigmoid is 1 in float
constexpr float kSmallestLogScale = -30.0f;  // stands for -infinity
constexpr float kLargestLogScale = 40.0f;    // beyond it squared scales overflow
constexpr float kLargestCoordinate = 1e12f;  // beyond it squared distances overflow
constexpr float kSmallestByteAlpha = 1e-6f;  // alpha of the byte 0; 1 - this is alpha of the byte 255

}  // namespace

CloudBuilder::CloudBuilder(int sh_degree, size_t rows, int object_channels) : channels_(object_channels) {
  CHECK(sh_degree >= 0 && sh_degree <= 3);
  cloud_.sh_degree = sh_degree;
  cloud_.position.reserve(rows);
  cloud_.rotation.reserve(rows);
  cloud_.log_scale.reserve(rows);
  cloud_.opacity_logit.reserve(rows);
  cloud_.sh.reserve(rows * cloud_.sh_count() * 3);
  features_.reserve(rows * channels_);
}

bool CloudBuilder::add(const SplatRow& row, std::span<const float> object_features) {
  CHECK(object_features.size() == static_cast<size_t>(channels_));
  ++rows_;
  const Vec3f log_scale = (row.log_scale.array() == -INFINITY).select(kSmallestLogScale, row.log_scale);
  const float opacity = row.opacity_logit == INFINITY ? kOpaqueLogit : row.opacity_logit;
  bool good = row.position.allFinite() && row.position.cwiseAbs().maxCoeff() <= kLargestCoordinate &&
              log_scale.allFinite() && log_scale.maxCoeff() <= kLargestLogScale && row.rotation.allFinite() &&
              std::isfinite(opacity);
  const int sh = cloud_.sh_count() * 3;
  for (int k = 0; k < sh; ++k) good = good && std::isfinite(row.sh[k]);
  for (float value : object_features) good = good && std::isfinite(value);
  if (!good) return ++dropped_, false;
  const bool rotated = row.rotation.norm() > 1e-12f;
  zero_rotations_ += !rotated;
  cloud_.position.push_back(row.position);
  cloud_.rotation.push_back(rotated ? row.rotation : Vec4f(1, 0, 0, 0));
  cloud_.log_scale.push_back(log_scale);
  cloud_.opacity_logit.push_back(opacity);
  cloud_.sh.insert(cloud_.sh.end(), row.sh, row.sh + sh);
  features_.insert(features_.end(), object_features.begin(), object_features.end());
  return true;
}

GaussianCloud CloudBuilder::finish(ReadReport& report) {
  report.rows = rows_;
  report.dropped = dropped_;
  report.object_channels = channels_;
  report.object_features = std::move(features_);
  if (dropped_ > 0) {
    report.warnings.push_back(std::to_string(dropped_) + " of " + std::to_string(rows_) +
                              " Gaussians with NaN, infinite or absurd values were dropped");
  }
  if (zero_rotations_ > 0) {
    report.warnings.push_back(std::to_string(zero_rotations_) +
                              " Gaussians have a zero quaternion; no rotation is used");
  }
  return std::move(cloud_);
}

float logit_of_byte(uint8_t alpha) {
  return logit(std::clamp(static_cast<float>(alpha) / 255.0f, kSmallestByteAlpha, 1.0f - kSmallestByteAlpha));
}

uint8_t byte_of(float value) { return static_cast<uint8_t>(std::lround(255.0f * std::clamp(value, 0.0f, 1.0f))); }

}  // namespace pliant

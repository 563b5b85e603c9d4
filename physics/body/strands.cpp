#include "physics/body/strands.h"

#include <algorithm>
#include <cmath>

#include "gaussians/base/polar.h"
#include "physics/body/thin_parts.h"

namespace pliant {
namespace {

constexpr float kMatter = 2;  // standard deviations to which a Gaussian is matter

}  // namespace

float Strand::diameter() const { return 2 * kMatter * std::sqrt(across[0].norm() * across[1].norm()); }

std::optional<Strand> strand_at(int i, std::span<const Vec3f> position, std::span<const Mat3f> covariance,
                                const NearestPoints& tree, const std::vector<NearestPoints::Hit>& hits) {
  constexpr size_t kLeastHits = 4;
  constexpr int kMostNear = 64;
  constexpr float kInLine = 0.1f;       // ratio of variances below which points form a line
  constexpr float kFlatSplats = 0.25f;  // ratio of variances below which Gaussians are flat
  constexpr float kDiameters = 1.5f;    // within which the strand is looked at
  if (hits.size() < kLeastHits) return std::nullopt;
  // Gaussians that are as thick as wide.
  Vec3f value;
  Mat3f axes, own = Mat3f::Zero();
  for (const auto& hit : hits) own += covariance[hit.index] / static_cast<float>(hits.size());
  symmetric_eigen<float, 3>(own, value, axes);
  if (!(value[0] > kFlatSplats * value[1])) return std::nullopt;

  // A line for as long as the strand is thick.
  std::vector<NearestPoints::Hit> near;
  const float reach = kDiameters * 2 * kMatter * std::sqrt(value[1]);
  tree.query(position[i], kMostNear, near);
  std::erase_if(near, [&](const NearestPoints::Hit& hit) { return hit.distance > reach; });
  const std::vector<NearestPoints::Hit>& line = near.size() > hits.size() ? near : hits;
  const Spread of_line = spread_of(position, line);
  if (!(of_line.value[1] < kInLine * of_line.value[2])) return std::nullopt;
  const Vec3f axis = of_line.axes.col(2);
  // Nothing beside it: across the line, centres scatter less than a Gaussian is wide.
  const Mat3f level = Mat3f::Identity() - axis * axis.transpose();
  const Mat3f spread = level * covariance_of(position, near) * level, section = level * covariance[i] * level;
  if (!(spread.trace() <= section.trace())) return std::nullopt;

  Strand strand;
  symmetric_eigen<float, 3>(section + spread, value, axes);
  for (int a = 0; a < 2; ++a) strand.across[a] = std::sqrt(std::max(0.0f, value[1 + a])) * axes.col(1 + a);
  // Up to the middle between it and its neighbours along the strand, at an end as far as to the other side.
  float before = INFINITY, after = INFINITY;
  for (const auto& hit : line) {
    if (hit.index == i) continue;
    const float t = axis.dot(position[hit.index] - position[i]);
    float& side = t < 0 || (t == 0 && hit.index < i) ? before : after;
    side = std::min(side, std::abs(t));
  }
  const float most = 2 * kMatter * std::sqrt(axis.dot(covariance[i] * axis));
  const float length = std::isinf(before) ? 2 * after : std::isinf(after) ? 2 * before : before + after;
  strand.along = most / (2 * kMatter) * axis;
  strand.length = std::min(0.5f * length, most);
  return strand;
}

}  // namespace pliant

#include "gaussians/render/bind.h"

#include <algorithm>
#include <array>

#include "gaussians/base/error.h"
#include "gaussians/base/nearest.h"
#include "gaussians/base/portable.h"

namespace pliant {
namespace {

constexpr float kLink = 2.0f;  // drivers closer than this many spacings are connected
constexpr int kHops = 3;       // and a driver is taken when it lies this many links from the nearest one
constexpr int kCandidates = 32;

// Mean distance of a driver to its two nearest neighbours.
float measured_spacing(std::span<const Vec3f> drivers, const NearestPoints& tree) {
  if (drivers.size() < 2) return 0;
  const double sum = ordered_sum(static_cast<std::ptrdiff_t>(drivers.size()), 0.0, [&](std::ptrdiff_t i) {
    std::vector<NearestPoints::Hit> hits;
    tree.query(drivers[i], 3, hits);
    double distance = 0;
    for (size_t k = 1; k < hits.size(); ++k) distance += hits[k].distance;
    return distance / static_cast<double>(hits.size() - 1);
  });
  return static_cast<float>(sum / static_cast<double>(drivers.size()));
}

// Which candidates are linked to `own` within kHops links through other candidates.
std::array<bool, kCandidates> reachable(std::span<const NearestPoints::Hit> hits, size_t own, const auto& linked) {
  std::array<int, kCandidates> hops;
  hops.fill(-1);
  hops[own] = 0;
  for (int step = 0; step < kHops; ++step) {
    for (size_t i = 0; i < hits.size(); ++i) {
      if (hops[i] != step) continue;
      for (size_t j = 0; j < hits.size(); ++j)
        if (hops[j] < 0 && linked(hits[i].index, hits[j].index)) hops[j] = step + 1;
    }
  }
  std::array<bool, kCandidates> out{};
  for (size_t i = 0; i < hits.size(); ++i) out[i] = hops[i] >= 0;
  return out;
}

}  // namespace

Binding bind(const BindOptions& options, std::span<const Vec3f> gaussians, std::span<const Vec3f> drivers,
             const DriverLinks& links) {
  CHECK(options.neighbours >= 1 && options.neighbours <= Binding::kCount);
  CHECK(links.own.empty() || links.own.size() == gaussians.size());
  Binding out;
  out.driver.assign(gaussians.size() * Binding::kCount, -1);
  out.weight.assign(gaussians.size() * Binding::kCount, 0.0f);
  if (drivers.empty()) return out;
  const NearestPoints tree(drivers);
  const float spacing = options.spacing > 0 ? options.spacing : measured_spacing(drivers, tree);
  const auto linked = [&](int a, int b) {
    if (links.links.empty()) return (drivers[a] - drivers[b]).squaredNorm() < kLink * kLink * spacing * spacing;
    return std::binary_search(links.links.begin(), links.links.end(), std::array{std::min(a, b), std::max(a, b)});
  };
  parallel_for(
      static_cast<std::ptrdiff_t>(gaussians.size()),
      [&](std::ptrdiff_t g) {
        if (!gaussians[g].allFinite()) return;
        std::vector<NearestPoints::Hit> hits;
        tree.query(gaussians[g], kCandidates, hits);
        if (spacing > 0 && hits[0].distance > options.max_reach * spacing) return;
        size_t own = 0;
        if (!links.own.empty())
          while (own + 1 < hits.size() && hits[own].index != links.own[g]) ++own;
        if (!links.own.empty() && hits[own].index != links.own[g]) own = 0;
        const auto connected = reachable(hits, own, linked);
        std::vector<NearestPoints::Hit> chosen;
        for (size_t i = 0; i < hits.size() && chosen.size() <= static_cast<size_t>(options.neighbours); ++i)
          if (connected[i]) chosen.push_back(hits[i]);
        // Weights fall to zero at the first driver that is left out, so that they do not jump where neighbours change.
        const bool more = chosen.size() > static_cast<size_t>(options.neighbours);
        const float cut = more ? chosen.back().distance : chosen.back().distance + std::max(spacing, 1e-12f);
        if (more) chosen.pop_back();
        float total = 0;
        for (size_t k = 0; k < chosen.size(); ++k) {
          const float q = chosen[k].distance / cut, w = (1 - q * q) * (1 - q * q);
          out.driver[g * Binding::kCount + k] = chosen[k].index;
          out.weight[g * Binding::kCount + k] = w;
          total += w;
        }
        for (size_t k = 0; k < chosen.size(); ++k) {
          float& w = out.weight[g * Binding::kCount + k];
          w = total > 1e-6f ? w / total : 1.0f / static_cast<float>(chosen.size());
        }
      },
      256);
  return out;
}

}  // namespace pliant

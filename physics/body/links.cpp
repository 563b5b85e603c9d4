#include "physics/body/links.h"

#include <algorithm>
#include <tuple>

#include "gaussians/base/disjoint_sets.h"
#include "gaussians/base/nearest.h"
#include "gaussians/base/portable.h"
#include "physics/body/look.h"

namespace pliant {
namespace {

constexpr float kAlongSheet = 0.6f;   // cells up to which samples of a sheet hang together
constexpr float kAcrossSheet = 0.2f;  // cells off each other's plane, which allows for its noise
constexpr float kSlope = 0.35f;       // or this part of their distance, which allows for its curvature
constexpr float kOneSheet = 0.8f;     // cosine of the angle between normals of one sheet
constexpr float kAngle = 0.35f;       // cells up to which sheets at an angle hang together,
constexpr float kSpacings = 2.2f;     // or this many mean distances of samples
constexpr int kIsland = 40;           // drivers: fewer that no link leads to are noise, and hang on all that is near

void sort_unique(auto& values) {
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
}

}  // namespace

SampleLinks::SampleLinks(const GaussianCloud& object, const SolidSamples& samples, float cell)
    : samples_(samples), cell_(cell), normal_(samples.size(), Vec3f::Zero()) {
  angle_reach_ = std::min(std::max(kAngle * cell, kSpacings * samples.spacing), kAlongSheet * cell);
  reach_ = kAlongSheet * cell;
  if (samples.thickness.empty()) return;
  const NearestPoints shown(object.position);
  parallel_for(
      static_cast<std::ptrdiff_t>(samples.size()),
      [&](std::ptrdiff_t i) {
        if (!(samples.thickness[i] > 0) || samples.thickness[i] > kThinCells * cell) return;
        thread_local std::vector<NearestPoints::Hit> hit;
        shown.query(samples.position[i], 1, hit);
        normal_[i] = look_of(object, hit[0].index).normal;
      },
      256);
}

bool SampleLinks::linked(int i, int k) const {
  const Vec3f d = samples_.position[k] - samples_.position[i];
  const float distance = d.norm();
  // Nearness decides in the bulk and at it, and where sheets meet at an angle.
  if (normal_[i].isZero() || normal_[k].isZero()) return distance <= reach_;
  if (std::abs(normal_[i].dot(normal_[k])) < kOneSheet) return distance <= angle_reach_;
  const float across = std::max(kAcrossSheet * cell_, kSlope * distance);
  return distance <= reach_ && std::abs(normal_[i].dot(d)) <= across && std::abs(normal_[k].dot(d)) <= across;
}

size_t separate_drivers(const std::function<bool(int, int)>& linked, const SolidSamples& samples,
                        DrivingParticles& drivers) {
  std::vector<std::vector<int>> members(drivers.size());
  for (size_t i = 0; i < samples.size(); ++i) members[drivers.sample_driver[i]].push_back(static_cast<int>(i));
  const size_t before = drivers.size();
  for (size_t d = 0; d < before; ++d) {
    const std::vector<int>& of = members[d];
    DisjointSets sets(of.size());
    for (size_t a = 0; a < of.size(); ++a)
      for (size_t b = 0; b < a; ++b)
        if (sets.find(static_cast<int>(a)) != sets.find(static_cast<int>(b)) && linked(of[a], of[b]))
          sets.join(static_cast<int>(a), static_cast<int>(b));
    // Every part keeps the driver's offset from the centroid of its samples, as thin parts are spread.
    std::vector<Vec3f> centre(of.size(), Vec3f::Zero());
    std::vector<float> volume(of.size(), 0);
    Vec3f middle = Vec3f::Zero();
    float whole = 0;
    for (size_t a = 0; a < of.size(); ++a) {
      const int part = sets.find(static_cast<int>(a));
      centre[part] += samples.volume[of[a]] * samples.position[of[a]];
      volume[part] += samples.volume[of[a]];
      middle += samples.volume[of[a]] * samples.position[of[a]];
      whole += samples.volume[of[a]];
    }
    const Vec3f offset = drivers.position[d] - middle / whole;
    const float scale = drivers.volume[d] / whole;
    for (size_t part = 0; part < of.size(); ++part) {
      if (!(volume[part] > 0) || (part == 0 && volume[0] == whole)) continue;
      const int driver = part == 0 ? static_cast<int>(d) : static_cast<int>(drivers.size());
      if (part > 0) {
        drivers.position.emplace_back();
        drivers.volume.emplace_back();
        if (!drivers.rod.empty()) drivers.rod.push_back(drivers.rod[d]);
        if (!drivers.thickness.empty()) drivers.thickness.push_back(drivers.thickness[d]);
      }
      drivers.position[driver] = centre[part] / volume[part] + offset;
      drivers.volume[driver] = scale * volume[part];
      for (size_t a = 0; a < of.size(); ++a)
        if (sets.find(static_cast<int>(a)) == static_cast<int>(part)) drivers.sample_driver[of[a]] = driver;
    }
  }
  return drivers.size() - before;
}

std::vector<std::array<int, 2>> link_drivers(const SampleLinks& links, const SolidSamples& samples, float piece_reach,
                                             const DrivingParticles& drivers) {
  constexpr int kChunk = 1024;
  const float reach = std::max(links.reach(), piece_reach);
  const size_t chunks = (samples.size() + kChunk - 1) / kChunk;
  struct Gap {
    float length;
    int from, to;
    bool operator<(const Gap& o) const { return std::tie(length, from, to) < std::tie(o.length, o.from, o.to); }
  };
  std::vector<std::vector<std::array<int, 2>>> linked(chunks);
  std::vector<std::vector<Gap>> gaps(chunks);
  const NearestPoints tree(samples.position);
  parallel_for(static_cast<std::ptrdiff_t>(chunks), [&](std::ptrdiff_t c) {
    std::vector<NearestPoints::Hit> hits;
    for (size_t i = c * kChunk; i < std::min(samples.size(), static_cast<size_t>(c + 1) * kChunk); ++i) {
      tree.around(samples.position[i], reach, hits);
      for (const NearestPoints::Hit& hit : hits) {
        const int a = drivers.sample_driver[i], b = drivers.sample_driver[hit.index];
        if (a >= b) continue;
        if (links.linked(static_cast<int>(i), hit.index))
          linked[c].push_back({a, b});
        else if (hit.distance <= piece_reach)
          gaps[c].push_back({hit.distance, a, b});
      }
    }
    sort_unique(linked[c]);
  });
  std::vector<std::array<int, 2>> result;
  std::vector<Gap> all;
  for (size_t c = 0; c < chunks; ++c) {
    result.insert(result.end(), linked[c].begin(), linked[c].end());
    all.insert(all.end(), gaps[c].begin(), gaps[c].end());
  }
  DisjointSets sets(drivers.size());
  for (const auto& [a, b] : result) sets.join(a, b);
  std::vector<int> part(drivers.size()), size(drivers.size(), 0);
  for (size_t d = 0; d < drivers.size(); ++d) ++size[part[d] = sets.find(static_cast<int>(d))];
  std::sort(all.begin(), all.end());
  for (const Gap& gap : all) {
    const bool island = std::min(size[part[gap.from]], size[part[gap.to]]) < kIsland && part[gap.from] != part[gap.to];
    if (sets.join(gap.from, gap.to) || island) result.push_back({gap.from, gap.to});
  }
  sort_unique(result);
  return result;
}

std::vector<std::array<int, 2>> inherited_links(std::span<const int> before, std::span<const std::array<int, 2>> links,
                                                std::span<const int> after) {
  // The drivers of now that the samples of each driver of before have.
  std::vector<std::vector<int>> now(before.empty() ? 0 : 1 + *std::max_element(before.begin(), before.end()));
  for (size_t i = 0; i < before.size(); ++i) now[before[i]].push_back(after[i]);
  for (std::vector<int>& drivers : now) sort_unique(drivers);
  std::vector<std::array<int, 2>> result;
  const auto join = [&](const std::vector<int>& some, const std::vector<int>& others) {
    for (const int a : some)
      for (const int b : others)
        if (a != b) result.push_back({std::min(a, b), std::max(a, b)});
  };
  for (const std::vector<int>& drivers : now) join(drivers, drivers);
  for (const auto& [a, b] : links)
    if (std::max(a, b) < static_cast<int>(now.size())) join(now[a], now[b]);
  sort_unique(result);
  return result;
}

}  // namespace pliant

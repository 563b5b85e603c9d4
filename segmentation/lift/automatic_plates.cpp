#include "segmentation/lift/automatic_plates.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "segmentation/lift/contact.h"

namespace pliant {
namespace {

constexpr int kTries = 3;
constexpr size_t kFewest = 50;    // Gaussians of a plate
constexpr int kCells = 48;        // of the grid over it, along its longer side
constexpr int kDirections = 16;
constexpr float kNoise = 3.0f;    // tolerance / standard deviation of the plate's points
constexpr float kBarrier = 0.3f;  // height of what bars the way / size of the plate
constexpr float kLink = 0.2f;     // nearness of Gaussians that lie against each other

/// Share of the straight level ways out of free places of the plate that nothing bars up to `reach` above it.
double openness(const std::vector<Vec3f>& plate, const std::vector<Vec3f>& barrier, const Vec3f& normal) {
  const Vec3f u = normal.unitOrthogonal(), v = normal.cross(u);
  Eigen::Array2f low = Eigen::Array2f::Constant(INFINITY), high = -low;
  const auto flat = [&](const Vec3f& x) { return Eigen::Array2f(u.dot(x), v.dot(x)); };
  for (const Vec3f& x : plate) low = low.min(flat(x)), high = high.max(flat(x));
  const float cell = std::max((high - low).maxCoeff() / kCells, 1e-12f);
  const auto inside = [](int i, int j) { return i >= 0 && j >= 0 && i <= kCells && j <= kCells; };
  std::vector<uint8_t> kind((kCells + 1) * (kCells + 1), 0);  // 1 = plate, 2 = barred
  const auto mark = [&](const std::vector<Vec3f>& points, uint8_t value) {
    for (const Vec3f& x : points) {
      const Eigen::Array2f at = (flat(x) - low) / cell;
      if (!(at.abs() <= 2 * kCells).all()) continue;
      const int i = static_cast<int>(std::floor(at.x())), j = static_cast<int>(std::floor(at.y()));
      if (inside(i, j)) kind[i * (kCells + 1) + j] = value;
    }
  };
  mark(plate, 1), mark(barrier, 2);
  size_t ways = 0, out = 0;
  for (int i = 0; i <= kCells; ++i)
    for (int j = 0; j <= kCells; ++j) {
      if (kind[i * (kCells + 1) + j] != 1) continue;
      for (int d = 0; d < kDirections; ++d) {
        const float angle = 2 * std::numbers::pi_v<float> * d / kDirections;
        bool barred = false;
        for (float t = 0.5f; !barred; t += 0.5f) {
          const int x = static_cast<int>(std::lround(i + t * std::cos(angle))), y = static_cast<int>(std::lround(j + t * std::sin(angle)));
          if (!inside(x, y)) break;
          barred = kind[x * (kCells + 1) + y] == 2;
        }
        ++ways, out += !barred;
      }
    }
  return ways > 0 ? static_cast<double>(out) / static_cast<double>(ways) : 0;
}

/// Median distance of neighbours among the nodes.
float spacing_of(const SolidScene& scene, const std::vector<int>& nodes) {
  std::vector<uint8_t> member(scene.size(), 0);
  for (int i : nodes) member[i] = 1;
  std::vector<float> length;
  for (const CutEdge& e : scene.graph.edges)
    if (member[e.a] && member[e.b]) length.push_back((scene.cloud.position[e.a] - scene.cloud.position[e.b]).norm());
  if (length.empty()) return scene.graph.spacing;
  const auto middle = length.begin() + static_cast<std::ptrdiff_t>(length.size() / 2);
  std::nth_element(length.begin(), middle, length.end());
  return *middle;
}

double share_of(const SolidScene& scene, const std::vector<int>& nodes) {
  double share = 0;
  for (int i : nodes) share += scene.mass[i];
  return share;
}

}  // namespace

int mark_plates(const PlateOptions& options, const SolidScene& scene, const std::vector<int>& nodes, const Vec3f& up,
                std::vector<uint8_t>& foot) {
  const double whole = share_of(scene, nodes);
  Box bounds;
  for (int i : nodes) bounds.add(scene.cloud.position[i]);
  const float spacing = spacing_of(scene, nodes), tolerance = std::max(options.tolerance * bounds.size().norm(), spacing);
  const auto is_level = [&](int i) { return std::abs(scene.normal[i].dot(up)) >= std::cos(2 * options.tilt); };
  std::vector<Vec3f> level;
  for (int i : nodes)
    if (is_level(i)) level.push_back(scene.cloud.position[i]);

  int plates = 0;
  for (int k = 0; k < kTries && level.size() >= kFewest; ++k) {
    const Plane plane = fit_plane(level, tolerance, 1 + k, up, options.tilt);
    if (plane.inliers.size() < kFewest) break;
    const auto height = [&](int i) { return plane.normal.dot(scene.cloud.position[i] - plane.point); };
    const float band = std::clamp(kNoise * plane.rms, spacing, tolerance);
    std::erase_if(level, [&](const Vec3f& x) { return std::abs(plane.normal.dot(x - plane.point)) <= tolerance; });

    std::vector<int> plate;
    std::vector<Vec3f> surface, barrier;
    std::vector<uint8_t> above(scene.size(), 0);
    Box base;
    for (int i : nodes) {
      above[i] = height(i) > band;
      if (std::abs(height(i)) <= band && is_level(i))
        plate.push_back(i), surface.push_back(scene.cloud.position[i]), base.add(scene.cloud.position[i]);
    }
    if (plate.size() < kFewest || share_of(scene, plate) < options.least_share * whole) continue;
    for (int i : nodes)
      if (above[i] && height(i) <= kBarrier * base.size().norm()) barrier.push_back(scene.cloud.position[i]);
    if (openness(surface, barrier, plane.normal) < options.open) continue;

    const std::vector<int> part = connected_parts(scene.graph, above, kLink, true);
    std::vector<std::vector<int>> things(1 + std::max(-1, *std::max_element(part.begin(), part.end())));
    for (int i : nodes)
      if (part[i] >= 0) things[part[i]].push_back(i);
    bool carries = false;
    for (const std::vector<int>& thing : things) {
      if (share_of(scene, thing) < options.thing_share * whole) continue;
      carries = true;
      for (int i : thing) foot[i] |= height(i) <= band + 2 * spacing;
    }
    if (!carries) continue;
    for (int i : plate) foot[i] = 1;
    ++plates;
  }
  return plates;
}

}  // namespace pliant

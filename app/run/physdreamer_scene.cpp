#include "app/run/physdreamer_scene.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "gaussians/base/nearest.h"

namespace pliant {
namespace {

constexpr double kPoisson = 0.3;
constexpr size_t kMostBoxes = 64;
constexpr double kHeldReach = 2;  // cells

/// Cells of a grid over the held points that are held.
struct HeldGrid {
  Vec3f low;
  double cell = 0;
  std::array<int, 3> size{};
  std::vector<uint8_t> held;

  size_t index(int i, int j, int k) const { return (static_cast<size_t>(k) * size[1] + j) * size[0] + i; }
  Vec3f corner(int i, int j, int k) const {
    return low + static_cast<float>(cell) * Vec3f(static_cast<float>(i), static_cast<float>(j), static_cast<float>(k));
  }
};

HeldGrid held_grid(std::span<const Vec3f> held, std::span<const Vec3f> free, double cell) {
  Box box;
  for (const Vec3f& x : held) box.add(x);
  HeldGrid grid;
  grid.low = box.low - Vec3f::Constant(static_cast<float>(0.5 * cell));
  grid.cell = cell;
  for (int a = 0; a < 3; ++a) grid.size[a] = static_cast<int>(std::ceil(box.size()[a] / cell)) + 1;
  std::vector<Vec3f> all(held.begin(), held.end());
  all.insert(all.end(), free.begin(), free.end());
  const NearestPoints tree(all);
  std::vector<NearestPoints::Hit> hits;
  grid.held.assign(static_cast<size_t>(grid.size[0]) * grid.size[1] * grid.size[2], 0);
  for (int k = 0; k < grid.size[2]; ++k)
    for (int j = 0; j < grid.size[1]; ++j)
      for (int i = 0; i < grid.size[0]; ++i) {
        tree.query(grid.corner(i, j, k) + Vec3f::Constant(static_cast<float>(0.5 * cell)), 1, hits);
        grid.held[grid.index(i, j, k)] =
            hits[0].distance <= kHeldReach * cell && static_cast<size_t>(hits[0].index) < held.size();
      }
  const auto cell_of = [&](const Vec3f& x, std::array<int, 3>& c) {
    bool inside = true;
    for (int a = 0; a < 3; ++a) {
      c[a] = static_cast<int>(std::floor((x[a] - grid.low[a]) / cell));
      inside &= c[a] >= 0 && c[a] < grid.size[a];
    }
    return inside;
  };
  std::array<int, 3> c{};
  for (const Vec3f& x : held)
    if (cell_of(x, c)) grid.held[grid.index(c[0], c[1], c[2])] = 1;
  for (const Vec3f& x : free)
    if (cell_of(x, c)) grid.held[grid.index(c[0], c[1], c[2])] = 0;
  return grid;
}

/// Takes the held cells apart into boxes, each grown along x, then y, then z.
std::vector<SceneFile::Region> boxes_of(HeldGrid grid) {
  std::vector<SceneFile::Region> boxes;
  for (int k = 0; k < grid.size[2]; ++k)
    for (int j = 0; j < grid.size[1]; ++j)
      for (int i = 0; i < grid.size[0]; ++i) {
        if (!grid.held[grid.index(i, j, k)]) continue;
        std::array<int, 3> begin = {i, j, k}, end = {i + 1, j + 1, k + 1};
        const auto all_held = [&](std::array<int, 3> from, std::array<int, 3> to) {
          for (int c = from[2]; c < to[2]; ++c)
            for (int b = from[1]; b < to[1]; ++b)
              for (int a = from[0]; a < to[0]; ++a)
                if (!grid.held[grid.index(a, b, c)]) return false;
          return true;
        };
        for (int axis = 0; axis < 3; ++axis)
          while (end[axis] < grid.size[axis]) {
            std::array<int, 3> from = begin, to = end;
            from[axis] = end[axis];
            to[axis] = end[axis] + 1;
            if (!all_held(from, to)) break;
            ++end[axis];
          }
        for (int c = begin[2]; c < end[2]; ++c)
          for (int b = begin[1]; b < end[1]; ++b)
            for (int a = begin[0]; a < end[0]; ++a) grid.held[grid.index(a, b, c)] = 0;
        SceneFile::Region box;
        box.low = grid.corner(begin[0], begin[1], begin[2]);
        box.high = grid.corner(end[0], end[1], end[2]);
        boxes.push_back(box);
      }
  return boxes;
}

}  // namespace

std::vector<SceneFile::Region> boxes_around(std::span<const Vec3f> held, std::span<const Vec3f> free, double cell) {
  if (held.empty()) return {};
  std::vector<SceneFile::Region> boxes = boxes_of(held_grid(held, free, cell));
  for (int round = 0; round < 8 && boxes.size() > kMostBoxes; ++round)
    boxes = boxes_of(held_grid(held, free, cell *= 1.5));
  return boxes;
}

std::optional<PhysDreamerFolder> physdreamer_folder(const Scene& scene) {
  std::error_code ignored;
  if (scene.source.empty() || std::filesystem::exists(scene.source / "scene.json", ignored) ||
      !is_physdreamer_folder(scene.source))
    return std::nullopt;
  return read_physdreamer_folder(scene.source);
}

void take_physdreamer_settings(Scene& scene, const PhysDreamerFolder& folder) {
  SceneFile& settings = scene.settings;
  settings.video = folder.settings.video;
  settings.material.density = folder.settings.material.density;
  settings.material.poisson = kPoisson;
  settings.object = "object";
  if (settings.photos.empty()) settings.photos = folder.settings.photos;
  const PhysDreamerOptions options;
  const PhysDreamerRoles roles = physdreamer_roles(options, folder, scene.cloud.position);
  std::vector<Vec3f> held, free;
  for (size_t i = 0; i < scene.cloud.size(); ++i)
    if (roles.object[i]) (roles.frozen[i] ? held : free).push_back(scene.cloud.position[i]);
  for (size_t i = 0; i < folder.filled_points.size(); ++i)
    (roles.frozen_filled[i] ? held : free).push_back(folder.filled_points[i]);
  settings.pinned = boxes_around(held, free, roles.space.scale / options.grid);
  scene.warnings.insert(scene.warnings.end(), folder.warnings.begin(), folder.warnings.end());
  scene.warnings.insert(scene.warnings.end(), roles.warnings.begin(), roles.warnings.end());
}

}  // namespace pliant

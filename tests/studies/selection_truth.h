#pragma once

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "gaussians/base/gaussian_cloud.h"

namespace pliant {

/// Whether x lies in a solid made of primitives (scene units), one key per node:
///   {"union": [...]}, {"intersection": [...]}, {"difference": [a, b, ...]} (a without the others),
///   {"half_space": [px, py, pz, nx, ny, nz]} (the side that the normal points to), {"box": [x0, y0, z0, x1, y1, z1]},
///   {"ellipsoid": [cx, cy, cz, rx, ry, rz]}, {"prism": {"y": [y0, y1], "xz": [[x, z], ...]}} (a polygon, extruded).
inline bool inside_solid(const nlohmann::json& node, const Vec3f& x) {
  const auto& [kind, value] = *node.items().begin();
  auto holds = [&](const nlohmann::json& child) { return inside_solid(child, x); };
  if (kind == "union") return std::any_of(value.begin(), value.end(), holds);
  if (kind == "intersection") return std::all_of(value.begin(), value.end(), holds);
  if (kind == "difference") return holds(value.front()) && std::none_of(value.begin() + 1, value.end(), holds);
  if (kind == "prism") {
    if (x.y() < value.at("y").at(0).get<float>() || x.y() > value.at("y").at(1).get<float>()) return false;
    const auto outline = value.at("xz").get<std::vector<std::array<float, 2>>>();
    bool inside = false;  // odd number of crossings of a ray along x
    for (size_t i = 0, j = outline.size() - 1; i < outline.size(); j = i++) {
      const auto [ax, az] = outline[i];
      const auto [bx, bz] = outline[j];
      if ((az > x.z()) != (bz > x.z()) && x.x() < ax + (bx - ax) * (x.z() - az) / (bz - az)) inside = !inside;
    }
    return inside;
  }
  const auto n = value.get<std::vector<float>>();
  const Vec3f a(n.at(0), n.at(1), n.at(2)), b(n.at(3), n.at(4), n.at(5));
  if (kind == "half_space") return (x - a).dot(b) >= 0;
  if (kind == "box") return (x.array() >= a.array()).all() && (x.array() <= b.array()).all();
  if (kind == "ellipsoid") return (x - a).cwiseQuotient(b).squaredNorm() <= 1;
  throw std::runtime_error("unknown solid '" + kind + "'");
}

/// [N] 1 = the centre of the Gaussian lies in the solid.
inline std::vector<uint8_t> inside_solid(const nlohmann::json& solid, const GaussianCloud& cloud) {
  std::vector<uint8_t> inside(cloud.size());
  for (size_t p = 0; p < cloud.size(); ++p) inside[p] = inside_solid(solid, cloud.position[p]);
  return inside;
}

}  // namespace pliant

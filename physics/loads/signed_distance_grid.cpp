#include "physics/loads/signed_distance_grid.h"

#include <algorithm>
#include <cmath>

#include "gaussians/base/error.h"

namespace pliant {

/// The cell around the point of the box that is nearest to x.
struct SignedDistanceGrid::Cell {
  Vec3d inside;                  // that point, m
  double distance = 0;           // there, m
  Vec3d slope = Vec3d::Zero();   // its derivatives, m per cell
  Vec3d across = Vec3d::Zero();  // its mixed second derivatives by yz, zx and xy, m per cell^2
};

SignedDistanceGrid::Cell SignedDistanceGrid::cell_at(const Vec3d& x) const {
  CHECK(spacing > 0 && size[0] > 1 && size[1] > 1 && size[2] > 1);
  const Vec3d high = position(size[0] - 1, size[1] - 1, size[2] - 1);
  Cell out;
  out.inside = x.cwiseMax(origin).cwiseMin(high);
  int cell[3];
  double at[3];
  for (int a = 0; a < 3; ++a) {
    const double g = (out.inside[a] - origin[a]) / spacing;
    cell[a] = std::clamp(static_cast<int>(g), 0, size[a] - 2);
    at[a] = g - cell[a];
  }
  for (int corner = 0; corner < 8; ++corner) {
    const int o[3] = {corner >> 2, corner >> 1 & 1, corner & 1};
    const double v = value[(static_cast<size_t>(cell[0] + o[0]) * size[1] + cell[1] + o[1]) * size[2] + cell[2] + o[2]];
    double w[3], d[3];
    for (int a = 0; a < 3; ++a) {
      w[a] = o[a] ? at[a] : 1 - at[a];
      d[a] = o[a] ? 1 : -1;
    }
    out.distance += w[0] * w[1] * w[2] * v;
    out.slope += v * Vec3d(d[0] * w[1] * w[2], w[0] * d[1] * w[2], w[0] * w[1] * d[2]);
    out.across += v * Vec3d(w[0] * d[1] * d[2], d[0] * w[1] * d[2], d[0] * d[1] * w[2]);
  }
  return out;
}

SignedDistanceGrid::Sample SignedDistanceGrid::sample(const Vec3d& x) const {
  const Cell cell = cell_at(x);
  const double way = (x - cell.inside).norm(), slope = cell.slope.norm();
  Vec3d normal = slope > 0 ? Vec3d(cell.slope / slope) : Vec3d::UnitZ();
  if (way > 0 && cell.distance >= 0) normal = (x - cell.inside) / way;
  return {cell.distance + way, normal};
}

Vec3d SignedDistanceGrid::normal_adjoint(const Vec3d& x, const Vec3d& adj_normal) const {
  const Cell cell = cell_at(x);
  const Vec3d way = x - cell.inside;
  const bool by_way = !way.isZero(0) && cell.distance >= 0;
  const Vec3d along = by_way ? way : cell.slope;
  const double length = along.norm();
  if (!(length > 0)) return Vec3d::Zero();
  const Vec3d normal = along / length, adj = (adj_normal - adj_normal.dot(normal) * normal) / length;
  // Along an axis on which x is outside, the way changes and the point of the box stands still.
  Vec3d by_x;
  for (int a = 0; a < 3; ++a) {
    const int b = (a + 1) % 3, c = (a + 2) % 3;
    const double by_slope = (adj[b] * cell.across[c] + adj[c] * cell.across[b]) / spacing;
    by_x[a] = way[a] != 0 ? (by_way ? adj[a] : 0) : by_way ? 0 : by_slope;
  }
  return by_x;
}

}  // namespace pliant

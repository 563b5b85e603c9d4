#include "physics/loads/signed_distance_grid.h"

#include <algorithm>
#include <cmath>

#include "gaussians/base/error.h"

namespace pliant {

SignedDistanceGrid::Sample SignedDistanceGrid::sample(const Vec3d& x) const {
  CHECK(spacing > 0 && size[0] > 1 && size[1] > 1 && size[2] > 1);
  const Vec3d high = position(size[0] - 1, size[1] - 1, size[2] - 1);
  const Vec3d inside = x.cwiseMax(origin).cwiseMin(high);
  int cell[3];
  double at[3];
  for (int a = 0; a < 3; ++a) {
    const double g = (inside[a] - origin[a]) / spacing;
    cell[a] = std::clamp(static_cast<int>(g), 0, size[a] - 2);
    at[a] = g - cell[a];
  }
  double distance = 0;
  Vec3d gradient = Vec3d::Zero();
  for (int corner = 0; corner < 8; ++corner) {
    const int o[3] = {corner >> 2, corner >> 1 & 1, corner & 1};
    const double v = value[(static_cast<size_t>(cell[0] + o[0]) * size[1] + cell[1] + o[1]) * size[2] + cell[2] + o[2]];
    double w[3], d[3];
    for (int a = 0; a < 3; ++a) {
      w[a] = o[a] ? at[a] : 1 - at[a];
      d[a] = o[a] ? 1 : -1;
    }
    distance += w[0] * w[1] * w[2] * v;
    gradient += v * Vec3d(d[0] * w[1] * w[2], w[0] * d[1] * w[2], w[0] * w[1] * d[2]);
  }
  const double way = (x - inside).norm(), slope = gradient.norm();
  Vec3d normal = slope > 0 ? Vec3d(gradient / slope) : Vec3d::UnitZ();
  if (way > 0 && distance >= 0) normal = (x - inside) / way;
  return {distance + way, normal};
}

}  // namespace pliant

#include "app/simulate/default_push.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/import/interactions.h"

namespace pliant {

PushPlace default_push_place(const Particles& particles, const Vec3d& up, const Vec3d& camera_right) {
  double low = INFINITY, high = -INFINITY;
  for (const Vec3f& x : particles.position) {
    const double h = up.dot(x.cast<double>());
    low = std::min(low, h);
    high = std::max(high, h);
  }
  Vec3d sum = Vec3d::Zero();
  double mass = 0;
  for (size_t p = 0; p < particles.size(); ++p) {
    const Vec3d x = particles.position[p].cast<double>();
    if (up.dot(x) < high - 0.1 * (high - low)) continue;
    sum += particles.mass[p] * x;
    mass += particles.mass[p];
  }
  const Vec3d tip = sum / mass;

  PushPlace place;
  double farthest = 0;
  for (const Vec3f& x : particles.position)
    if (up.dot(x.cast<double>()) >= high - 0.1 * (high - low))
      farthest = std::max(farthest, (x.cast<double>() - tip).norm());
  place.region = Region::sphere(tip, std::min(std::max(farthest, 0.05 * (high - low)), 0.25 * (high - low)));
  Vec3d sideways = camera_right - up * up.dot(camera_right);
  if (sideways.norm() < 0.1) sideways = up.unitOrthogonal();
  place.direction = sideways.normalized();
  return place;
}

nlohmann::json push_row(const PushPlace& place, double newtons, double start, double duration, double metres_per_unit) {
  const Vec3d force = newtons * place.direction;
  return {{"type", "point_force"},
          {"start", start},
          {"duration", duration},
          {"region", region_to_json(place.region.scaled(1 / metres_per_unit))},
          {"force", {force.x(), force.y(), force.z()}}};
}

}  // namespace pliant

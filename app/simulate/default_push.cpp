#include "app/simulate/default_push.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/import/interactions.h"

namespace pliant {
namespace {

constexpr int kParticlesOfCell = 8;

}  // namespace

PushPlace default_push_place(const Particles& particles, const ObjectTip& object_tip, const Vec3d& up,
                             const Vec3d& camera_right) {
  double low = INFINITY, high = -INFINITY;
  for (const Vec3f& x : particles.position) {
    const double h = up.dot(x.cast<double>());
    low = std::min(low, h);
    high = std::max(high, h);
  }
  std::vector<Vec3d> top;
  Vec3d sum = Vec3d::Zero();
  double mass = 0;
  for (const int p : object_tip.particles) {
    const Vec3d x = particles.position[p].cast<double>();
    top.push_back(x);
    sum += particles.mass[p] * x;
    mass += particles.mass[p];
  }
  Vec3d tip = sum / mass;
  double farthest = 0;
  for (const Vec3d& x : top) farthest = std::max(farthest, (x - tip).norm());
  const double cell = particles.cell_size,
               radius = std::max(std::clamp(farthest, 0.05 * (high - low), 0.25 * (high - low)), cell);
  const auto held = std::count_if(particles.position.begin(), particles.position.end(),
                                  [&](const Vec3f& x) { return (x.cast<double>() - tip).norm() <= radius; });
  // The mean of a ring, or of two tips, lies where the body is not.
  if (held < kParticlesOfCell)
    tip = *std::min_element(top.begin(), top.end(),
                            [&](const Vec3d& a, const Vec3d& b) { return (a - tip).norm() < (b - tip).norm(); });

  PushPlace place;
  place.region = Region::sphere(tip, radius);
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

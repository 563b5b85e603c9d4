#include "app/simulate/default_push.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "app/import/interactions.h"
#include "app/simulate/clip_camera.h"
#include "app/simulate/simulation_plan.h"
#include "gaussians/io/splats/ply.h"
#include "physics/simulate/loads.h"

namespace pliant {
using nlohmann::json;

namespace {

constexpr int kParticlesOfCell = 8;

/// What the push's deflection is a share of [m]: the height, but of a flat thing a part of its whole extent.
double size_of(const json& extract, const Scene& scene, const Particles& particles) {
  constexpr double kFlat = 0.2;
  Box box;
  for (const Vec3f& x : particles.position) box.add(x);
  return std::max(extract["height"].get<double>() * scene.metres_per_unit,
                  kFlat * static_cast<double>(box.size().norm()));
}

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

json push_row(const PushPlace& place, double newtons, double start, double duration, double metres_per_unit) {
  const Vec3d force = newtons * place.direction;
  return {{"type", "point_force"},
          {"start", start},
          {"duration", duration},
          {"region", region_to_json(place.region.scaled(1 / metres_per_unit))},
          {"force", {force.x(), force.y(), force.z()}}};
}

json sized_push(const Context& context, const SimulateOptions& simulate, const std::filesystem::path& object,
                const json& extract, const Scene& scene, const SimulateStage& stage, const SimulatedBody& body,
                std::vector<Interaction> held, double start, json& push) {
  constexpr double kPushDuration = 0.3;  // s
  constexpr double kFar = 0.7;           // factor of 2, as a logarithm
  const Camera camera = clip_camera(scene, "", robust_bounds(read_ply(object)));
  const Vec3d right = camera.cam_from_world.linear().row(0).transpose();
  const ObjectTip tip = tip_of(body, scene);
  const PushPlace place = default_push_place(body.particles, tip, scene.up, right);
  PushOptions sizing;
  sizing.simulate = simulate;
  sizing.up = scene.up;
  sizing.height = size_of(extract, scene, body.particles);
  sizing.fraction = stage.push;
  sizing.duration = kPushDuration;
  if (const auto floor = stage.floor ? floor_of(extract, {}, scene) : std::nullopt) {
    held.push_back(*floor);
  } else if (!LoadSchedule<float>(simulate, body.particles, held).pinned(0)) {
    // A free fall would count as motion by the push: what nothing holds or carries is pushed against its inertia alone.
    sizing.simulate.gravity.setZero();
    sizing.simulate.settle_time = 0;
  }
  sizing.loose_share = 0.1;
  sizing.scale_on_body = true;
  constexpr int kPercent = 100;
  sizing.go_on = [&](double share) {
    context.progress.done(static_cast<int>(kPercent * share));
    return !context.interrupted();
  };
  context.progress.begin("size the push", kPercent);
  const PushSize size = size_push(sizing, body.particles, held, place.region, place.direction);
  context.progress.end();
  push = {{"newtons", size.newtons}, {"expected_peak", size.peak_fraction}, {"trials", size.trials}};
  context.progress.say(fmt::format("simulate: no interactions given: one push of {:.3g} N at the {}, from {} s to {} s",
                                   size.newtons, tip.top ? "top" : "end farthest from what holds it", start,
                                   start + kPushDuration));
  if (std::abs(std::log(size.peak_fraction / stage.push)) > kFar)
    context.progress.warn(fmt::format(
        "a push that moves the object by {:.3g} % of its height was not found, this one moved it by {:.3g} % "
        "in a trial; give another --auto-push, or loads with --interactions",
        100 * stage.push, 100 * size.peak_fraction));
  return json::array({push_row(place, size.newtons, start, kPushDuration, scene.metres_per_unit)});
}

}  // namespace pliant

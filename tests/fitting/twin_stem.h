#pragma once

// A stem of known stiffness and damping whose points are followed.

#include "fitting/fit/fit_vibration.h"
#include "gaussians/base/random.h"
#include "tests/fitting/made_motion.h"

namespace pliant::fixture {

/// A stem 90 mm high, held below 15 mm.
struct TwinStem {
  Particles particles = block<float>(Vec3d(0.02, 0.02, 0.09), 0.01, 0.5, 3e4, 0.3, 1000);
  std::vector<Interaction> pins;
  std::vector<Vec3f> drivers;
  double fps = 50, damping_time = 0.6;

  TwinStem() {
    Interaction pin;
    pin.type = InteractionType::kPin;
    pin.region = Region::half_space(Vec3d(0, 0, 0.015), Vec3d(0, 0, 1));
    pins = {pin};
    for (const Vec3f& x : particles.position) drivers.push_back(x);
  }

  /// At rest, with a velocity that grows with height.
  SimulationState kicked(double speed) const {
    SimulationState state = initial_state(particles);
    for (size_t i = 0; i < state.size(); ++i) {
      const float s = std::max(0.0f, (particles.position[i].z() - 0.015f) / 0.075f);
      const Vec3f most(static_cast<float>(speed), static_cast<float>(0.4 * speed), 0);
      state.v[i] = s * s * most;
      state.C[i].col(2) = 2 * s / 0.075f * most;
    }
    return state;
  }

  /// Tracks of `count` points up the front face, in metres or in pixels of a camera, with Gaussian errors.
  TrackLoss<float> film(const std::vector<Interaction>& acting, const SimulationState& start, bool in_picture,
                        int frames, int count = 10, double noise = 0, uint64_t seed = 1) const {
    SimulateOptions options;
    options.fps = fps;
    options.duration = frames / fps;
    options.damping_time = damping_time;
    PointTracks seen;
    if (in_picture) seen.camera = look_at({0.01, -0.3, 0.06}, {0.01, 0.01, 0.05}, {0, 0, 1}, 300, 400, 1000);
    for (int k = 0; k < count; ++k) seen.rest.push_back(Vec3f(0.01f, 0.0f, 0.02f + 0.07f * k / count));
    const BodyPoints<float> points(seen.rest, drivers, 1);
    simulate<float>(options, particles, acting, start, [&](const SimulationState& state) {
      seen.weight.emplace_back(count, 1.0);
      seen.place.emplace_back();
      for (const Vec3f& X : points.positions(state)) {
        Vec3d place = X.cast<double>();
        if (in_picture) place << project_point<float>(*seen.camera, X).cast<double>(), 0;
        Random random(seed, seen.place.size() * count + seen.place.back().size());
        for (int a = 0; a < (in_picture ? 2 : 3); ++a) place[a] += noise * random.normal();
        seen.place.back().push_back(place);
      }
      return true;
    });
    return TrackLoss<float>(seen, drivers, 1, in_picture ? 2 : 1e-3);
  }

  /// Of a sideways force that ends after 0.12 s.
  TrackLoss<float> pushed(bool in_picture, double push, int frames) const {
    std::vector<Interaction> acting = pins;
    Interaction force;
    force.type = InteractionType::kPointForce;
    force.vector = {push, 0.4 * push, 0};
    force.start = 0.02;
    force.duration = 0.1;
    force.region = Region::half_space(Vec3d(0, 0, 0.07), Vec3d(0, 0, -1));
    acting.push_back(force);
    return film(acting, initial_state(particles), in_picture, frames);
  }
};

}  // namespace pliant::fixture

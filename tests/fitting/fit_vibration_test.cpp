// Twin experiments: tracks of a stem of known stiffness and damping, a start that is wrong by 30 times.

#include <gtest/gtest.h>

#include "fitting/fit/fit_vibration.h"
#include "gaussians/base/error.h"
#include "tests/fitting/made_motion.h"

namespace pliant {
namespace {

using namespace testing;

/// A stem that was pushed sideways and let go, seen at 50 frames a second.
struct Twin {
  Particles particles = block<float>(Vec3d(0.02, 0.02, 0.09), 0.01, 0.5, 3e4, 0.3, 1000);
  std::vector<Interaction> pins;
  std::vector<Vec3f> drivers;
  double fps = 50, damping_time = 0.6;

  Twin() {
    Interaction pin;
    pin.type = InteractionType::kPin, pin.region = Region::half_space(Vec3d(0, 0, 0.015), Vec3d(0, 0, 1));
    pins = {pin};
    for (const Vec3f& x : particles.position) drivers.push_back(x);
  }

  TrackLoss<float> tracks(bool in_picture, double push, int frames) const {
    std::vector<Interaction> acting = pins;
    Interaction force;
    force.type = InteractionType::kPointForce, force.vector = {push, 0.4 * push, 0}, force.start = 0.02, force.duration = 0.1;
    force.region = Region::half_space(Vec3d(0, 0, 0.07), Vec3d(0, 0, -1));
    acting.push_back(force);
    SimulateOptions options;
    options.fps = fps, options.duration = frames / fps, options.damping_time = damping_time;
    PointTracks seen;
    if (in_picture) seen.camera = look_at({0.01, -0.3, 0.06}, {0.01, 0.01, 0.05}, {0, 0, 1}, 300, 400, 1000);
    for (int k = 0; k < 10; ++k) seen.rest.push_back(Vec3f(0.01f, 0.0f, 0.02f + 0.007f * k));
    const BodyPoints<float> points(seen.rest, drivers, 1);
    simulate<float>(options, particles, acting, initial_state(particles), [&](const SimulationState& state) {
      seen.weight.emplace_back(10, 1.0), seen.place.emplace_back();
      for (const Vec3f& X : points.positions(state)) {
        Vec3d place = X.cast<double>();
        if (in_picture) place << project_point<float>(*seen.camera, X).cast<double>(), 0;
        seen.place.back().push_back(place);
      }
      return true;
    });
    return TrackLoss<float>(seen, drivers, 1, in_picture ? 2 : 1e-3);
  }
};

TEST(FitVibration, FindsStiffnessAndDampingOfATwinFromAStartThirtyTimesWrong) {
  const Twin twin;
  for (const double wrong : {30.0, 1 / 30.0}) {
    const bool in_picture = wrong > 1;
    const TrackLoss<float> tracks = twin.tracks(in_picture, 0.02, 40);
    Particles guess = twin.particles;
    for (float& E : guess.young) E = static_cast<float>(E * wrong);
    VibrationFitOptions options;
    options.modes.most = 6;
    const VibrationFit fit = fit_vibration(options, guess, twin.pins, tracks, twin.fps, [](const std::string& s) { puts(s.c_str()); });
    EXPECT_NEAR(fit.log10_factor + std::log10(wrong), 0, 0.02);
    EXPECT_NEAR(fit.damping_time / twin.damping_time, 1, 0.2);
    EXPECT_LT(fit.rms, 0.05 * fit.rms_rest);
    EXPECT_GE(fit.first_frame, 4);  // the force ends at 0.12 s = frame 6; before, the motion is not free
    EXPECT_GT(fit.search.periods, 1);
  }
}

TEST(FitVibration, ABodyThatStandsStillIsRefused) {
  const Twin twin;
  EXPECT_THROW(fit_vibration({}, twin.particles, twin.pins, twin.tracks(true, 0, 10), twin.fps), Error);
}

}  // namespace
}  // namespace pliant

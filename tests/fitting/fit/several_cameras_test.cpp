// Tracks of several cameras in one loss: what one camera cannot tell, the motion along its line of sight, two can.

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cstdio>

#include "fitting/fields/part_field.h"
#include "fitting/fit/fit_clip.h"
#include "tests/fitting/made_motion.h"

namespace pliant {
namespace {

using namespace fixture;

constexpr int kFrames = 8;
constexpr double kNoise = 0.3;  // px

/// A block that starts to the right and away from the first camera.
struct Seen {
  Motion<float> motion = swinging_block<float>(kFrames);
  Vec3d velocity{0.03, 0.06, 0};  // m/s, so slow that bending hardly shortens the block
  std::vector<Vec3f> drivers;
  PartField field{motion.particles.size(), 3};

  Seen() {
    for (const Vec3f& x : motion.particles.position) drivers.push_back(x);
    for (Vec3f& v : motion.start.v) v.setZero();
  }
  Motion<float> moved() const {
    GradientFitParameters at;
    at.velocity = {velocity.x(), velocity.y(), velocity.z()};
    return with_fields(motion, {nullptr, &field}, at);
  }
  /// Twelve points in the middle, which bending away from the first camera does not lift, as each of the cameras sees
  /// them, with errors.
  PointTracks tracks(const std::vector<Camera>& cameras, double noise = kNoise) const {
    PointTracks tracks;
    tracks.camera = cameras[0];
    tracks.further.assign(cameras.begin() + 1, cameras.end());
    for (size_t c = 0; c < cameras.size(); ++c)
      for (int k = 0; k < 12; ++k) {
        tracks.rest.push_back(Vec3f(0.003f + 0.005f * (k % 4), 0.01f, 0.015f + 0.008f * (k / 4)));
        tracks.camera_of.push_back(static_cast<int>(c));
      }
    const BodyPoints<float> points(tracks.rest, drivers, 1);
    const Motion<float> truth = moved();
    for (const auto& state : rollout<float>(truth.options, truth.particles, truth.interactions, truth.start).frames) {
      tracks.weight.emplace_back(tracks.rest.size(), 1.0);
      tracks.place.emplace_back();
      const std::vector<Vec3f> X = points.positions(state);
      for (size_t k = 0; k < X.size(); ++k) {
        Random random(3, tracks.place.size() * 100 + k);
        const auto pixel = project_point<float>(cameras[tracks.camera_of[k]], X[k]);
        tracks.place.back().push_back({pixel.x() + noise * random.normal(), pixel.y() + noise * random.normal(), 0});
      }
    }
    return tracks;
  }
  /// By which errors of the tracks let each component of the velocity vary: the root of the inverse Hessian's diagonal.
  Vec3d sigma(const std::vector<Camera>& cameras) const {
    Objective<float> objective;
    const TrackLoss<float> exact(tracks(cameras, 0), drivers, 1, 100);
    objective.terms.push_back(
        {0.5 * exact.total_weight() / (kNoise * kNoise), std::make_shared<TrackLoss<float>>(exact)});
    const auto loss = [&](const Vec3d& by) {
      Motion<float> other = moved();
      for (Vec3f& v : other.start.v) v += by.cast<float>();
      return motion_loss(other, objective);
    };
    const double h = 0.02;
    Mat3d hessian;
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) {
        const Vec3d sum = h * (Vec3d::Unit(a) + Vec3d::Unit(b)), difference = h * (Vec3d::Unit(a) - Vec3d::Unit(b));
        hessian(a, b) = (loss(sum) + loss(-sum) - loss(difference) - loss(-difference)) / (4 * h * h);
      }
    return hessian.inverse().diagonal().cwiseSqrt();
  }
  /// The velocity that gradients find.
  Vec3d found(const std::vector<Camera>& cameras) const {
    Objective<float> objective;
    objective.terms.push_back({1, std::make_shared<TrackLoss<float>>(tracks(cameras), drivers, 1, 3)});
    ClipFitOptions options;
    options.velocity = std::make_shared<PartField>(field);
    options.damping = false;
    options.gradient.iterations = 40;
    options.gradient.velocity_rate = 0.01;
    options.gradient.first_window = kFrames;
    options.gradient.velocity_roughness = 0;
    const ClipFit fit = fit_clip(options, motion, objective, {});
    return fit.motion.start.v.back().cast<double>();
  }
};

/// So far away that nearness hardly shows in the picture.
Camera front_camera() { return look_at({0.01, -1.2, 0.025}, {0.01, 0.01, 0.02}, {0, 0, 1}, 200, 160, 3800); }
Camera side_camera() { return look_at({-1.2, 0.01, 0.025}, {0.01, 0.01, 0.02}, {0, 0, 1}, 200, 160, 3800); }

TEST(SeveralCameras, TwoDetermineTheVelocityAlongTheLineOfSightOfOne) {
  const Seen seen;
  const Vec3d one = seen.sigma({front_camera()}), two = seen.sigma({front_camera(), side_camera()});
  printf("standard deviation of v0 in m/s: one camera (%.4f %.4f %.4f), two (%.4f %.4f %.4f)\n", one.x(), one.y(),
         one.z(), two.x(), two.y(), two.z());
  EXPECT_GT(one.y(), 4 * one.x());
  EXPECT_LT(two.y(), 1.5 * two.x());
  const Vec3d error = seen.found({front_camera(), side_camera()}) - seen.velocity;
  EXPECT_LT(error.norm(), 0.01);
}

TEST(SeveralCameras, TheirLossIsTheMeanOfTheirLosses) {
  const Seen seen;
  const std::vector<Camera> both = {front_camera(), side_camera()};
  const PointTracks tracks = seen.tracks(both);
  const auto loss = [&](const PointTracks& of) {
    Objective<float> objective;
    objective.terms.push_back({1, std::make_shared<TrackLoss<float>>(of, seen.drivers, 1, 3)});
    return motion_loss(seen.motion, objective);
  };
  double sum = 0;
  for (int c = 0; c < 2; ++c) {
    PointTracks own = tracks;
    own.camera = both[c];
    own.further.clear();
    own.camera_of.clear();
    const auto half = [&](auto& all) { all = {all.begin() + 12 * c, all.begin() + 12 * (c + 1)}; };
    half(own.rest);
    for (auto& frame : own.place) half(frame);
    for (auto& frame : own.weight) half(frame);
    sum += 0.5 * loss(own);
  }
  EXPECT_NEAR(loss(tracks), sum, 1e-6 * sum);
}

}  // namespace
}  // namespace pliant

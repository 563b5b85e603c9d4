// Twin experiments with E that differs from place to place.

#include "fitting/fit/fit_material.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>

#include "fitting/modal/dissipation.h"
#include "gaussians/base/error.h"
#include "tests/fitting/twin_stem.h"

namespace pliant {
namespace {

using fixture::TwinStem;

/// Median over the free particles of |log10 E - log10 E of the truth|.
double median_error(const std::vector<double>& young, const Particles& truth) {
  std::vector<double> error;
  for (size_t i = 0; i < young.size(); ++i)
    if (truth.position[i].z() > 0.015f) error.push_back(std::abs(std::log10(young[i] / truth.young[i])));
  std::nth_element(error.begin(), error.begin() + error.size() / 2, error.end());
  return error[error.size() / 2];
}

struct TwoParts : TwinStem {
  std::vector<uint32_t> part;
  /// The upper half is ten times softer, so that both carry a good share of the strain energy.
  TwoParts() {
    for (size_t i = 0; i < particles.size(); ++i) {
      part.push_back(particles.position[i].z() > 0.05f);
      particles.young[i] = part.back() ? 1.5e4f : 1.5e5f;
    }
  }
};

/// A fit from a start that is the same everywhere and too stiff, and what it must reach.
void fit_two_parts(MaterialKind kind, double tolerance) {
  const TwoParts twin;
  const int frames = 16;
  const TrackLoss<float> tracks = twin.film(twin.pins, twin.kicked(0.5), true, frames, 20, 0.05);
  Particles guess = twin.particles;
  guess.young.assign(guess.size(), 3e5f);
  MaterialFitOptions options;
  options.kind = kind;
  options.part = twin.part;
  options.smooth.modes = 10;
  options.vibration.modes.most = 6;
  options.vibration.refine.tolerance = 2e-3;
  options.vibration.most_smooth = 7;
  const MaterialFit fit = fit_material(options, guess, twin.pins, tracks, twin.fps);
  const std::vector<double> constant(guess.size(), 3e5 * std::pow(10.0, fit.homogeneous.log10_factor));
  const double error = median_error(fit.young, twin.particles), best_constant = median_error(constant, twin.particles);
  // A stiff spot makes time steps smaller, and transfers take more in them: damping is what both lose together.
  Motion<float> motion{fit.particles, fit.found.start, twin.pins, {}},
      truth{twin.particles, twin.kicked(0.5), twin.pins, {}};
  motion.options.simulate.fps = twin.fps * fit.found.subframes;
  motion.options.simulate.substeps = fit.found.substeps;
  motion.options.simulate.damping_time = fit.found.damping_time;
  motion.options.simulate.duration =
      fit.found.rollout_frame(fit.found.last_frame, twin.fps) / motion.options.simulate.fps;
  truth.options.simulate.fps = twin.fps;
  truth.options.simulate.damping_time = twin.damping_time;
  truth.options.simulate.duration = frames / twin.fps;
  truth.options.simulate.substeps =
      simulate<float>(truth.options.simulate, truth.particles, truth.interactions, truth.start)
          .summary.substeps_of_frame.at(0);
  const double damping = dissipation_of(truth).whole / dissipation_of(motion).whole;
  // Of the start, what the picture shows: x and z.
  const auto seen_velocity = [&](const SimulationState& start) {
    Vec3d mean = Vec3d::Zero();
    for (size_t i = 0; i < start.size(); ++i)
      if (twin.particles.position[i].z() > 0.015f) mean += start.v[i].cast<double>();
    return Vec3d(mean.x(), 0, mean.z());
  };
  const Vec3d found_velocity = seen_velocity(fit.found.start), true_velocity = seen_velocity(twin.kicked(0.5));
  const double direction = std::acos(found_velocity.normalized().dot(true_velocity.normalized())) * 57.29578,
               speed = found_velocity.norm() / true_velocity.norm();
  printf(
      "median |log10 E error| %.3f, best constant %.3f, damping time x %.3f (drag alone x %.3f), start %.1f degrees "
      "and x %.3f\n",
      error, best_constant, damping, fit.found.damping_time / twin.damping_time, direction, speed);
  EXPECT_LT(direction, 5);
  EXPECT_NEAR(speed, 1, 0.1);
  EXPECT_LT(error, tolerance);
  EXPECT_LT(error, 0.5 * best_constant);
  EXPECT_NEAR(damping, 1, 0.2);
  EXPECT_LT(fit.found.rms, 0.2 * fit.homogeneous.rms);
  // The curve of the field's refinement runs from the best constant to what was found, over all rounds.
  const std::vector<double>& curve = fit.steps.back().loss;
  EXPECT_GT(curve.front(), 2 * curve.back());
  EXPECT_NEAR(curve.back(), fit.found.rms, 1e-9);
  EXPECT_FALSE(fit.steps.back().stopped_by.empty());
  // Of the mean of log10 E: no larger than the mean of the particles' own.
  double mean_sigma = 0;
  for (const double s : fit.found.young_sigma) mean_sigma += s / static_cast<double>(guess.size());
  EXPECT_GT(fit.found.log10_sigma, 0);
  EXPECT_LE(fit.found.log10_sigma, mean_sigma + 1e-12);
  // The middle, which bends, is determined.
  for (size_t i = 0; i < guess.size(); ++i) {
    const float z = twin.particles.position[i].z();
    if (kind == MaterialKind::kSmooth && z > 0.03f && z < 0.07f) {
      EXPECT_TRUE(fit.determined(i)) << z << ": " << fit.sigma[i];
    }
  }
  if (kind != MaterialKind::kParts) return;
  // About the same motion the posterior after gradients is as wide but for a factor of two.
  MaterialFit about = fit;
  find_posterior(options, motion, tracks,
                 {fit.found.first_frame, fit.found.last_frame, fit.found.rollout_frame(fit.found.first_frame, twin.fps),
                  fit.found.subframes, twin.fps},
                 {}, about);
  double least = INFINITY, most = 0;
  for (size_t i = 0; i < guess.size(); ++i)
    if (twin.particles.position[i].z() > 0.015f) {
      least = std::min(least, about.sigma[i] / fit.sigma[i]);
      most = std::max(most, about.sigma[i] / fit.sigma[i]);
    }
  printf("sigma after gradients against that of Gauss-Newton: %.2f to %.2f\n", least, most);
  EXPECT_GT(least, 0.5);
  EXPECT_LT(most, 2);
}

TEST(FitMaterial, TwoPartsTenTimesApartAreFoundByParts) { fit_two_parts(MaterialKind::kParts, 0.08); }

TEST(FitMaterial, TwoPartsTenTimesApartAreFoundByASmoothField) { fit_two_parts(MaterialKind::kSmooth, 0.15); }

TEST(FitMaterial, AFieldIsOnlyTakenWhereItExplainsMoreThanTheBestConstant) {
  const TwoParts twin;
  const size_t n = twin.particles.size();
  const TrackLoss<float> tracks = twin.film(twin.pins, twin.kicked(0.5), true, 2);
  MaterialFitOptions options;
  options.kind = MaterialKind::kParts;
  options.part = twin.part;
  VibrationFit constant, field;
  constant.log10_factor = -0.3;
  constant.rms = 1;
  constant.damping_time = 0.6;
  constant.young_sigma.assign(n, 0.01);
  field.log10_factor = 0.1;
  field.field = {0.5, -0.5};
  field.damping_time = 100;
  field.young_sigma.assign(n, 0.02);
  const auto fit = [&](double rms) {
    MaterialFitProgress kept;
    kept.homogeneous = constant;
    kept.field = field;
    kept.field->rms = rms;
    kept.homogeneous->start = kept.field->start = initial_state(twin.particles);
    return fit_material(options, twin.particles, twin.pins, tracks, twin.fps, {}, kept);
  };
  const MaterialFit taken = fit(0.99), left = fit(1.01);
  EXPECT_FALSE(taken.field_left);
  EXPECT_TRUE(left.field_left);
  EXPECT_EQ(taken.found.damping_time, 100);
  EXPECT_EQ(left.found.damping_time, 0.6);
  for (size_t i = 0; i < n; ++i) {
    EXPECT_NEAR(std::log10(taken.young[i] / twin.particles.young[i]),
                -0.3 + 0.1 + (twin.part[i] == 0 ? 0.5 : -0.5) / std::log(10.0), 1e-5);
    EXPECT_NEAR(std::log10(left.young[i] / twin.particles.young[i]), -0.3, 1e-5);
    EXPECT_TRUE(taken.determined(i));
    EXPECT_FALSE(left.determined(i));
  }
  // What was tried is told.
  EXPECT_EQ(left.steps.back().name, "field");
}

TEST(FitMaterial, TheFactorIsThatOfWhatGradientsFoundToo) {
  const TwinStem twin;
  const TrackLoss<float> tracks = twin.film(twin.pins, twin.kicked(0.5), true, 12);
  MaterialFitOptions options;
  options.poisson = true;
  options.gradient.iterations = 4;
  options.gradient.growth = 0;
  options.vibration.modes.most = 2;
  options.gradient.noisy = true;  // the last step counts, though the best constant is right
  Particles guess = twin.particles;
  for (float& young : guess.young) young *= 2;
  const MaterialFit fit = fit_material(options, guess, twin.pins, tracks, twin.fps);
  ASSERT_EQ(fit.steps.back().name, "gradients");
  EXPECT_NE(fit.found.log10_factor, fit.homogeneous.log10_factor);
  for (size_t i = 0; i < guess.size(); ++i)
    ASSERT_NEAR(std::log10(fit.young[i] / guess.young[i]), fit.found.log10_factor, 1e-5);
}

TEST(FitMaterial, NetworksBeginByTheirSeed) {
  const TwinStem twin;
  MaterialFitOptions options;
  const auto begun = [&](MaterialKind kind, uint64_t seed) {
    options.kind = kind;
    options.planes.seed = options.kan.seed = seed;
    return gradient_fields(options, twin.particles, twin.pins).material->constant(std::vector<double>{0.0});
  };
  std::vector<MaterialKind> kinds = {MaterialKind::kKan};
  if (has_triplane_fields()) kinds.push_back(MaterialKind::kTriplanes);
  for (const MaterialKind kind : kinds) {
    EXPECT_EQ(begun(kind, 1), begun(kind, 1));
    EXPECT_NE(begun(kind, 1), begun(kind, 2));
  }
}

TEST(FitMaterial, TriplanesGoOnFromTheBestConstantAndFromWhereTheyWereStopped) {
  if (!has_triplane_fields()) GTEST_SKIP() << "built without libtorch";
  const TwoParts twin;
  const TrackLoss<float> tracks = twin.film(twin.pins, twin.kicked(0.5), true, 16, 20, 0.05);
  MaterialFitOptions options;
  options.kind = MaterialKind::kTriplanes;
  options.smooth.modes = 3;
  options.vibration.most_smooth = 3;
  options.gradient.iterations = 20;
  options.gradient.growth = 0.3;
  options.vibration.modes.most = 2;  // with more of them the best constant leaves next to nothing to explain
  options.vibration.refine.tolerance = 1e-2;
  options.vibration.search.first = 0.08;
  const auto fit = [&](const MaterialFitProgress& kept) {
    return fit_material(options, twin.particles, twin.pins, tracks, twin.fps, {}, kept);
  };
  MaterialFitProgress begun, interrupted;
  begun.keep_homogeneous = [&](const VibrationFit& f) { interrupted.homogeneous = f; };
  begun.keep_field = [&](const VibrationFit& f) { interrupted.field = f; };
  const MaterialFit whole = fit(begun);
  EXPECT_EQ(whole.iterations.size(), 20u);
  EXPECT_LT(whole.found.rms, 0.95 * whole.homogeneous.rms);
  ASSERT_EQ(whole.sigma.size(), twin.particles.size());
  EXPECT_GT(whole.found.log10_sigma, 0);

  MaterialFitProgress continued = interrupted;
  interrupted.keep_gradient = [&](const GradientFitState& state) {
    continued.gradient = state;
    return state.rows.size() < 5;
  };
  EXPECT_THROW(fit(interrupted), Error);
  ASSERT_EQ(continued.gradient.rows.size(), 5u);
  EXPECT_EQ(fit(continued).young, whole.young);
}

}  // namespace
}  // namespace pliant

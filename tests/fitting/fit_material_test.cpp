// Twin experiments with E that differs from place to place.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>

#include "fitting/fit/fit_material.h"
#include "tests/fitting/twin_stem.h"

namespace pliant {
namespace {

using testing::TwinStem;

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

TEST(FitMaterial, PartsTenTimesApartAreFoundFromAHomogeneousStart) {
  const TwoParts twin;
  const TrackLoss<float> tracks = twin.film(twin.pins, twin.kicked(0.5), true, 24, 20, 0.05);
  Particles guess = twin.particles;
  guess.young.assign(guess.size(), 3e5f);
  for (const MaterialKind kind : {MaterialKind::kParts, MaterialKind::kSmooth}) {
    MaterialFitOptions options;
    options.kind = kind, options.part = twin.part;
    options.vibration.modes.most = 8, options.vibration.most_modes = 8, options.vibration.refine.tolerance = 1e-4, options.vibration.refine.max_iterations = 40;
    const MaterialFit fit = fit_material(options, guess, twin.pins, tracks, twin.fps, [](const std::string& s) { puts(s.c_str()); });
    std::vector<double> constant(guess.size(), 3e5 * std::pow(10.0, fit.homogeneous.log10_factor));
    const double error = median_error(fit.young, twin.particles), best_constant = median_error(constant, twin.particles);
    printf("median |log10 E error| %.3f, constant %.3f; damping %.3f of %.3f; %.1f s + %.1f s\n", error, best_constant,
           fit.found.damping_time, twin.damping_time, fit.homogeneous.seconds, fit.found.seconds);
    EXPECT_LT(error, kind == MaterialKind::kParts ? 0.08 : 0.15);
    EXPECT_LT(error, best_constant);
    EXPECT_NEAR(fit.found.damping_time / twin.damping_time, 1, 0.2);
    for (size_t i = 0; i < guess.size(); i += 8)
      printf("z %.3f: E %.3g of %.3g +- %.3f\n", twin.particles.position[i].z(), fit.young[i], twin.particles.young[i], fit.sigma[i]);
  }
}

}  // namespace
}  // namespace pliant

#include "fitting/solve/gauss_newton.h"

#include <gtest/gtest.h>

#include <cmath>

#include "gaussians/base/error.h"
#include "gaussians/base/random.h"

namespace pliant {
namespace {

/// A damped swing amplitude * exp(-rate t) cos(omega t) at 60 instants, with noise.
std::vector<double> swing(std::span<const double> p, double noise, uint64_t seed) {
  std::vector<double> y;
  for (int k = 0; k < 60; ++k) {
    const double t = k / 60.0;
    y.push_back(p[0] * std::exp(-p[1] * t) * std::cos(p[2] * t) + noise * Random(seed, k).normal());
  }
  return y;
}

Residuals against(const std::vector<double>& measured, double sigma) {
  return [measured, sigma](std::span<const double> p) {
    std::vector<double> r = swing(p, 0, 0);
    for (size_t k = 0; k < r.size(); ++k) r[k] = (r[k] - measured[k]) / sigma;
    return r;
  };
}

TEST(GaussNewton, StraightLineIsSolvedInOneStepWithTheClosedFormCovariance) {
  // y = a + b t at t = 0..9: covariance of (a, b) is the inverse of [[n, sum t], [sum t, sum t^2]].
  const auto r = [](std::span<const double> p) {
    std::vector<double> out;
    for (int t = 0; t < 10; ++t) out.push_back(p[0] + p[1] * t - (3 - 0.5 * t));
    return out;
  };
  GaussNewtonOptions options;
  options.damping = 0;
  options.max_iterations = 2;
  const auto fit = gauss_newton(options, r, std::vector<double>{0, 0});
  EXPECT_NEAR(fit.parameters[0], 3, 1e-9);
  EXPECT_NEAR(fit.parameters[1], -0.5, 1e-9);
  const double determinant = 10 * 285.0 - 45 * 45;
  EXPECT_NEAR(fit.covariance(0, 0), 285 / determinant, 1e-6);
  EXPECT_NEAR(fit.covariance(1, 1), 10 / determinant, 1e-6);
  EXPECT_NEAR(fit.covariance(0, 1), -45 / determinant, 1e-6);
}

TEST(GaussNewton, FindsTheParametersOfADampedSwing) {
  const std::vector<double> truth = {2, 1.5, 12};
  GaussNewtonOptions options;
  options.low = {0, 0, 0};
  const auto fit = gauss_newton(options, against(swing(truth, 0, 0), 1), std::vector<double>{1, 0.2, 11});
  EXPECT_TRUE(fit.summary.converged) << fit.summary.stopped_by;
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(fit.parameters[i], truth[i], 1e-5) << i;
  EXPECT_TRUE(std::is_sorted(fit.summary.loss.rbegin(), fit.summary.loss.rend()));
}

TEST(GaussNewton, TheJacobianOfASimilarProblemLeadsToTheSameParametersWithFewerRuns) {
  const std::vector<double> truth = {2, 1.5, 12};
  const auto coarse = gauss_newton({}, against(swing(truth, 0, 0), 1), std::vector<double>{2.1, 1.4, 12.1});
  GaussNewtonOptions chord;
  chord.jacobian = coarse.jacobian;
  const std::vector<double> other = {2.02, 1.52, 12.05};
  const auto fit = gauss_newton(chord, against(swing(other, 0, 0), 1), coarse.parameters);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(fit.parameters[i], other[i], 1e-4) << i;
  const auto by_differences = gauss_newton({}, against(swing(other, 0, 0), 1), coarse.parameters);
  EXPECT_LT(fit.summary.evaluations, by_differences.summary.evaluations);
}

TEST(GaussNewton, AlongPrincipalAxesRoundingIsNotTakenForInformation) {
  // The sum of two parameters is seen well, their difference hardly, and residuals come in steps.
  const Residuals rounded = [](std::span<const double> p) {
    std::vector<double> r;
    for (int i = 0; i < 200; ++i)
      r.push_back(
          0.003 *
          std::round((100 * (p[0] + p[1] - 3) * std::cos(i) + 0.1 * (p[0] - p[1] - 1) * std::sin(2 * i)) / 0.003));
    return r;
  };
  GaussNewtonOptions options;
  options.prior = {2, 1};
  options.prior_sigma = {10, 10};
  options.difference = {1e-3, 1e-3};
  // (p0 - p1) / sqrt 2: sum of (0.1 sqrt 2 sin)^2, and the prior.
  const double sigma = 1 / std::sqrt(0.02 * 100 + 0.01);
  const auto across = [](const GaussNewtonResult& r) {
    return std::sqrt(0.5 * (r.covariance(0, 0) + r.covariance(1, 1)) - r.covariance(0, 1));
  };
  EXPECT_LT(across(gauss_newton(options, rounded, std::vector<double>{2.2, 0.9})), 0.5 * sigma);
  options.principal_axes = true;
  const auto fit = gauss_newton(options, rounded, std::vector<double>{2.2, 0.9});
  EXPECT_NEAR(across(fit) / sigma, 1, 0.1);
  EXPECT_NEAR(fit.parameters[0] + fit.parameters[1], 3, 1e-3);
  EXPECT_NEAR(fit.parameters[0] - fit.parameters[1], 1, 0.1);
}

TEST(GaussNewton, StopsAfterTheMostDifferencesWithWhatItHas) {
  GaussNewtonOptions options;
  options.most_jacobians = 1;
  const auto fit = gauss_newton(options, against(swing(std::vector<double>{2, 1.5, 12}, 0, 0), 1),
                                std::vector<double>{2.1, 1.4, 12.1});
  EXPECT_EQ(fit.summary.stopped_by, "Jacobian limit");
  EXPECT_LE(fit.summary.evaluations, 1 + 3 + 1);
  EXPECT_GT(fit.sigma(0), 0);
}

TEST(GaussNewton, ACorrectedJacobianAgreesWithEveryStepAndTheResultHasTheOneFoundByDifferences) {
  // Broyden's condition: J (p - p before) = r - r before.
  GaussNewtonOptions options;
  options.keep_jacobian = true;
  std::vector<GaussNewtonState> states;
  const auto fit =
      gauss_newton(options, against(swing(std::vector<double>{2, 1.5, 12}, 0, 0), 1), std::vector<double>{1, 0.2, 11},
                   {}, [&](const GaussNewtonState& state) { states.push_back(state); });
  int corrected = 0;
  for (size_t k = 1; k < states.size(); ++k) {
    const Eigen::VectorXd moved = states[k].parameters - states[k - 1].parameters,
                          change = states[k].residuals - states[k - 1].residuals;
    if (moved.norm() == 0 || !states[k].linearised || states[k].jacobians != states[k - 1].jacobians) continue;
    EXPECT_LT((states[k].jacobian * moved - change).norm(), 1e-9 * change.norm() + 1e-12) << k;
    EXPECT_GT((states[k].jacobian - states[k].differences).norm(), 0);
    ++corrected;
  }
  EXPECT_GT(corrected, 3);
  EXPECT_EQ(fit.jacobian, states.back().differences);
  for (size_t k = 1; k < states.size(); ++k)
    if (states[k].jacobians > states[k - 1].jacobians) {
      EXPECT_EQ(states[k].jacobian, states[k].differences);
    }
}

TEST(GaussNewton, CorrectionsTakeFewerRunsAndDoNotDependOnTheUnitsOfParameters) {
  // Six swings whose frequencies depend on each other: 18 parameters.
  const size_t swings = 6;
  const auto all = [&](std::span<const double> p) {
    std::vector<double> y;
    for (size_t s = 0; s < swings; ++s) {
      const double before = s ? p[3 * s - 1] : 0.0;
      for (const double v : swing(std::vector<double>{p[3 * s], p[3 * s + 1], p[3 * s + 2] + 0.1 * before}, 0, 0))
        y.push_back(v);
    }
    return y;
  };
  std::vector<double> truth, start, unit;
  for (size_t s = 0; s < swings; ++s) {
    for (const double v : {2.0, 1.5, 8.0 + 0.5 * static_cast<double>(s)}) truth.push_back(v);
    for (const double v : {1.2, 0.6, 7.4 + 0.5 * static_cast<double>(s)}) start.push_back(v);
    for (const double v : {1.0, 1e3, 1e-2}) unit.push_back(v);
  }
  const std::vector<double> measured = all(truth);
  const auto fit_in = [&](const std::vector<double>& units, bool keep) {
    std::vector<double> from = start;
    GaussNewtonOptions options;
    options.keep_jacobian = keep;
    for (size_t i = 0; i < from.size(); ++i) {
      from[i] /= units[i];
      options.difference.push_back(1e-5 / units[i]);
    }
    const Residuals r = [&](std::span<const double> q) {
      std::vector<double> p(q.begin(), q.end());
      for (size_t i = 0; i < p.size(); ++i) p[i] *= units[i];
      std::vector<double> out = all(p);
      for (size_t k = 0; k < out.size(); ++k) out[k] -= measured[k];
      return out;
    };
    GaussNewtonResult fit = gauss_newton(options, r, from);
    for (size_t i = 0; i < from.size(); ++i) fit.parameters[i] *= units[i];
    return fit;
  };
  const std::vector<double> one(truth.size(), 1.0);
  const auto anew = fit_in(one, false), kept = fit_in(one, true), other = fit_in(unit, true);
  for (size_t i = 0; i < truth.size(); ++i) {
    EXPECT_NEAR(anew.parameters[i], truth[i], 1e-3) << i;
    EXPECT_NEAR(kept.parameters[i], truth[i], 1e-3) << i;
    EXPECT_NEAR(other.parameters[i], kept.parameters[i], 1e-6) << i;
  }
  EXPECT_LT(2 * kept.summary.evaluations, anew.summary.evaluations);
  EXPECT_EQ(other.summary.evaluations, kept.summary.evaluations);
}

TEST(GaussNewton, AStepThatWasCutIsNotTheEnd) {
  // One residual that a parameter can take away, 5 steps of the longest kind off, beside a large one that nothing
  // changes: each step lowers the loss by less than the tolerance.
  const auto r = [](std::span<const double> p) { return std::vector<double>{p[0] - 5, 100.0}; };
  GaussNewtonOptions options;
  options.largest_step = {1};
  options.tolerance = 1e-2;
  const auto fit = gauss_newton(options, r, std::vector<double>{0});
  EXPECT_NEAR(fit.parameters[0], 5, 0.01);
  EXPECT_EQ(fit.summary.stopped_by, "small change");
}

TEST(GaussNewton, AStepThatWasDampedIsNotTheEnd) {
  // The first steps gain next to nothing: what ends a fit is that a whole step would.
  const auto r = [](std::span<const double> p) { return std::vector<double>{p[0] - 5, 100.0}; };
  GaussNewtonOptions options;
  options.damping = 1e3;
  options.tolerance = 1e-4;
  const auto fit = gauss_newton(options, r, std::vector<double>{0});
  EXPECT_NEAR(fit.parameters[0], 5, 1);
  EXPECT_LE(0.5 * std::pow(fit.parameters[0] - 5, 2), 1e-4 * fit.summary.loss.back());
  EXPECT_EQ(fit.summary.stopped_by, "small change");
}

TEST(GaussNewton, ACurvedValleyIsFollowedToItsEnd) {
  // Rosenbrock's (1960), beside what nothing changes.
  const auto r = [](std::span<const double> p) {
    return std::vector<double>{10 * (p[1] - p[0] * p[0]), 1 - p[0], 10.0};
  };
  for (const bool keep : {false, true}) {
    GaussNewtonOptions options;
    options.keep_jacobian = keep;
    options.tolerance = 1e-5;
    options.max_iterations = 200;
    const auto fit = gauss_newton(options, r, std::vector<double>{-1.2, 1});
    EXPECT_EQ(fit.summary.stopped_by, "small change") << keep;
    EXPECT_LE(fit.summary.loss.back() - 50, 1e-3) << keep;
  }
}

TEST(GaussNewton, ItsSigmaCoversTheScatterOfRepeatedMeasurements) {
  const std::vector<double> truth = {2, 1.5, 12};
  int inside = 0, all = 0;
  for (uint64_t seed = 0; seed < 100; ++seed) {
    const auto fit = gauss_newton({}, against(swing(truth, 0.05, seed), 0.05), truth);
    for (int i = 0; i < 3; ++i, ++all) inside += std::abs(fit.parameters[i] - truth[i]) < fit.sigma(i);
  }
  EXPECT_NEAR(static_cast<double>(inside) / all, 0.683, 0.07);
}

TEST(GaussNewton, BoundsHoldAtEveryTrialAndAParameterAtItsBoundIsNotDetermined) {
  bool held = true;
  const auto r = [&](std::span<const double> p) {
    held &= p[0] >= 0 && p[0] <= 1;
    return std::vector<double>{p[0] - 3, p[1] - 2 * p[0]};
  };
  GaussNewtonOptions options;
  options.low = {0, -10};
  options.high = {1, 10};
  const auto fit = gauss_newton(options, r, std::vector<double>{0.2, 0});
  EXPECT_TRUE(held);
  EXPECT_NEAR(fit.parameters[0], 1, 1e-12);
  EXPECT_NEAR(fit.parameters[1], 2, 1e-6);
  EXPECT_TRUE(std::isinf(fit.covariance(0, 0)));
  EXPECT_TRUE(std::isfinite(fit.covariance(1, 1)));
  EXPECT_THROW(gauss_newton(options, r, std::vector<double>{2, 0}), Error);
}

TEST(GaussNewton, APriorIsOneMoreMeasurement) {
  // Measurement 0 +- 1 and prior 4 +- 0.5 meet at (0 / 1 + 4 / 0.25) / (1 + 4), variance 1 / 5; parameter 1 is free.
  const auto r = [](std::span<const double> p) { return std::vector<double>{p[0]}; };
  GaussNewtonOptions options;
  options.prior = {4, 0};
  options.prior_sigma = {0.5, INFINITY};
  const auto fit = gauss_newton(options, r, std::vector<double>{0, 7});
  EXPECT_NEAR(fit.parameters[0], 3.2, 1e-6);
  EXPECT_NEAR(fit.covariance(0, 0), 0.2, 1e-6);
  EXPECT_EQ(fit.parameters[1], 7);
  EXPECT_TRUE(std::isinf(fit.covariance(1, 1)));
}

TEST(GaussNewton, ParametersThatCannotBeAreSteppedBackFrom) {
  const auto r = [](std::span<const double> p) {
    if (p[0] > 1.2) throw numerical_error("run", "diverged", "smaller steps");
    return std::vector<double>{std::exp(p[0]) - std::exp(1)};
  };
  const auto fit = gauss_newton({}, r, std::vector<double>{-3});  // the first full step would end at 51
  EXPECT_NEAR(fit.parameters[0], 1, 1e-6);
  EXPECT_THROW(gauss_newton({}, r, std::vector<double>{2}), Error);
}

TEST(GaussNewton, InterruptedAtAnyIterationItEndsWithTheSameBits) {
  const std::vector<double> truth = {2, 1.5, 12}, start = {1, 0.2, 11};
  const Residuals r = against(swing(truth, 0.05, 3), 0.05);
  std::vector<GaussNewtonOptions> kinds(5);
  kinds[1].keep_jacobian = true;
  kinds[1].parallel = true;
  kinds[2].principal_axes = true;
  kinds[2].prior = start;
  kinds[2].prior_sigma = {1, 2, 1};
  kinds[2].most_jacobians = 3;
  kinds[2].rough_jacobian = gauss_newton({}, r, truth).jacobian;
  kinds[3].jacobian = kinds[2].rough_jacobian;
  kinds[4].low = {0, 1.8, 0};
  kinds[4].high = {9, 9, 11.9};
  kinds[4].keep_jacobian = true;
  for (size_t kind = 0; kind < kinds.size(); ++kind) {
    const std::vector<double> from = kind == 3   ? std::vector<double>{2.1, 1.4, 12.1}
                                     : kind == 4 ? std::vector<double>{1, 2, 11}
                                                 : start;
    std::vector<GaussNewtonState> states;
    const auto whole =
        gauss_newton(kinds[kind], r, from, {}, [&](const GaussNewtonState& state) { states.push_back(state); });
    ASSERT_GT(states.size(), 4u);
    for (const GaussNewtonState& state : states) {
      const auto continued = gauss_newton(kinds[kind], r, from, state);
      EXPECT_EQ(continued.parameters, whole.parameters) << kind << ", iteration " << state.iteration;
      EXPECT_EQ(continued.residuals, whole.residuals);
      EXPECT_EQ(continued.jacobian, whole.jacobian);
      EXPECT_EQ(continued.covariance, whole.covariance);
      EXPECT_EQ(continued.summary.loss, whole.summary.loss);
      EXPECT_EQ(continued.summary.evaluations, whole.summary.evaluations);
      EXPECT_EQ(continued.summary.stopped_by, whole.summary.stopped_by);
    }
    // One that has ended evaluates nothing.
    EXPECT_EQ(gauss_newton(
                  kinds[kind], [](std::span<const double>) { return std::vector<double>(); }, from, states.back())
                  .parameters,
              whole.parameters);
  }
}

}  // namespace
}  // namespace pliant

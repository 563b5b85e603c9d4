#include "fitting/solve/staying_errors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "gaussians/base/random.h"

namespace pliant {
namespace {

constexpr size_t kColumns = 800, kRows = 20;

/// Errors of variance 1 whose columns have one of variance `share` in common; a tenth of them was not measured.
std::vector<double> made(double share) {
  std::vector<double> errors;
  for (size_t t = 0; t < kRows; ++t)
    for (size_t c = 0; c < kColumns; ++c) {
      const double own = std::sqrt(1 - share) * Random(1, t * kColumns + c).normal(),
                   common = std::sqrt(share) * Random(2, c).normal();
      errors.push_back((t + c) % 10 == 0 ? 0 : own + common);
    }
  return errors;
}

/// Mean product of two errors of a column over their mean square.
double correlation(const std::vector<double>& errors) {
  double together = 0, pairs = 0, squares = 0, count = 0;
  for (size_t c = 0; c < kColumns; ++c)
    for (size_t t = 0; t < kRows; ++t)
      for (size_t s = 0; s <= t; ++s) {
        const double a = errors[t * kColumns + c], b = errors[s * kColumns + c];
        if (a == 0 || b == 0) continue;
        (s == t ? squares : together) += a * b;
        (s == t ? count : pairs) += 1;
      }
  return together / pairs / (squares / count);
}

TEST(StayingErrors, TheShareIsFoundAndWithoutItErrorsAreIndependent) {
  for (const double share : {0.0, 0.3, 0.7}) {
    std::vector<double> errors = made(share);
    EXPECT_NEAR(staying_share(errors, kColumns), share, 0.03) << share;
    even_out(errors, errors, kColumns, 0, share);
    EXPECT_NEAR(correlation(errors), 0, 0.01) << share;
    EXPECT_LT(staying_share(errors, kColumns), 0.01) << share;
  }
}

TEST(StayingErrors, WhatWasTakenForOneShareComesBackOrIsTakenForAnother) {
  const std::vector<double> errors = made(0.4);
  std::vector<double> there = errors, direct = errors;
  even_out(there, errors, kColumns, 0, 0.2);
  even_out(there, errors, kColumns, 0.2, 0.6);
  even_out(direct, errors, kColumns, 0, 0.6);
  for (size_t i = 0; i < errors.size(); ++i) ASSERT_NEAR(there[i], direct[i], 1e-12);
  even_out(there, errors, kColumns, 0.6, 0);
  for (size_t i = 0; i < errors.size(); ++i) ASSERT_NEAR(there[i], errors[i], 1e-12);
}

TEST(StayingErrors, AnErrorThatIsAloneInItsColumnWeighsLessForWhatStaysIsInIt) {
  std::vector<double> errors = {1, -2, 3};
  EXPECT_EQ(staying_share(errors, 3), 0);
  even_out(errors, errors, 3, 0, 0.75);
  EXPECT_EQ(errors, (std::vector<double>{0.5, -1, 1.5}));
}

// A slope through points that are all off by the same is found as well as if they were not (Gauss and Markov), and
// better than by ordinary least squares.
TEST(StayingErrors, AFitWithoutThemIsTheBestLinearOne) {
  const std::vector<double> errors = made(0.8);
  double ordinary = 0, evened = 0;
  for (size_t c = 0; c < kColumns; ++c) {
    std::vector<double> by(kRows), error(kRows);
    for (size_t t = 0; t < kRows; ++t) {
      by[t] = 1 + 0.1 * t;
      error[t] = errors[t * kColumns + c];
    }
    const auto slope = [&] {
      double up = 0, down = 0;
      for (size_t t = 0; t < kRows; ++t)
        if (errors[t * kColumns + c] != 0) {
          up += by[t] * error[t];
          down += by[t] * by[t];
        }
      return up / down;
    };
    ordinary += std::pow(slope(), 2);
    even_out(by, error, 1, 0, 0.8);
    even_out(error, error, 1, 0, 0.8);
    evened += std::pow(slope(), 2);
  }
  EXPECT_LT(evened, 0.4 * ordinary);
}

}  // namespace
}  // namespace pliant

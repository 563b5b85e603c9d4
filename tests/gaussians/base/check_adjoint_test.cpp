// The judge of all adjoints: it must pass right ones and refuse slightly wrong ones.

#include "tests/check_adjoint.h"

#include <gtest/gtest.h>

namespace pliant {
namespace {

using Values = std::vector<double>;
constexpr double kTolerance = 1e-6;

// y = (x0 x1, exp(x1) sin(x2), x0^3 / x2): an asymmetric 3 x 3 Jacobian.
Values product(const Values& x) { return {x[0] * x[1], std::exp(x[1]) * std::sin(x[2]), x[0] * x[0] * x[0] / x[2]}; }

void jacobian(const Values& x, double J[3][3]) {
  const double e = std::exp(x[1]), q = x[0] * x[0];
  const double rows[3][3] = {
      {x[1], x[0], 0}, {0, e * std::sin(x[2]), e * std::cos(x[2])}, {3 * q / x[2], 0, -q * x[0] / (x[2] * x[2])}};
  std::copy(&rows[0][0], &rows[0][0] + 9, &J[0][0]);
}

const Values kPoint = {0.7, -1.3, 2.1};

// J^T adj_y with entry (row, column) of J multiplied by `factor`.
auto product_adjoint(int row = 0, int column = 0, double factor = 1, bool transposed = false) {
  return [=](const Values& x, const Values& adj_y) {
    double J[3][3];
    jacobian(x, J);
    J[row][column] *= factor;
    Values out(3, 0.0);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) out[j] += (transposed ? J[j][i] : J[i][j]) * adj_y[i];
    return out;
  };
}

TEST(CheckAdjoint, AcceptsTheRightAdjoint) {
  const AdjointCheck check = check_adjoint(product, product_adjoint(), kPoint);
  EXPECT_LT(check.worst, 1e-9) << check.message;
}

TEST(CheckAdjoint, RefusesAnyEntryThatIsOffByOnePartInHundredThousand) {
  double J[3][3];
  jacobian(kPoint, J);
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      if (J[row][column] == 0) continue;
      const AdjointCheck check = check_adjoint(product, product_adjoint(row, column, 1 + 1e-5), kPoint);
      EXPECT_GT(check.worst, 5 * kTolerance) << row << ' ' << column;
      EXPECT_NE(check.message.find("input " + std::to_string(column)), std::string::npos) << check.message;
    }
  }
}

TEST(CheckAdjoint, RefusesATransposedJacobianAMissingTermAndValuesThatAreNotFinite) {
  EXPECT_GT(check_adjoint(product, product_adjoint(0, 0, 1, true), kPoint).worst, 0.1);
  EXPECT_GT(check_adjoint(product, product_adjoint(1, 2, 0), kPoint).worst, 0.1);
  EXPECT_EQ(check_adjoint(product, product_adjoint(1, 2, NAN), kPoint).worst, INFINITY);
}

TEST(CheckAdjoint, AcceptsSteepFlatAndConstantFunctions) {
  // Curvature at 1 / 500 of the default step's scale, a function with a zero derivative, a constant.
  const auto f = [](const Values& x) { return Values{std::sin(500 * x[0]), x[1] * x[1], 1e4}; };
  const auto adjoint = [](const Values& x, const Values& y) {
    return Values{500 * std::cos(500 * x[0]) * y[0], 2 * x[1] * y[1]};
  };
  const AdjointCheck check = check_adjoint(f, adjoint, {0.4, 0.0});
  EXPECT_LT(check.worst, kTolerance) << check.message;
}

TEST(CheckAdjoint, SamplesLargeProblemsAndStillSeesOneWrongInput) {
  // Row i of the Jacobian couples x_i and x_(i + 1); of 400 inputs and outputs only some are tried one by one.
  const int n = 400;
  const auto f = [&](const Values& x) {
    Values y(n);
    for (int i = 0; i < n; ++i) y[i] = std::cos(x[i]) * x[(i + 1) % n];
    return y;
  };
  const auto adjoint = [&](double wrong) {
    return [&, wrong](const Values& x, const Values& y) {
      Values out(n, 0.0);
      for (int i = 0; i < n; ++i) {
        out[i] -= std::sin(x[i]) * x[(i + 1) % n] * y[i];
        out[(i + 1) % n] += std::cos(x[i]) * y[i];
      }
      out[371] *= wrong;
      return out;
    };
  };
  Values x(n);
  for (int i = 0; i < n; ++i) x[i] = Random(3, i).normal();
  AdjointCheckOptions options;
  options.inputs = 20;
  options.unit_cotangents = 10;
  EXPECT_LT(check_adjoint(f, adjoint(1), x, options).worst, 1e-8);
  EXPECT_GT(check_adjoint(f, adjoint(1.01), x, options).worst, 1e-5) << "the random directions see every input";
}

}  // namespace
}  // namespace pliant

#include "fitting/solve/correlation.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <vector>

#include "gaussians/base/random.h"

namespace pliant {
namespace {

const std::vector<Vec3f> kOrigin = {Vec3f::Zero()};

TEST(ErrorCorrelation, FactorIsOneForWhiteNoiseAndThatOfAnAutoregressionOtherwise) {
  // x_k = a x_(k-1) + noise has autocorrelations a^lag: factor (1 + a) / (1 - a) = 3.
  std::vector<double> white, slow(2);
  for (int k = 0; k < 20000; ++k) {
    for (int c = 0; c < 2; ++c) {
      white.push_back(Random(k, c).normal());
      slow.push_back(0.5 * slow[slow.size() - 2] + white.back());
    }
  }
  EXPECT_NEAR(ErrorCorrelation(white, kOrigin, 2).factor(), 1, 0.1);
  EXPECT_NEAR(ErrorCorrelation(slow, kOrigin, 2).factor(), 3, 0.4);
}

constexpr size_t kPoints = 300, kInstants = 60;

std::vector<Vec3f> on_a_line(size_t count) {
  std::vector<Vec3f> place;
  for (size_t k = 0; k < count; ++k) place.push_back(Vec3d(0.01 * static_cast<double>(k), 0, 0).cast<float>());
  return place;
}

/// [rows, points, 2] of unit variance: the mean of `width` neighbouring values, which has factor `width`, with an
/// autoregression a in time, which has factor (1 + a) / (1 - a).
std::vector<double> noise(size_t width, double a, uint64_t seed) {
  std::vector<double> out;
  for (size_t t = 0; t < kInstants; ++t)
    for (size_t k = 0; k < kPoints; ++k)
      for (size_t c = 0; c < 2; ++c) {
        double sum = 0;
        for (size_t j = 0; j < width; ++j)
          sum += Random(seed + 2 * t + c, k + j).normal() / std::sqrt(static_cast<double>(width));
        out.push_back(t == 0 ? sum : a * out[out.size() - 2 * kPoints] + std::sqrt(1 - a * a) * sum);
      }
  return out;
}

TEST(CorrelationFactor, OfPointsIsOneForWhiteNoiseAndTheProductWhereTimeAndSpaceAreApart) {
  const std::vector<Vec3f> place = on_a_line(kPoints);
  EXPECT_NEAR(ErrorCorrelation(noise(1, 0, 1), place, 2).factor(), 1, 0.1);
  EXPECT_NEAR(ErrorCorrelation(noise(2, 0, 1), place, 2).factor(), 2, 0.2);
  EXPECT_NEAR(ErrorCorrelation(noise(4, 0, 1), place, 2).factor(), 4, 0.4);
  EXPECT_NEAR(ErrorCorrelation(noise(1, 0.5, 1), place, 2).factor(), 3, 0.4);
  EXPECT_NEAR(ErrorCorrelation(noise(2, 0.5, 1), place, 2).factor(), 6, 0.9);
}

TEST(CorrelationFactor, OfASumIsTheMeanOfBothNotAProduct) {
  // One part lasts and is each point's own, one is shared by four neighbours and gone with the row: (3 + 4) / 2.
  std::vector<double> sum = noise(1, 0.5, 1);
  const std::vector<double> other = noise(4, 0, 1000);
  for (size_t k = 0; k < sum.size(); ++k) sum[k] += other[k];
  EXPECT_NEAR(ErrorCorrelation(sum, on_a_line(kPoints), 2).factor(), 3.5, 0.4);
}

TEST(CorrelationFactor, IsThatOfAllPointsWhereOnlySomeAreLookedAt) {
  // 3000 points with errors that 60 in a row have in common.
  constexpr size_t kMany = 3000;
  std::vector<double> residuals;
  for (size_t t = 0; t < 100; ++t)
    for (size_t k = 0; k < kMany; ++k) {
      double sum = 0;
      for (size_t j = 0; j < 60; ++j) sum += Random(t, k + j).normal();
      residuals.push_back(sum);
    }
  EXPECT_NEAR(ErrorCorrelation(residuals, on_a_line(kMany), 1).factor(), 60, 9);
}

TEST(CorrelationFactor, PointsWithoutErrorsHaveNoSay) {
  EXPECT_EQ(ErrorCorrelation(std::vector<double>(30, 0.0), on_a_line(3), 1).factor(), 1);
  EXPECT_EQ(ErrorCorrelation(std::vector<double>{1, 0, 0}, on_a_line(3), 1).factor(), 1);
}

/// [rows, points, 2; columns] of J: all alike, and waves of so many rows or points.
Eigen::MatrixXd waves(double rows, double points) {
  Eigen::MatrixXd out(kInstants * kPoints * 2, 3);
  for (size_t t = 0; t < kInstants; ++t)
    for (size_t k = 0; k < kPoints; ++k)
      for (size_t c = 0; c < 2; ++c)
        out.row((t * kPoints + k) * 2 + c) << 1, std::cos(2 * M_PI * t / rows), std::cos(2 * M_PI * k / points);
  return out;
}

TEST(ErrorCorrelation, AGradientsVarianceIsTheSpectrumOfTheErrorsWhereItVaries) {
  const std::vector<Vec3f> place = on_a_line(kPoints);
  const Eigen::MatrixXd J = waves(12, 15);
  const Eigen::VectorXd alone = (J.transpose() * J).diagonal();
  const auto ratio = [&](size_t width, double a) {
    return Eigen::Vector3d(
        ErrorCorrelation(noise(width, a, 1), place, 2).of_gradient(J).diagonal().cwiseQuotient(alone));
  };
  // Of an autoregression (1 - a^2) / (1 + a^2 - 2 a cos w).
  const Eigen::Vector3d slow = ratio(1, 0.5);
  EXPECT_NEAR(slow[0], 3, 0.5);
  EXPECT_NEAR(slow[1], 0.75 / (1.25 - std::cos(2 * M_PI / 12)), 0.3);
  EXPECT_NEAR(slow[2], 3, 0.5);
  // Of the mean of four (sin 2w / sin(w / 2))^2 / 4.
  const Eigen::Vector3d wide = ratio(4, 0);
  EXPECT_NEAR(wide[0], 4, 0.5);
  EXPECT_NEAR(wide[1], 4, 0.5);
  EXPECT_NEAR(wide[2], std::pow(std::sin(4 * M_PI / 15) / std::sin(M_PI / 15), 2) / 4, 0.5);
  // Errors that are independent have that of J^T J, and no direction has less.
  const Eigen::Vector3d white = ratio(1, 0);
  EXPECT_NEAR((white - Eigen::Vector3d::Ones()).cwiseAbs().maxCoeff(), 0, 0.15);
  EXPECT_GT(white.minCoeff(), 0.95);
  EXPECT_GT(ErrorCorrelation(noise(1, 0.5, 1), place, 2).of_gradient(waves(2, 15))(1, 1) / (kInstants * kPoints * 2),
            0.95);
}

TEST(ErrorCorrelation, EachPointHasErrorsOfItsOwnSize) {
  std::vector<double> errors = noise(1, 0, 1);
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(kInstants * kPoints * 2, 2);
  for (size_t r = 0; r < errors.size(); ++r) {
    const bool loud = r / 2 % kPoints < 100;
    errors[r] *= loud ? 3 : 1;
    J(static_cast<Eigen::Index>(r), loud) = 1;
  }
  const Eigen::MatrixXd found = ErrorCorrelation(errors, on_a_line(kPoints), 2).of_gradient(J);
  EXPECT_NEAR(found(0, 0) / (kInstants * 200 * 2), 1, 0.15);
  EXPECT_NEAR(found(1, 1) / (kInstants * 100 * 2), 9, 1.3);
}

TEST(CovarianceWith, IsThatOfManyFitsToErrorsThatGoTogether) {
  // Fits of three waves with a prior, to errors of neighbours in time and space: their spread against the one that is
  // expected.
  const std::vector<Vec3f> place = on_a_line(kPoints);
  const Eigen::MatrixXd J = waves(12, 15);
  Eigen::Matrix3d information = J.transpose() * J;
  const double prior = 2 * information(0, 0);
  information += prior * Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d inverse = information.inverse();
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero(), expected = spread;
  constexpr int kFits = 30;
  for (int fit = 0; fit < kFits; ++fit) {
    const std::vector<double> errors = noise(2, 0.5, 1000 * (1 + static_cast<uint64_t>(fit)));
    // The truth is as likely as the prior says.
    Random random(7, fit);
    const Eigen::Vector3d truth = Eigen::Vector3d(random.normal(), random.normal(), random.normal()) / std::sqrt(prior);
    const Eigen::Vector3d found =
        inverse * (J.transpose() * (J * truth + Eigen::Map<const Eigen::VectorXd>(errors.data(), J.rows())));
    spread += (found - truth) * (found - truth).transpose() / kFits;
    expected += covariance_with(ErrorCorrelation(errors, place, 2), J, inverse) / kFits;
  }
  for (int p = 0; p < 3; ++p)
    EXPECT_NEAR(std::log(spread(p, p) / expected(p, p)), 0, 0.7) << p;  // 30 fits: 26 % each way
  // What nothing determines stays so.
  Eigen::MatrixXd open = inverse;
  open.row(1).setZero();
  open.col(1).setZero();
  open(1, 1) = INFINITY;
  const Eigen::MatrixXd still = covariance_with(ErrorCorrelation(noise(2, 0.5, 1), place, 2), J, open);
  EXPECT_TRUE(std::isinf(still(1, 1)) && std::isfinite(still(0, 0)) && std::isfinite(still(0, 2)));
}

TEST(Unexplained, OfWhiteErrorsIsTheirRootMeanSquareOfSharedOnesWider) {
  const std::vector<Vec3f> place = on_a_line(kPoints);
  EXPECT_NEAR(unexplained(noise(1, 0, 1), place, 2), 1, 0.05);
  EXPECT_NEAR(unexplained(noise(4, 0, 1), place, 2), 2, 0.1);
}

}  // namespace
}  // namespace pliant

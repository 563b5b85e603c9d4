// Derivatives of functions of singular values, and of the polar factor, where singular values are apart, nearly equal,
// exactly equal, zero and negative.

#include "gaussians/base/spectral.h"

#include <gtest/gtest.h>

#include <functional>

#include "tests/check_adjoint.h"

namespace pliant {
namespace {

using Values = std::vector<double>;

Mat3d rotation(uint64_t seed) {
  Random random(seed);
  return Eigen::Quaterniond(random.normal(), random.normal(), random.normal(), random.normal())
      .normalized()
      .toRotationMatrix();
}

Mat3d matrix(const Values& x) { return Eigen::Map<const Mat3d>(x.data()); }
Values values(const Mat3d& M) { return {M.data(), M.data() + 9}; }
Mat3d with_sigma(const Vec3d& sigma, uint64_t seed) {
  return rotation(seed) * sigma.asDiagonal() * rotation(seed + 1000).transpose();
}

/// f and its derivatives at given singular values, and the map F -> U diag(f) V^T without an SVD where there is one.
struct Map {
  const char* name;
  std::function<void(const Vec3d&, Vec3d&, Mat3d&)> f;
  std::function<Mat3d(const Mat3d&)> closed;
  bool needs_positive = false;
};

const std::vector<Map>& maps() {
  static const std::vector<Map> all = {{"F F^T F",
                                        [](const Vec3d& s, Vec3d& f, Mat3d& J) {
                                          f = s.array().cube();
                                          J = Vec3d(3 * s.array().square()).asDiagonal();
                                        },
                                        [](const Mat3d& F) -> Mat3d { return F * F.transpose() * F; }},
                                       {"|F|^2 F",
                                        [](const Vec3d& s, Vec3d& f, Mat3d& J) {
                                          f = s.squaredNorm() * s;
                                          J = s.squaredNorm() * Mat3d::Identity() + 2 * s * s.transpose();
                                        },
                                        [](const Mat3d& F) -> Mat3d { return F.squaredNorm() * F; }},
                                       {"cofactor",
                                        [](const Vec3d& s, Vec3d& f, Mat3d& J) {
                                          f = Vec3d(s[1] * s[2], s[0] * s[2], s[0] * s[1]);
                                          J << 0, s[2], s[1], s[2], 0, s[0], s[1], s[0], 0;
                                        },
                                        [](const Mat3d& F) -> Mat3d { return cofactor(F); }},
                                       {"neo-Hookean stress",
                                        [](const Vec3d& s, Vec3d& f, Mat3d& J) {
                                          const double l = std::log(s.prod());
                                          const Vec3d r = s.cwiseInverse();
                                          f = 0.7 * (s - r) + 1.3 * l * r;
                                          J = 1.3 * r * r.transpose();
                                          for (int i = 0; i < 3; ++i)
                                            J(i, i) += 0.7 * (1 + r[i] * r[i]) - 1.3 * l * r[i] * r[i];
                                        },
                                        [](const Mat3d& F) -> Mat3d {
                                          const Mat3d inverse = cofactor(F) / F.determinant();
                                          return 0.7 * (F - inverse) + 1.3 * std::log(F.determinant()) * inverse;
                                        },
                                        true},
                                       {"Hencky strain",
                                        [](const Vec3d& s, Vec3d& f, Mat3d& J) {
                                          f = s.array().log();
                                          J = s.cwiseInverse().asDiagonal();
                                        },
                                        nullptr, true},
                                       {"polar rotation",
                                        [](const Vec3d&, Vec3d& f, Mat3d& J) {
                                          f.setOnes();
                                          J.setZero();
                                        },
                                        [](const Mat3d& F) -> Mat3d { return polar_rotation<double>(F); }, true},
                                       {"an asymmetric coupling",
                                        [](const Vec3d& s, Vec3d& f, Mat3d& J) {
                                          // f_i = s_i^2 sum s: J is not symmetric, so that a forgotten transpose shows.
                                          f = s.array().square() * s.sum();
                                          J = Mat3d(Vec3d(2 * s * s.sum()).asDiagonal()) +
                                              Vec3d(s.array().square()) * Vec3d::Ones().transpose();
                                        },
                                        nullptr, true}};
  return all;
}

/// Worst error of spectral_adjoint for a map at F.
AdjointCheck check(const Map& map, const Mat3d& F) {
  Vec3d f;
  Mat3d J;
  return check_adjoint(
      [&](const Values& x) {
        if (map.closed) return values(map.closed(matrix(x)));
        const Svd<double> s = svd<double>(matrix(x));
        map.f(s.sigma, f, J);
        return values(s.U * f.asDiagonal() * s.V.transpose());
      },
      [&](const Values& x, const Values& y) {
        const Svd<double> s = svd<double>(matrix(x));
        map.f(s.sigma, f, J);
        return values(spectral_adjoint<double>(s, f, J, matrix(y)));
      },
      values(F));
}

void check_all(const std::vector<Vec3d>& sigmas, bool positive) {
  for (const Map& map : maps()) {
    if (map.needs_positive && !positive) continue;
    uint64_t seed = 1;
    for (const Vec3d& sigma : sigmas) {
      const AdjointCheck result = check(map, with_sigma(sigma, seed++));
      EXPECT_LT(result.worst, 1e-8) << map.name << " at " << sigma.transpose() << ": " << result.message;
    }
  }
}

TEST(Spectral, AdjointAgreesWithDifferencesWhereSingularValuesAreApart) {
  check_all({{0.5, 1.0, 1.7}, {0.2, 0.9, 3.0}}, true);
}

TEST(Spectral, AdjointAgreesWithDifferencesWhereSingularValuesAreExactlyEqual) {
  check_all({{1, 1, 1}, {0.6, 0.6, 0.6}, {0.4, 1.1, 1.1}, {0.7, 0.7, 1.3}}, true);
  for (const Map& map : maps()) {
    const AdjointCheck result = check(map, Mat3d::Identity());
    EXPECT_LT(result.worst, 1e-8) << map.name << ": " << result.message;
  }
}

TEST(Spectral, AdjointAgreesWithDifferencesWhereSingularValuesAreNearlyEqual) {
  for (const double gap : {1e-14, 1e-11, 1e-9, 1e-7, 1e-6, 1e-5, 3e-5, 1e-4, 1e-3})
    check_all({{0.8, 0.8 + gap, 1.4}, {0.9, 0.9 + gap, 0.9 + 3 * gap}}, true);
}

TEST(Spectral, AdjointAgreesWithDifferencesForZeroAndNegativeSingularValues) {
  check_all({{-0.3, 0.8, 1.2},
             {-0.5, 0.5, 1.1},
             {-0.5, 0.5 + 1e-9, 1.1},
             {-0.5, 0.5, 0.5},
             {0, 0.6, 1},
             {0, 0, 1},
             {0, 0, 0}},
            false);
}

TEST(Spectral, DerivativeAndAdjointAreTransposesOfEachOther) {
  const Map& map = maps().back();
  Vec3d f;
  Mat3d J;
  for (uint64_t seed = 0; seed < 20; ++seed) {
    Random random(seed);
    Mat3d F, dF, adj;
    for (int k = 0; k < 9; ++k) {
      F.data()[k] = random.normal();
      dF.data()[k] = random.normal();
      adj.data()[k] = random.normal();
    }
    const Svd<double> s = svd(F);
    map.f(s.sigma, f, J);
    const double left = spectral_derivative<double>(s, f, J, dF).cwiseProduct(adj).sum();
    const double right = spectral_adjoint<double>(s, f, J, adj).cwiseProduct(dF).sum();
    EXPECT_NEAR(left, right, 1e-11 * (1 + std::abs(left)));
  }
}

TEST(Spectral, WithoutALimitTheResultStaysBounded) {
  // f = |sigma| is not a function of F that is smooth where sigma_i + sigma_j = 0.
  Svd<double> s = svd<double>(with_sigma({-0.5, 0.5, 1.0}, 7));
  const Mat3d out = spectral_derivative<double>(s, s.sigma.cwiseAbs(), Mat3d::Identity(), Mat3d::Ones());
  EXPECT_TRUE(out.allFinite());
  EXPECT_LT(out.norm(), 100);
}

TEST(Polar, AdjointAgreesWithDifferencesAtEqualAndNearlyEqualStretches) {
  for (const Vec3d& sigma : {Vec3d(1, 1, 1), Vec3d(2, 2, 2), Vec3d(0.5, 1, 1), Vec3d(1, 1 + 1e-9, 1.5),
                             Vec3d(1, 1 + 1e-9, 1 - 1e-9), Vec3d(0.05, 0.05, 1)}) {
    AdjointCheckOptions options;
    options.step = 2e-3;
    const AdjointCheck result =
        check_adjoint([](const Values& x) { return values(polar_rotation<double>(matrix(x))); },
                      [](const Values& x, const Values& y) {
                        return values(polar_rotation_derivative<double>(polar<double>(matrix(x)), matrix(y)));
                      },
                      values(with_sigma(sigma, 3)), options);
    EXPECT_LT(result.worst, 1e-8) << sigma.transpose() << ": " << result.message;
  }
}

}  // namespace
}  // namespace pliant

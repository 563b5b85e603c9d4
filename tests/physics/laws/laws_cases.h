#pragma once

#include <vector>

#include "gaussians/base/polar.h"
#include "gaussians/base/random.h"
#include "physics/laws/law.h"

namespace pliant::fixture {

constexpr double kMu = 3e4, kLambda = 5e4;

constexpr Law kAllLaws[] = {Law::kFixedCorotated, Law::kNeoHookean, Law::kHencky,     Law::kMetal, Law::kSand,
                            Law::kSnow,           Law::kFoam,       Law::kPlasticine, Law::kFluid, Law::kViscoelastic};

/// A material of every law that yields at some per cent of strain for the Lame parameters above.
inline Material material_of(Law law) {
  Material m;
  m.law = law;
  m.yield_stress = 2e3;
  m.hardening = law == Law::kPlasticine ? -8e3 : 5e3;
  m.plastic_viscosity = 300;
  m.friction_angle = 32;
  m.dynamic_viscosity = 2;
  m.branch_shear = 2e4;
  m.branch_lambda = 1e4;
  m.branch_viscosity = 400;
  return m;
}

inline Mat3d random_matrix(uint64_t element, double spread) {
  Random random(11, element);
  Mat3d F;
  for (int k = 0; k < 9; ++k) F(k / 3, k % 3) = (k % 4 == 0) + spread * random.normal();
  return F;
}

inline Mat3d random_rotation(uint64_t element) { return polar_rotation(random_matrix(element + 1000, 2.0)); }

/// U diag(a, b, c) V^T with random rotations.
inline Mat3d with_stretches(uint64_t element, double a, double b, double c) {
  return random_rotation(2 * element) * Vec3d(a, b, c).asDiagonal() * random_rotation(2 * element + 1).transpose();
}

/// Where stress laws are smooth: random, inverted, strongly stretched, at and near equal singular values.
inline std::vector<Mat3d> smooth_states() {
  std::vector<Mat3d> F;
  for (int i = 0; i < 30; ++i) F.push_back(random_matrix(i, 0.05));
  for (int i = 30; i < 60; ++i) F.push_back(random_matrix(i, 0.2));
  for (int i = 0; i < 4; ++i) {
    F.push_back(with_stretches(i, 1.2, 1.2, 1.2));
    F.push_back(with_stretches(i, 0.8, 0.8, 1.1));
    F.push_back(with_stretches(i, 0.9, 0.9 + 1e-9, 0.9 - 2e-9));
    F.push_back(with_stretches(i, 0.9, 0.9 + 1e-5, 1.3));
    F.push_back(with_stretches(i, 0.1, 1, 20));
    F.push_back(with_stretches(i, 5, 6, 9));
    F.push_back(with_stretches(i, 0.25, 0.3, 0.4));
    F.push_back(with_stretches(i, -0.3, 0.8, 1.3));
    F.push_back(with_stretches(i, -0.5, 1.1, 1.1));
  }
  F.push_back(Mat3d::Identity());
  F.push_back(random_rotation(77));
  return F;
}

/// Distance, in stretch or volume, from where a law's logarithm or pressure changes its branch.
inline double smooth_margin(Law law, const Mat3d& F) {
  const Vec3d sigma = svd(F).sigma;
  const double J = F.determinant();
  double margin = sigma[0] + sigma[1];  // the polar factor
  if (law == Law::kFluid) return std::min(std::abs(J - 1), std::abs(J - 0.1));
  if (law == Law::kNeoHookean) return std::abs(J - 0.001);
  return std::min(margin, (sigma.array() - 0.01).abs().minCoeff());
}

}  // namespace pliant::fixture

// Laws of transfers whose affine velocity is damped.

#include <gtest/gtest.h>

#include "physics/simulate/simulate.h"
#include "tests/physics/shapes.h"

namespace pliant {
namespace {

using State = BasicSimulationState<double>;

/// A block whose particles shear and spin at rates that elasticity does not change: no stiffness to speak of.
State spinning(const BasicParticles<double>& p) {
  State s = initial_state(p);
  Mat3d C = Mat3d::Zero();
  C(0, 1) = 6;
  C(1, 0) = 2;
  for (size_t i = 0; i < p.size(); ++i) {
    s.C[i] = C;
    s.v[i] = C * (p.position[i] - Vec3d(0.02, 0.02, 0.02));
  }
  return s;
}

TEST(AffineDamping, RpicKeepsTheSpinAndPicNothing) {
  auto p = fixture::block<double>({0.04, 0.04, 0.04}, 0.01, 1.0, 1e-3);
  SimulateOptions options;
  options.fps = 1000;
  options.duration = 0.001;
  options.substeps = 1;
  options.gravity.setZero();
  options.courant_cap = 1;
  const auto inner = [&](const State& s) {
    Mat3d mean = Mat3d::Zero();
    int count = 0;
    for (size_t i = 0; i < p.size(); ++i)
      if ((p.position[i] - Vec3d::Constant(0.02)).cwiseAbs().maxCoeff() < 0.01) {
        mean += s.C[i];
        ++count;
      }
    return Mat3d(mean / count);
  };
  options.strain_rate_damping = 1000 * std::log(4.0);
  const Mat3d rpic = inner(simulate<double>(options, p, {}, spinning(p)).state);
  EXPECT_NEAR(rpic(0, 1) + rpic(1, 0), 8.0 / 4, 1e-2);
  EXPECT_NEAR(rpic(0, 1) - rpic(1, 0), 4.0, 1e-2);
  options.pic = true;
  EXPECT_EQ(inner(simulate<double>(options, p, {}, spinning(p)).state).norm(), 0);
}

}  // namespace
}  // namespace pliant

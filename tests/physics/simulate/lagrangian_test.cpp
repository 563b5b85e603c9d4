// Elastic bodies on a Lagrangian grid neither tear nor forget their shape; beside the Eulerian grid where that says
// something.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "gaussians/base/error.h"
#include "physics/simulate/simulate.h"
#include "tests/physics/shapes.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

using State = BasicSimulationState<double>;
constexpr double kPi = 3.14159265358979324;

struct Motion {
  BasicParticles<double> particles;
  SimulateOptions options;
  std::vector<Interaction> script;
  std::vector<State> states;

  Motion(const Vec3d& size, double dx, double jitter, GridKind grid)
      : particles(testing::block<double>(size, dx, jitter, 1e5)) {
    options.gravity.setZero();
    options.grid = grid;
    options.fps = 50;
  }
  void go(double duration, const State& start) {
    options.duration = duration;
    states.clear();
    simulate<double>(options, particles, script, start, [&](const State& s) { return states.push_back(s), true; });
  }
  State deformed(const std::function<Vec3d(const Vec3d&)>& place, const std::function<Mat3d(const Vec3d&)>& F) const {
    State state = initial_state(particles);
    for (size_t i = 0; i < state.size(); ++i) {
      state.x[i] = place(particles.position[i]);
      state.F[i] = F(particles.position[i]);
    }
    return state;
  }
  Vec3d centre(const State& s) const {
    Vec3d sum = Vec3d::Zero();
    for (size_t i = 0; i < s.size(); ++i) sum += particles.mass[i] * s.x[i];
    return sum / particles.total_mass();
  }
  /// Angular momentum about the centre, the affine part of the particles' motion included.
  Vec3d angular(const State& s) const {
    const double quarter = 0.25 * particles.cell_size * particles.cell_size;
    const Vec3d middle = centre(s);
    Vec3d sum = Vec3d::Zero();
    for (size_t i = 0; i < s.size(); ++i) {
      Vec3d own = (s.x[i] - middle).cross(s.v[i]);
      for (int k = 0; k < 3; ++k) own += quarter * s.F[i].col(k).cross(s.C[i].col(k));
      sum += particles.mass[i] * own;
    }
    return sum;
  }
  /// Largest distance of a particle from where it lies at rest, after the body is laid over its rest shape.
  double distance_from_rest(const State& s) const {
    Eigen::Matrix3Xd rest(3, s.size()), now(3, s.size());
    for (size_t i = 0; i < s.size(); ++i) {
      rest.col(i) = particles.position[i];
      now.col(i) = s.x[i];
    }
    const Eigen::Matrix4d fit = Eigen::umeyama(now, rest, false);
    const Eigen::Matrix3Xd laid = (fit.topLeftCorner<3, 3>() * now).colwise() + fit.topRightCorner<3, 1>().eval();
    return (laid - rest).colwise().norm().maxCoeff();
  }
};

Interaction pin_left(double x) {
  Interaction pin;
  pin.type = InteractionType::kPin;
  pin.region = Region::half_space(Vec3d(x, 0, 0), Vec3d(1, 0, 0));
  return pin;
}

}  // namespace

// Patch test: an affine motion is an exact solution, so that uniformly strained matter in the middle of a body feels no
// force, and a velocity that is affine in the rest position strains it exactly.
TEST(Lagrangian, UniformStrainIsInEquilibriumAndAnAffineVelocityStrainsExactly) {
  const Mat3d A = (Mat3d() << 1.2, 0.1, -0.05, 0.02, 0.9, 0.1, 0.03, -0.08, 1.1).finished();
  Motion regular(Vec3d::Constant(0.12), 0.01, 0, GridKind::kLagrangian);
  regular.options.substeps = 1;
  regular.options.fps = 1e4;
  regular.go(1e-4, regular.deformed([&](const Vec3d& X) { return A * X; }, [&](const Vec3d&) { return A; }));
  double middle = 0, surface = 0;
  for (size_t i = 0; i < regular.particles.size(); ++i) {
    const Vec3d inside = (regular.particles.position[i].array() - 0.06).abs();
    (inside.maxCoeff() < 0.02 ? middle : surface) =
        std::max(inside.maxCoeff() < 0.02 ? middle : surface, regular.states.back().v[i].norm());
  }
  EXPECT_LT(middle, 1e-12 * surface);

  Motion uneven(Vec3d::Constant(0.06), 0.01, 1, GridKind::kLagrangian);
  uneven.options.substeps = 1;
  uneven.options.fps = 1e6;
  const Mat3d L = (Mat3d() << 3, 1, -2, 0.5, -1, 2, 1, 1, 0.3).finished();
  State start = initial_state(uneven.particles);
  for (size_t i = 0; i < start.size(); ++i) {
    start.v[i] = L * start.x[i] + Vec3d(1, 2, 3);
    start.C[i] = L;
  }
  uneven.go(1e-6, start);
  for (const Mat3d& F : uneven.states.back().F) EXPECT_LT((F - Mat3d::Identity() - 1e-6 * L).norm(), 1e-15);
}

TEST(Lagrangian, AFreeSpinLosesOnePercentOfItsAngularMomentumInTenTurns) {
  Motion spin(Vec3d(0.08, 0.03, 0.03), 0.01, 1, GridKind::kLagrangian);
  const double omega = 2 * kPi * 5;
  State start = initial_state(spin.particles);
  const Vec3d middle = spin.centre(start), axis(0, 0, omega);
  for (size_t i = 0; i < start.size(); ++i) {
    start.v[i] = axis.cross(Vec3d(start.x[i] - middle));
    start.C[i] << 0, -omega, 0, omega, 0, 0, 0, 0, 0;
  }
  spin.go(2.0, start);
  const Vec3d before = spin.angular(spin.states.front()), after = spin.angular(spin.states.back());
  EXPECT_LT((after - before).norm(), 0.012 * before.norm());
  EXPECT_LT((spin.centre(spin.states.back()) - middle).norm(), 1e-9);
  // Half a turn is opposite, and it is as long as the centrifugal force makes it.
  EXPECT_GT((spin.states[5].x[0] - start.x[0]).norm(), 1.9 * (start.x[0] - middle).norm());
  EXPECT_LT(spin.distance_from_rest(spin.states.back()), 0.001);
}

TEST(Lagrangian, ABarBentIntoARingAndLetGoIsStraightAgain) {
  const double length = 0.24, radius = length / (2 * kPi);
  Motion bar(Vec3d(length, 0.02, 0.02), 0.01, 1, GridKind::kLagrangian);
  bar.options.damping_time = 0.2;
  // Its middle line becomes a circle; cross sections stay plane.
  const auto angle = [&](const Vec3d& X) { return X.x() / radius; };
  const auto place = [&](const Vec3d& X) {
    const double r = radius - (X.z() - 0.01), a = angle(X);
    return Vec3d(r * std::sin(a), X.y(), radius - r * std::cos(a));
  };
  const auto F = [&](const Vec3d& X) {
    const double r = radius - (X.z() - 0.01), a = angle(X);
    Mat3d f = Mat3d::Identity();
    f.col(0) = r / radius * Vec3d(std::cos(a), 0, std::sin(a));
    f.col(2) = Vec3d(-std::sin(a), 0, std::cos(a));
    return f;
  };
  bar.go(4.0, bar.deformed(place, F));
  EXPECT_GT(bar.distance_from_rest(bar.states.front()), 0.3 * length);
  // Places and deformation of the start belong together up to the grid's resolution, and so do those of the end.
  EXPECT_LT(bar.distance_from_rest(bar.states.back()), 3e-3 * length);
}

TEST(Lagrangian, APulledStripStaysWholeAndStraightAndComesBackAndOnAnEulerianGridItTears) {
  const double length = 0.12;
  double reached[2], left[2], aside[2];
  for (const GridKind grid : {GridKind::kEulerian, GridKind::kLagrangian}) {
    Motion strip(Vec3d(length, 0.02, 0.01), 0.01, 1, grid);
    strip.options.damping_time = 0.15;
    Interaction grab;
    grab.type = InteractionType::kGrab;
    grab.region = Region::sphere(Vec3d(length, 0.01, 0.005), 0.015);
    Vec3d rest = Vec3d::Zero();
    double mass = 0;
    for (size_t i = 0; i < strip.particles.size(); ++i)
      if (grab.region.contains(strip.particles.position[i])) {
        rest += strip.particles.mass[i] * strip.particles.position[i];
        mass += strip.particles.mass[i];
      }
    rest /= mass;
    const Vec3d far = rest + Vec3d(2.2 * length, 0, 0);
    grab.path = {{0.0, rest}, {1.0, far}, {3.0, rest}};
    grab.duration = 3;
    grab.stiffness = 2000;
    strip.script = {pin_left(0.01), grab};
    strip.go(4.0, initial_state(strip.particles));
    const int k = grid == GridKind::kLagrangian;
    reached[k] = left[k] = aside[k] = 0;
    for (size_t i = 0; i < strip.particles.size(); ++i) {
      const Vec3d &X = strip.particles.position[i], &pulled = strip.states[50].x[i], &end = strip.states.back().x[i];
      reached[k] = std::max(reached[k], pulled.x() / length);
      aside[k] = std::max(aside[k], (pulled - X).tail<2>().norm() / length);
      left[k] = std::max(left[k], (end - X).norm() / length);
    }
  }
  EXPECT_GT(reached[1], 2.8);
  EXPECT_LT(aside[1], 0.06) << "its width shrinks, but it does not turn";
  EXPECT_LT(left[1], 0.1) << "back where it was, but for what turned at its edges";
  EXPECT_GT(left[0], 0.5) << "the Eulerian grid tears it";
}

TEST(Lagrangian, IsRefusedWhereThereIsNoReferenceShape) {
  Motion sand(Vec3d::Constant(0.02), 0.01, 1, GridKind::kLagrangian);
  sand.particles.materials[0].law = Law::kSand;
  expect_error(Failure::kUsage, {"Lagrangian", "sand"}, [&] { sand.go(0.1, initial_state(sand.particles)); });
  Motion two(Vec3d::Constant(0.02), 0.01, 1, GridKind::kLagrangian);
  two.particles.object.assign(two.particles.size(), 1);
  expect_error(Failure::kUsage, {"bodies"}, [&] { two.go(0.1, initial_state(two.particles)); });
}

}  // namespace pliant

#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <vector>

#include "physics/simulate/simulate.h"
#include "tests/physics/shapes.h"

namespace pliant::testing {

/// A bar or block of 8 particles per cell and its motion, frame by frame.
struct Motion {
  using State = BasicSimulationState<double>;
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

inline Interaction pin_left(double x) {
  Interaction pin;
  pin.type = InteractionType::kPin;
  pin.region = Region::half_space(Vec3d(x, 0, 0), Vec3d(1, 0, 0));
  return pin;
}

}  // namespace pliant::testing

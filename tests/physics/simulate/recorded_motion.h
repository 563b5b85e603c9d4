#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <vector>

#include "physics/simulate/simulate.h"
#include "tests/physics/shapes.h"

namespace pliant::fixture {

/// A bar or block of 8 particles per cell and its motion, frame by frame.
struct Motion {
  using State = BasicSimulationState<double>;
  BasicParticles<double> particles;
  SimulateOptions options;
  std::vector<Interaction> script;
  std::vector<State> states;

  Motion(const Vec3d& size, double dx, double jitter, GridKind grid)
      : particles(fixture::block<double>(size, dx, jitter, 1e5)) {
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

/// Appends a copy of the particles that is moved by `shift`; returns the number of the first.
inline size_t append_copy(BasicParticles<double>& p, const Vec3d& shift) {
  const size_t one = p.size();
  const auto append = [&](auto& values) { values.insert(values.end(), values.begin(), values.begin() + one); };
  append(p.position);
  for (auto* values : {&p.volume, &p.mass, &p.young, &p.poisson}) append(*values);
  for (size_t i = one; i < p.size(); ++i) p.position[i] += shift;
  return one;
}

/// Two leaves of half a cell, three tenths of a cell apart, held at x = 0.
struct TwoLeaves : Motion {
  static constexpr double kCell = 0.01, kLength = 12 * kCell, kThickness = 0.5 * kCell;
  size_t one;  ///< particles of the lower leaf, which come first

  TwoLeaves() : Motion(Vec3d(kLength, 4 * kCell, kThickness), kCell, 0.5, GridKind::kLagrangian) {
    one = append_copy(particles, Vec3d(0, 0, kThickness + 0.3 * kCell));
    options.damping_time = 0.05;
  }
  /// Says what hangs together.
  void link() {
    for (size_t i = 0; i < particles.size(); ++i)
      for (size_t k = 0; k < i; ++k)
        if ((i < one) == (k < one) && (particles.position[i] - particles.position[k]).norm() < 0.8 * kCell)
          particles.links.push_back({static_cast<int>(k), static_cast<int>(i)});
  }
  /// Leaves the upper leaf alone.
  void drop_lower() {
    const auto drop = [&](auto& values) { values.erase(values.begin(), values.begin() + one); };
    drop(particles.position);
    for (auto* values : {&particles.volume, &particles.mass, &particles.young, &particles.poisson}) drop(*values);
    one = 0;
  }
  /// Takes the tip of the upper leaf up by so many cells.
  void move_upper(double cells) {
    Interaction grab;
    grab.type = InteractionType::kGrab;
    grab.region = Region::box(Vec3d(kLength - 1.2 * kCell, 0, kThickness + 0.1 * kCell), Vec3d(1, 1, 1));
    Vec3d rest = Vec3d::Zero();
    double count = 0;
    for (size_t i = one; i < particles.size(); ++i)
      if (grab.region.contains(particles.position[i])) {
        rest += particles.position[i];
        ++count;
      }
    rest /= count;
    const Vec3d there = rest + Vec3d(0, 0, cells * kCell);
    grab.path = {{0.0, rest}, {0.5, there}, {1.0, there}};
    script = {pin_left(1.5 * kCell), grab};
    go(1.0, initial_state(particles));
  }
};

}  // namespace pliant::fixture

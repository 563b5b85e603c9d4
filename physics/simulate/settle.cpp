#include "physics/simulate/settle.h"

#include <algorithm>
#include <cmath>

#include "gaussians/base/error.h"
#include "physics/laws/material.h"
#include "physics/simulate/grab_spring.h"

namespace pliant {
namespace {

constexpr double kRestShare = 1e-3;
constexpr int kStillFrames = 4;      // in a row that count as rest
constexpr double kShortWaves = 0.3;  // viscosity time over that in which a wave crosses a cell

template <class T>
double mean_square_speed(const BasicParticles<T>& particles, const BasicSimulationState<T>& state) {
  double sum = 0, mass = 0;
  for (size_t i = 0; i < state.size(); ++i) {
    sum += particles.mass[i] * static_cast<double>(state.v[i].squaredNorm());
    mass += particles.mass[i];
  }
  return sum / mass;
}

template <class T>
void stop(BasicSimulationState<T>& state) {
  std::fill(state.v.begin(), state.v.end(), Vec3<T>::Zero());
  std::fill(state.C.begin(), state.C.end(), Mat3<T>::Zero());
  std::fill(state.node_velocity.begin(), state.node_velocity.end(), Vec3<T>::Zero());
}

}  // namespace

std::vector<Interaction> resting_interactions(const std::vector<Interaction>& interactions) {
  std::vector<Interaction> world;
  for (const Interaction& it : interactions) {
    const bool holds = it.type == InteractionType::kPin || it.type == InteractionType::kGround ||
                       it.type == InteractionType::kWeight || it.type == InteractionType::kCollider ||
                       it.type == InteractionType::kPoke;
    if (!holds || it.start != 0) continue;
    Interaction& standing = world.emplace_back(it);
    standing.duration = INFINITY;
    standing.vector.setZero();
    standing.angular_velocity.setZero();
    if (!it.path.empty()) standing.path = {{0, path_position(it.path, 0)}};
  }
  return world;
}

bool moves(const Interaction& obstacle) {
  const bool driven = obstacle.type == InteractionType::kCollider &&
                      !(obstacle.vector.isZero(0) && obstacle.angular_velocity.isZero(0));
  return driven || !obstacle.path.empty();
}

template <class T>
SettleSummary settle(Simulator<T>& simulator, const BasicParticles<T>& particles, double max_seconds, double rest_speed,
                     BasicSimulationState<T>& state) {
  SettleSummary summary;
  const std::vector<Vec3<T>> start = state.x;
  const double still = rest_speed * rest_speed;
  double last = 0, peak = 0;
  int quiet = 0;
  while (!summary.at_rest && summary.seconds < max_seconds) {
    if (simulator.interrupted())
      throw Error(Failure::kInterrupted, "simulate", "", "interrupted", "run the same command to continue");
    simulator.advance(state);
    summary.seconds += simulator.time_step(1);
    const double now = mean_square_speed(particles, state);
    peak = std::max(peak, now);
    summary.speed = std::sqrt(peak);
    quiet = now < still ? quiet + 1 : 0;
    if (quiet >= kStillFrames) summary.at_rest = true;
    if (now < last) {  // past a maximum: here forces balance in the mean
      summary.at_rest |= peak < still;
      stop(state);
      last = 0;
      peak = 0;
    } else {
      last = now;
    }
  }
  stop(state);
  state.time = 0;
  state.frame = 0;
  state.substeps = 0;
  for (size_t i = 0; i < start.size(); ++i)
    summary.displacement = std::max(summary.displacement, static_cast<double>((state.x[i] - start[i]).norm()));
  return summary;
}

template <class T>
SimulateOptions settling_options(const SimulateOptions& options, const BasicParticles<T>& particles,
                                 const std::vector<Interaction>& interactions) {
  SimulateOptions settling = options;
  for (const Interaction& it : interactions)
    if (it.type == InteractionType::kGravity && it.start == 0 && std::isinf(it.duration)) settling.gravity = it.vector;
  if (!is_lagrangian(options, particles)) return settling;
  double c = 0;
  for (size_t i = 0; i < particles.size(); ++i)
    c = std::max(c, sound_speed(particles.material(i), particles.young[i], particles.poisson[i],
                                static_cast<double>(particles.mass[i]) / particles.volume[i]));
  const double dx = options.cell_size > 0 ? options.cell_size : static_cast<double>(particles.cell_size);
  settling.viscosity_time = std::max(options.viscosity_time, kShortWaves * dx / c);
  return settling;
}

template <class T>
double rest_speed(const SimulateOptions& options, const BasicParticles<T>& particles) {
  Vec3<T> low = particles.position[0], high = low;
  for (const Vec3<T>& x : particles.position) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  const double size = std::max(static_cast<double>((high - low).norm()), static_cast<double>(particles.cell_size));
  return kRestShare * std::sqrt(2 * options.gravity.norm() * size);
}

#define PLIANT_SETTLE(T)                                                                                            \
  template SettleSummary settle(Simulator<T>&, const BasicParticles<T>&, double, double, BasicSimulationState<T>&); \
  template SimulateOptions settling_options(const SimulateOptions&, const BasicParticles<T>&,                       \
                                            const std::vector<Interaction>&);                                       \
  template double rest_speed(const SimulateOptions&, const BasicParticles<T>&);
PLIANT_SETTLE(float)
PLIANT_SETTLE(double)
#undef PLIANT_SETTLE

}  // namespace pliant

#include "fitting/fit/fit_deformation.h"

#include <chrono>

#include "gaussians/base/adam.h"
#include "gaussians/base/error.h"

namespace pliant {
namespace {

/// Seconds since the last lap.
class Laps {
 public:
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    const double seconds = std::chrono::duration<double>(now - begin_).count();
    begin_ = now;
    return seconds;
  }

 private:
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

/// The frames of a displacement [frames, N, 3].
std::vector<SimulationState> displaced(const Particles& particles, std::span<const double> displacement, double fps) {
  const size_t n = particles.size();
  std::vector<SimulationState> frames(displacement.size() / (3 * n), initial_state(particles));
  for (size_t k = 0; k < frames.size(); ++k) {
    frames[k].frame = static_cast<int>(k);
    frames[k].time = static_cast<double>(k) / fps;
    for (size_t i = 0; i < n; ++i) {
      const double* u = &displacement[3 * (k * n + i)];
      frames[k].x[i] += Vec3d(u[0], u[1], u[2]).cast<float>();
    }
  }
  for (size_t k = 0; k + 1 < frames.size(); ++k)
    for (size_t i = 0; i < n; ++i) frames[k].v[i] = static_cast<float>(fps) * (frames[k + 1].x[i] - frames[k].x[i]);
  if (frames.size() > 1) frames.back().v = frames[frames.size() - 2].v;
  return frames;
}

/// Adds its derivatives to `gradient` [frames].
double objective_adjoint(const Objective<float>& objective, std::span<const SimulationState> frames,
                         std::span<StateGradient<float>> gradient) {
  double loss = 0;
  for (const auto& term : objective.whole)
    loss += term.weight * term.loss->value_adjoint(frames, term.weight, gradient);
  for (size_t k = 0; k < frames.size(); ++k)
    for (const auto& term : objective.terms)
      loss += term.weight * term.loss->value_adjoint(static_cast<int>(k), frames[k], term.weight, gradient[k]);
  return loss;
}

/// dL/dparameters, clipped, and the row of this iteration.
std::vector<double> deformation_gradient(const DeformationFitOptions& options, const Particles& particles,
                                         const Field& displacement, const Objective<float>& objective,
                                         std::span<const double> at, GradientFitRow& row) {
  Laps laps;
  const std::vector<SimulationState> frames = displaced(particles, displacement.values(at), options.fps);
  row.frames = static_cast<int>(frames.size()) - 1;
  row.rollout_seconds = laps.lap();
  std::vector<StateGradient<float>> by(frames.size(), StateGradient<float>::zero(particles.size()));
  row.loss = objective_adjoint(objective, frames, by);
  row.frames_seconds = laps.lap();
  std::vector<double> adj_displacement;
  adj_displacement.reserve(3 * displacement.points());
  for (const StateGradient<float>& frame : by)
    for (const Vec3f& x : frame.x) adj_displacement.insert(adj_displacement.end(), {x.x(), x.y(), x.z()});
  std::vector<double> gradient = displacement.values_adjoint(at, adj_displacement);
  displacement.roughness(at, options.roughness, gradient);
  clip_norm(gradient, options.clip, "use a smaller rate");
  row.field_seconds = laps.lap();
  return gradient;
}

}  // namespace

DeformationFit fit_deformation(const DeformationFitOptions& options, const Particles& particles,
                               const Field& displacement, const Objective<float>& objective, GradientFitState state,
                               const std::function<void(const std::string&)>& progress, const GradientFitSink& keep) {
  CHECK(displacement.channels() == 3);
  CHECK(displacement.points() > 0 && displacement.points() % particles.size() == 0);
  Laps laps;
  std::vector<double>& at = state.now.velocity;
  if (at.empty()) at = displacement.constant(std::vector<double>(3, 0.0));
  if (state.first_moment.empty()) {
    state.first_moment.assign(at.size(), 0.0);
    state.second_moment.assign(at.size(), 0.0);
  }
  CHECK(state.first_moment.size() == at.size() && state.second_moment.size() == at.size());
  while (!state.finished && static_cast<int>(state.rows.size()) < options.iterations) {
    const int k = static_cast<int>(state.rows.size());
    GradientFitRow row;
    const std::vector<double> gradient = deformation_gradient(options, particles, displacement, objective, at, row);
    if (state.best_loss < 0 || row.loss < state.best_loss) {
      state.best_loss = row.loss;
      state.best = state.now;
    }
    Adam<double> adam(state.first_moment, state.second_moment, state.steps);
    adam.step(at, gradient, options.rate * cosine_fall(k, options.iterations));
    state.first_moment = adam.first_moment();
    state.second_moment = adam.second_moment();
    ++state.steps;
    state.rows.push_back(row);
    if (progress && state.rows.size() % 10 == 0)
      progress("iteration " + std::to_string(state.rows.size()) + ": " + std::to_string(row.frames) + " frames, loss " +
               std::to_string(row.loss));
    if (keep && !keep(state))
      throw Error(Failure::kInterrupted, "fit", "", "interrupted", "run the same command to continue");
  }
  const std::vector<double>& best = state.best_loss < 0 ? at : state.best.velocity;
  return {displaced(particles, displacement.values(best), options.fps), state.rows, laps.lap()};
}

std::vector<double> deformation_weight(std::span<const double> free, int frames, double unit) {
  std::vector<double> weight(free.size(), 0.0);
  for (int k = 1; k < frames; ++k)
    for (const double w : free) weight.push_back(unit * w);
  return weight;
}

}  // namespace pliant

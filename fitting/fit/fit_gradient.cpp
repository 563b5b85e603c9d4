#include "fitting/fit/fit_gradient.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>

#include "gaussians/base/adam.h"
#include "gaussians/base/error.h"

namespace pliant {
namespace {

using Clock = std::chrono::steady_clock;
double since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

int frames_of(const Motion<float>& motion) {
  return static_cast<int>(std::lround(motion.options.simulate.duration * motion.options.simulate.fps));
}

/// Frames after the start that iteration `k` compares.
int window_of(const GradientFitOptions& options, int k, int all) {
  const double grown = options.growth > 0 ? k / (options.growth * options.iterations) : 1;
  return std::clamp(static_cast<int>(std::lround(options.first_window + grown * (all - options.first_window))), std::min(options.first_window, all), all);
}

void clip(std::span<double> gradient, double most) {
  double square = 0;
  for (const double g : gradient) square += g * g;
  if (!std::isfinite(square)) throw numerical_error("fit", "the gradient is not finite", "use a shorter gradient window");
  if (square > most * most)
    for (double& g : gradient) g *= most / std::sqrt(square);
}

/// All parameters in a row.
std::vector<double> packed(const GradientFitParameters& at, bool damping) {
  std::vector<double> row = at.material;
  row.insert(row.end(), at.velocity.begin(), at.velocity.end());
  if (damping) row.push_back(at.damping);
  return row;
}

void unpack(std::span<const double> row, bool damping, GradientFitParameters& at) {
  const size_t materials = at.material.size(), velocities = at.velocity.size();
  std::copy_n(row.begin(), materials, at.material.begin());
  std::copy_n(row.begin() + static_cast<std::ptrdiff_t>(materials), velocities, at.velocity.begin());
  if (damping) at.damping = row.back();
}

/// dL/d(packed parameters), each kind's clipped; and the row of this iteration.
std::vector<double> gradient_of(const GradientFitOptions& options, const Motion<float>& motion, const Objective<float>& objective,
                                const GradientFitFields& fields, const GradientFitParameters& at, int window, GradientFitRow& row) {
  Motion<float> trial = with_fields(motion, fields, at);
  trial.options.simulate.duration = window / trial.options.simulate.fps;
  const MotionGradient<float> by = motion_loss_adjoint(trial, objective);
  row = {window, by.loss, by.rollout_seconds, by.frames_seconds, by.reverse_seconds, 0};
  const auto begin = Clock::now();
  GradientFitParameters adj;
  if (fields.material) {
    std::vector<double> adj_factor(trial.particles.size());  // by ln of the factor
    for (size_t i = 0; i < adj_factor.size(); ++i) adj_factor[i] = double(by.by.young[i]) * trial.particles.young[i];
    adj.material = fields.material->values_adjoint(at.material, adj_factor);
    fields.material->roughness(at.material, options.material_roughness, adj.material);
    clip(adj.material, options.clip);
  }
  if (fields.velocity) {
    std::vector<double> adj_v;
    for (const Vec3f& v : by.by.start.v) adj_v.insert(adj_v.end(), {v.x(), v.y(), v.z()});
    adj.velocity = fields.velocity->values_adjoint(at.velocity, adj_v);
    fields.velocity->roughness(at.velocity, options.velocity_roughness, adj.velocity);
    clip(adj.velocity, options.clip);
  }
  adj.damping = -by.by.damping_time * trial.options.simulate.damping_time;
  row.field_seconds = since(begin);
  return packed(adj, fields.damping);
}

}  // namespace

Motion<float> with_fields(const Motion<float>& motion, const GradientFitFields& fields, const GradientFitParameters& at) {
  Motion<float> out = motion;
  if (fields.material) {
    const std::vector<double> factor = fields.material->values(at.material);
    for (size_t i = 0; i < factor.size(); ++i) out.particles.young[i] = static_cast<float>(out.particles.young[i] * std::exp(factor[i]));
  }
  if (fields.velocity) {
    const std::vector<double> v = fields.velocity->values(at.velocity);
    for (size_t i = 0; i < out.start.size(); ++i) out.start.v[i] += Vec3d(v[3 * i], v[3 * i + 1], v[3 * i + 2]).cast<float>();
  }
  if (fields.damping) out.options.simulate.damping_time *= std::exp(-at.damping);
  return out;
}

void fit_gradient(const GradientFitOptions& options, const Motion<float>& motion, const Objective<float>& objective,
                  const GradientFitFields& fields, GradientFitState& state, const GradientFitSink& sink) {
  CHECK(fields.material || fields.velocity || fields.damping);
  CHECK(!fields.material || (fields.material->channels() == 1 && fields.material->points() == motion.particles.size()));
  CHECK(!fields.velocity || (fields.velocity->channels() == 3 && fields.velocity->points() == motion.particles.size()));
  CHECK(!fields.damping || motion.options.simulate.damping_time > 0);
  const size_t materials = state.now.material.size(), velocities = state.now.velocity.size();
  const size_t count = materials + velocities + fields.damping;
  if (state.first_moment.empty()) state.first_moment.assign(count, 0.0), state.second_moment.assign(count, 0.0);
  CHECK(state.first_moment.size() == count && state.second_moment.size() == count);
  Adam<double> adam(state.first_moment, state.second_moment, static_cast<long>(state.rows.size()));
  const int all = frames_of(motion);
  while (!state.finished && static_cast<int>(state.rows.size()) < options.iterations) {
    const int k = static_cast<int>(state.rows.size()), window = window_of(options, k, all);
    GradientFitRow row;
    const std::vector<double> gradient = gradient_of(options, motion, objective, fields, state.now, window, row);
    if (window == all) {
      const bool better = state.best_loss < 0 || row.loss < (1 - options.better) * state.best_loss;
      if (state.best_loss < 0 || row.loss < state.best_loss) state.best_loss = row.loss, state.best = state.now;
      state.without_better = better ? 0 : state.without_better + 1;
      state.finished = state.without_better >= options.patience;
    }
    // Steps of unit rate, scaled by each parameter's own.
    const double fall = 0.1 + 0.45 * (1 + std::cos(std::numbers::pi * k / options.iterations));
    std::vector<double> step(count, 0.0), parameters = packed(state.now, fields.damping);
    adam.step(step, gradient, fall);
    for (size_t i = 0; i < count; ++i)
      parameters[i] += step[i] * (i < materials ? options.material_rate : i < materials + velocities ? options.velocity_rate : options.damping_rate);
    unpack(parameters, fields.damping, state.now);
    state.first_moment = adam.first_moment(), state.second_moment = adam.second_moment();
    state.rows.push_back(row);
    if (sink && !sink(state)) return;
  }
  state.finished = true;
  if (state.best_loss < 0) state.best = state.now;
}

}  // namespace pliant

#include "fitting/fit/fit_gradient.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>

#include "gaussians/base/adam.h"
#include "gaussians/base/error.h"
#include "physics/laws/material.h"

namespace pliant {
namespace {

using Clock = std::chrono::steady_clock;
double since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

int frames_of(const Motion<float>& motion) {
  return static_cast<int>(std::lround(motion.options.simulate.duration * motion.options.simulate.fps));
}

/// Frames after the start that iteration `k` compares.
int window_of(const GradientFitOptions& options, int k, int all) {
  const double whole = std::min(options.growth * options.iterations, options.iterations - 1.0);
  const double grown = whole > 0 ? k / whole : 1;
  return std::clamp(static_cast<int>(std::lround(options.first_window + grown * (all - options.first_window))),
                    std::min(options.first_window, all), all);
}

/// All parameters in a row: material, velocity, Poisson's ratio, density, damping.
std::vector<double> packed(const GradientFitParameters& at, bool damping) {
  std::vector<double> row;
  for (const auto* part : {&at.material, &at.velocity, &at.poisson, &at.density})
    row.insert(row.end(), part->begin(), part->end());
  if (damping) row.push_back(at.damping);
  return row;
}

void unpack(std::span<const double> row, bool damping, GradientFitParameters& at) {
  auto from = row.begin();
  for (auto* part : {&at.material, &at.velocity, &at.poisson, &at.density}) {
    std::copy_n(from, part->size(), part->begin());
    from += static_cast<std::ptrdiff_t>(part->size());
  }
  if (damping) at.damping = row.back();
}

/// The rate of each parameter, in the same row.
std::vector<double> rates_of(const GradientFitOptions& options, const GradientFitParameters& at, bool damping) {
  std::vector<double> rates(at.material.size(), options.material_rate);
  rates.insert(rates.end(), at.velocity.size(), options.velocity_rate);
  rates.insert(rates.end(), at.poisson.size(), options.poisson_rate);
  rates.insert(rates.end(), at.density.size(), options.density_rate);
  if (damping) rates.push_back(options.damping_rate);
  return rates;
}

/// What the rates are multiplied by in iteration `k`.
double schedule(const GradientFitOptions& options, int k) {
  const double rise = k < options.warm_up ? double(k + 1) / options.warm_up : 1;
  if (options.linear) return rise * (1 - double(k) / options.iterations);
  return rise * cosine_fall(k, options.iterations);
}

constexpr double kFasterSound = 1.5;  // that a time step of Courant number 0.4 bears

/// Of the fastest particle, m/s.
double speed_of_sound(const Particles& particles) {
  double fastest = 0;
  for (size_t i = 0; i < particles.size(); ++i) {
    const Lame<double> law = lame<double>(particles.young[i], particles.poisson[i]);
    fastest = std::max(fastest, (law.lambda + 2 * law.mu) * particles.volume[i] / particles.mass[i]);
  }
  return std::sqrt(fastest);
}

/// dL/d(ln of the factors) of dL/d(mass) of the particles that have them.
std::vector<double> density_adjoint(const Particles& particles, std::span<const float> adj_mass, bool keep_mass) {
  std::vector<double> adj_factor(particles.size());
  double mass = 0, sum = 0;
  for (size_t i = 0; i < adj_factor.size(); ++i) {
    adj_factor[i] = double(adj_mass[i]) * particles.mass[i];
    sum += adj_factor[i];
    mass += particles.mass[i];
  }
  if (keep_mass)
    for (size_t i = 0; i < adj_factor.size(); ++i) adj_factor[i] -= sum * particles.mass[i] / mass;
  return adj_factor;
}

/// Over all frames; infinite where the motion cannot be simulated.
double whole_loss(const Motion<float>& motion, const Objective<float>& objective, const GradientFitFields& fields,
                  const GradientFitParameters& at) {
  try {
    return motion_loss(with_fields(motion, fields, at), objective);
  } catch (const Error& error) {
    if (error.failure != Failure::kNumerical) throw;
    return INFINITY;
  }
}

constexpr char kShorterWindow[] = "use a shorter gradient window";

/// dL/d(packed parameters), each kind's clipped; and the row of this iteration.
std::vector<double> gradient_of(const GradientFitOptions& options, const Motion<float>& motion,
                                const Objective<float>& objective, const GradientFitFields& fields,
                                const GradientFitParameters& at, int window, GradientFitRow& row) {
  Motion<float> trial = with_fields(motion, fields, at);
  trial.options.simulate.duration = window / trial.options.simulate.fps;
  const MotionGradient<float> by = motion_loss_adjoint(trial, objective);
  row = {window, by.loss, by.rollout_seconds, by.frames_seconds, by.reverse_seconds, 0};
  const auto begin = Clock::now();
  GradientFitParameters adj;
  if (fields.material) {
    std::vector<double> adj_factor(trial.particles.size());  // by ln of the factor
    for (size_t i = 0; i < adj_factor.size(); ++i) {
      const double young = trial.particles.young[i], adj_young = double(by.by.young[i]);
      if (!fields.added_young)
        adj_factor[i] = adj_young * young;
      else if (const AddedYoung& added = *fields.added_young; young > added.low && young < added.high)
        adj_factor[i] = adj_young * added.step;
    }
    adj.material = fields.material->values_adjoint(at.material, adj_factor);
    fields.material->roughness(at.material, options.material_roughness, adj.material);
    clip_norm(adj.material, options.clip, kShorterWindow);
  }
  if (fields.velocity) {
    std::vector<double> adj_v;
    for (const Vec3f& v : by.by.start.v) adj_v.insert(adj_v.end(), {v.x(), v.y(), v.z()});
    adj.velocity = fields.velocity->values_adjoint(at.velocity, adj_v);
    fields.velocity->roughness(at.velocity, options.velocity_roughness, adj.velocity);
    clip_norm(adj.velocity, options.clip, kShorterWindow);
  }
  if (fields.poisson) {
    std::vector<double> adj_odds(trial.particles.size());
    for (size_t i = 0; i < adj_odds.size(); ++i) {
      const double nu = trial.particles.poisson[i];
      adj_odds[i] = double(by.by.poisson[i]) * nu * (1 - nu / kMostPoisson);
    }
    adj.poisson = fields.poisson->values_adjoint(at.poisson, adj_odds);
    clip_norm(adj.poisson, options.clip, kShorterWindow);
  }
  if (fields.density) {
    adj.density =
        fields.density->values_adjoint(at.density, density_adjoint(trial.particles, by.by.mass, fields.keep_mass));
    clip_norm(adj.density, options.clip, kShorterWindow);
  }
  adj.damping = -by.by.damping_time * trial.options.simulate.damping_time;
  row.field_seconds = since(begin);
  return packed(adj, fields.damping);
}

}  // namespace

void clip_norm(std::span<double> gradient, double most, const std::string& remedy) {
  double square = 0;
  for (const double g : gradient) square += g * g;
  if (!std::isfinite(square)) throw numerical_error("fit", "the gradient is not finite", remedy);
  if (square > most * most)
    for (double& g : gradient) g *= most / std::sqrt(square);
}

double cosine_fall(int k, int iterations) { return 0.1 + 0.45 * (1 + std::cos(std::numbers::pi * k / iterations)); }

Motion<float> with_fields(const Motion<float>& motion, const GradientFitFields& fields,
                          const GradientFitParameters& at) {
  Motion<float> out = motion;
  if (fields.material) {
    const std::vector<double> factor = fields.material->values(at.material);
    for (size_t i = 0; i < factor.size(); ++i) {
      const double young = out.particles.young[i];
      out.particles.young[i] =
          static_cast<float>(fields.added_young ? std::clamp(young + fields.added_young->step * factor[i],
                                                             fields.added_young->low, fields.added_young->high)
                                                : young * std::exp(factor[i]));
    }
  }
  if (fields.velocity) {
    const std::vector<double> v = fields.velocity->values(at.velocity);
    for (size_t i = 0; i < out.start.size(); ++i)
      out.start.v[i] += Vec3d(v[3 * i], v[3 * i + 1], v[3 * i + 2]).cast<float>();
  }
  if (fields.poisson) {
    const std::vector<double> odds = fields.poisson->values(at.poisson);
    for (size_t i = 0; i < odds.size(); ++i) {
      const double nu = std::clamp<double>(out.particles.poisson[i], kPoissonStart[0], kPoissonStart[1]);
      const double share = nu / (nu + (kMostPoisson - nu) * std::exp(-odds[i]));
      out.particles.poisson[i] = static_cast<float>(kMostPoisson * share);
    }
  }
  if (fields.density) {
    const std::vector<double> log_factor = fields.density->values(at.density);
    double before = 0, after = 0;
    for (size_t i = 0; i < log_factor.size(); ++i) {
      before += out.particles.mass[i];
      after += std::exp(log_factor[i]) * out.particles.mass[i];
    }
    const double common = fields.keep_mass ? before / after : 1;
    for (size_t i = 0; i < log_factor.size(); ++i)
      out.particles.mass[i] = static_cast<float>(common * std::exp(log_factor[i]) * out.particles.mass[i]);
  }
  if (fields.material || fields.poisson || fields.density) {
    const double faster = speed_of_sound(out.particles) / speed_of_sound(motion.particles);
    if (faster > kFasterSound) out.options.simulate.substeps *= static_cast<int>(std::ceil(faster / kFasterSound));
  }
  if (fields.damping) out.options.simulate.damping_time *= std::exp(-at.damping);
  return out;
}

void fit_gradient(const GradientFitOptions& options, const Motion<float>& motion, const Objective<float>& objective,
                  const GradientFitFields& fields, GradientFitState& state, const GradientFitSink& sink) {
  CHECK(fields.material || fields.velocity || fields.damping || fields.poisson || fields.density);
  const auto check = [&](const Field* field, int channels) {
    CHECK(!field || (field->channels() == channels && field->points() == motion.particles.size()));
  };
  for (const Field* field : {fields.material, fields.poisson, fields.density}) check(field, 1);
  check(fields.velocity, 3);
  CHECK(!fields.damping || motion.options.simulate.damping_time > 0);
  const std::vector<double> rates = rates_of(options, state.now, fields.damping);
  const size_t count = rates.size();
  if (state.first_moment.empty()) {
    state.first_moment.assign(count, 0.0);
    state.second_moment.assign(count, 0.0);
  }
  CHECK(state.first_moment.size() == count && state.second_moment.size() == count);
  const int all = frames_of(motion);
  // The start is a candidate too: a short window may lead away from a good one.
  if (state.rows.empty() && !options.noisy && window_of(options, 0, all) < all) {
    state.best_loss = motion_loss(with_fields(motion, fields, state.now), objective);
    state.best = state.now;
  }
  while (!state.finished && static_cast<int>(state.rows.size()) < options.iterations) {
    const int k = static_cast<int>(state.rows.size()), window = window_of(options, k, all);
    GradientFitRow row;
    const std::vector<double> gradient = gradient_of(options, motion, objective, fields, state.now, window, row);
    if (window == all) {
      const bool better = state.best_loss < 0 || row.loss < (1 - options.better) * state.best_loss;
      if (state.best_loss < 0 || row.loss < state.best_loss || options.noisy) {
        state.best_loss = row.loss;
        state.best = state.now;
      }
      state.without_better = better ? 0 : state.without_better + 1;
      state.finished = state.without_better >= options.patience && !options.noisy;
      if (!options.noisy && row.loss > (1 + options.astray) * state.best_loss) {
        // Adam's steps are of the size of its rates however near the best is: back to it, with half of them.
        state.now = state.best;
        state.rate *= 0.5;
        state.steps = 0;
        state.first_moment.assign(count, 0.0);
        state.second_moment.assign(count, 0.0);
        state.rows.push_back(row);
        if (sink && !sink(state)) return;
        continue;
      }
    }
    // Steps of unit rate, scaled by each parameter's own.
    const double rate = state.rate * schedule(options, k);
    std::vector<double> step(count, 0.0), parameters = packed(state.now, fields.damping);
    Adam<double> adam(state.first_moment, state.second_moment, state.steps);
    adam.step(step, gradient, rate);
    for (size_t i = 0; i < count; ++i)
      parameters[i] += rates[i] * (step[i] - rate * options.weight_decay * parameters[i]);
    unpack(parameters, fields.damping, state.now);
    for (double& p : state.now.material) p = std::clamp(p, -options.material_limit, options.material_limit);
    for (double& p : state.now.density) p = std::clamp(p, -options.density_limit, options.density_limit);
    state.first_moment = adam.first_moment();
    state.second_moment = adam.second_moment();
    ++state.steps;
    state.rows.push_back(row);
    if (sink && !sink(state)) return;
  }
  state.finished = true;
  if (state.best_loss < 0 || options.noisy) {
    state.best = state.now;
  } else if (const double loss = whole_loss(motion, objective, fields, state.now); loss < state.best_loss) {
    // What the last step led to is a candidate too.
    state.best_loss = loss;
    state.best = state.now;
  }
}

}  // namespace pliant

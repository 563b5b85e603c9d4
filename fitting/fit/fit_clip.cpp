#include "fitting/fit/fit_clip.h"

#include <chrono>

#include "gaussians/base/error.h"

namespace pliant {

ClipFit fit_clip(const ClipFitOptions& options, const Motion<float>& motion, const Objective<float>& objective,
                 GradientFitState state, const std::function<void(const std::string&)>& progress,
                 const GradientFitSink& keep) {
  const auto begin = std::chrono::steady_clock::now();
  GradientFitFields fields = options.fields();
  fields.damping = fields.damping && motion.options.simulate.damping_time > 0;
  const auto start = [](const Field* field, std::vector<double>& parameters) {
    if (field && parameters.empty()) parameters = field->constant(std::vector<double>(field->channels(), 0.0));
  };
  start(fields.material, state.now.material);
  start(fields.velocity, state.now.velocity);
  start(fields.poisson, state.now.poisson);
  start(fields.density, state.now.density);
  bool stopped = false;
  fit_gradient(options.gradient, motion, objective, fields, state, [&](const GradientFitState& now) {
    if (progress && now.rows.size() % 10 == 0)
      progress("iteration " + std::to_string(now.rows.size()) + ": " + std::to_string(now.rows.back().frames) +
               " frames, loss " + std::to_string(now.rows.back().loss));
    stopped = keep && !keep(now);
    return !stopped;
  });
  if (stopped) throw Error(Failure::kInterrupted, "fit", "", "interrupted", "run the same command to continue");
  const bool patient = state.without_better < options.gradient.patience || options.gradient.noisy;
  return {with_fields(motion, fields, state.best), state.rows, patient ? "iterations" : "no better loss",
          std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count()};
}

}  // namespace pliant

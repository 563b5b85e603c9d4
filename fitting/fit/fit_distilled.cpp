#include "fitting/fit/fit_distilled.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <optional>

#include "fitting/fields/kan_field.h"
#include "gaussians/base/adam.h"
#include "gaussians/base/error.h"

namespace pliant {
namespace {

using Clock = std::chrono::steady_clock;

constexpr size_t kConstants = 4;  // E, and of the branch shear, lambda, viscosity

/// The motion with constants that are 10^`log10_factor` times those of the start.
Motion<float> with_factors(const Motion<float>& motion, const std::vector<double>& log10_factor) {
  Motion<float> out = motion;
  const size_t n = motion.particles.size();
  const auto factor = [&](size_t constant, size_t i) { return std::pow(10.0, log10_factor[constant * n + i]); };
  for (size_t i = 0; i < n; ++i) out.particles.young[i] *= static_cast<float>(factor(0, i));
  if (log10_factor.size() == kConstants * n)
    for (size_t i = 0; i < n; ++i) {
      Material& m = out.particles.materials[out.particles.material_index[i]];
      m.branch_shear *= factor(1, i);
      m.branch_lambda *= factor(2, i);
      m.branch_viscosity *= factor(3, i);
    }
  out.options.simulate.substeps = 0;  // as the stiffest particle of now wants
  return out;
}

/// What all clips of a roll-out at `fps` frames a second together say.
Objective<float> objective_of(const DistilledFitOptions& options, const ClipTerms& drawn, double fps) {
  Objective<float> objective;
  for (int k = 0; k < options.stages; ++k)
    objective.whole.push_back(
        {drawn.guide_weight / options.stages,
         std::make_shared<GuidanceLoss>(
             drawn.guide, drawn.drawn, drawn.guide_camera,
             GuidanceLoss::Frames{k, options.stages, fps / options.stages, options.against_still})});
  return objective;
}

/// dL/d(constant) of every particle, in the order of the parameters.
std::vector<std::vector<double>> gradient_of(const MotionGradient<float>& by, const Particles& particles, bool branch) {
  std::vector<std::vector<double>> out(branch ? kConstants : 1);
  out[0].assign(by.by.young.begin(), by.by.young.end());
  if (branch)
    for (size_t i = 0; i < particles.size(); ++i) {
      const BranchGradient<double>& b = by.by.material[particles.material_index[i]].branch;
      out[1].push_back(b.shear);
      out[2].push_back(b.lambda);
      out[3].push_back(b.viscosity);
    }
  return out;
}

/// E as a function of the place in the body, within its range.
class YoungNetwork {
 public:
  YoungNetwork(const DistilledFitOptions::Range& range, uint64_t seed, const Particles& particles)
      : middle_(0.5 * (std::log(range.low) + std::log(range.high))),
        field_({.bound = 0.5 * (std::log(range.high) - std::log(range.low)), .seed = seed}, particles.position) {}

  /// Parameters of a factor of 1 everywhere.
  std::vector<double> start() const { return field_.constant(std::vector<double>{-middle_}); }

  /// log10 of the factors [N].
  std::vector<double> log10_factors(std::span<const double> parameters) const {
    std::vector<double> out = field_.values(parameters);
    for (double& f : out) f = (f + middle_) / std::numbers::ln10;
    return out;
  }

  /// A step of Adam from `state` on, by dL/dE [N] at `young` [N].
  void step(double rate, std::span<const double> by_young, const std::vector<float>& young,
            GradientFitState& state) const {
    std::vector<double> adj_factor(by_young.begin(), by_young.end());
    for (size_t i = 0; i < adj_factor.size(); ++i) adj_factor[i] *= young[i];
    std::vector<double>& parameters = state.now.material;
    const std::vector<double> gradient = field_.values_adjoint(parameters, adj_factor);
    state.first_moment.resize(parameters.size(), 0.0);
    state.second_moment.resize(parameters.size(), 0.0);
    Adam<double> adam(state.first_moment, state.second_moment, state.steps);
    adam.step(parameters, gradient, rate);
    state.first_moment = adam.first_moment();
    state.second_moment = adam.second_moment();
    ++state.steps;
  }

 private:
  double middle_;  // of the range of ln of the factor
  KanField field_;
};

}  // namespace

DistilledFitOptions DistilledFitOptions::physics3d() {
  DistilledFitOptions options;
  options.branch = true;
  return options;
}

DistilledFitOptions DistilledFitOptions::dreamphysics() {
  DistilledFitOptions options;
  options.against_still = true;
  options.young = {0.005, 2};  // 1e4 to 4e6 Pa from 2e6
  return options;
}

RelaxingBranch usual_branch(double young, double poisson) {
  constexpr double kRelaxation = 0.01;  // s
  const double mu = lame(young, poisson).mu;
  return {static_cast<float>(mu), static_cast<float>(mu), static_cast<float>(2 * mu * kRelaxation)};
}

void distilled_step(double rate, const DistilledFitOptions::Range& range, std::span<const double> gradient,
                    std::span<double> log10_factor) {
  CHECK(gradient.size() == log10_factor.size() && !gradient.empty());
  const auto [low, high] = std::ranges::minmax_element(gradient);
  const double width = *high - *low, least = *low;
  if (!(width > 0)) return;
  for (size_t i = 0; i < gradient.size(); ++i)
    log10_factor[i] = std::clamp(log10_factor[i] - rate * ((gradient[i] - least) / width - 0.5), std::log10(range.low),
                                 std::log10(range.high));
}

ClipFit fit_distilled(const DistilledFitOptions& options, const Motion<float>& motion, const ClipTerms& drawn,
                      double fps, GradientFitState state, const std::function<void(const std::string&)>& progress,
                      const GradientFitSink& keep) {
  const auto begin = Clock::now();
  const size_t n = motion.particles.size();
  CHECK(options.stages > 0 && drawn.guide && drawn.drawn);
  CHECK(!options.branch || !options.network);
  CHECK(!options.branch || motion.particles.materials.size() == n);
  std::vector<double>& parameters = state.now.material;
  std::optional<YoungNetwork> network;
  if (options.network) network.emplace(options.young, options.seed, motion.particles);
  if (parameters.empty())
    parameters = network ? network->start() : std::vector<double>((options.branch ? kConstants : 1) * n, 0.0);
  const auto motion_now = [&] {
    return with_factors(motion, network ? network->log10_factors(parameters) : parameters);
  };
  const Objective<float> objective = objective_of(options, drawn, fps);
  const DistilledFitOptions::Range ranges[kConstants] = {options.young, options.modulus, options.modulus,
                                                         options.viscosity};
  while (static_cast<int>(state.rows.size()) < options.iterations) {
    Motion<float> now = motion_now();
    now.options.gradient_window = 1;
    // A branch's stress follows from the return map of the substep before.
    now.options.gradient_substeps = options.branch ? 2 : 1;
    const MotionGradient<float> by = motion_loss_adjoint(now, objective);
    const auto gradients = gradient_of(by, now.particles, options.branch);
    for (size_t c = 0; c < gradients.size(); ++c) {
      if (!std::ranges::all_of(gradients[c], [](double g) { return std::isfinite(g); }))
        throw numerical_error("fit", "the gradient is not finite", "start from another Young's modulus");
      if (!network) distilled_step(options.rate, ranges[c], gradients[c], std::span(parameters).subspan(c * n, n));
    }
    if (network) network->step(options.network_rate, gradients[0], now.particles.young, state);
    const int frames = static_cast<int>(std::lround(motion.options.simulate.duration * motion.options.simulate.fps));
    state.rows.push_back({frames, by.loss, by.rollout_seconds, by.frames_seconds, by.reverse_seconds, 0});
    if (progress && state.rows.size() % 10 == 0)
      progress("iteration " + std::to_string(state.rows.size()) + ": loss " + std::to_string(by.loss));
    if (keep && !keep(state))
      throw Error(Failure::kInterrupted, "fit", "", "interrupted", "run the same command to continue");
  }
  Motion<float> found = motion_now();
  return {std::move(found), state.rows, "iterations", std::chrono::duration<double>(Clock::now() - begin).count()};
}

}  // namespace pliant

#include "fitting/fit/fit_vibration.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <exception>
#include <utility>

#include "fitting/fit/vibration_rollouts.h"
#include "fitting/fit/young_posterior.h"
#include "fitting/solve/correlation.h"
#include "gaussians/base/error.h"

namespace pliant {
namespace {

constexpr int kFirstWindow = 4;  // frames after the first, over which a field is fitted first, and its start with it;
constexpr double kWholeWindow = 0.7;            // of all frames: from here on all at once
constexpr int kWindowSteps = 8, kOfWindow = 2;  // in a window: steps, and Jacobians by differences
constexpr int kRounds = 6;                      // of a fit of a field, at most: ...
constexpr double kSameNoise = 0.8;              // ... while less than this share of the errors remains, ...
constexpr double kSettled =
    0.02;  // ... or the loss falls by more than this for every parameter: a fifth of a standard deviation
constexpr int kOfRound = 250,
              kOfRounds =
                  400;  // roll-outs for Jacobians, two for every parameter, in a round and in all; each round finds one
constexpr double kFirstSpread = 0.3;  // of a field in the first round, share of what is expected: of many that explain
                                      // the motion, one near the smallest
constexpr int kLastSteps = 15;        // with the last Jacobian
constexpr double kOpen = 1;           // decades, least error of an E from the end of the search
constexpr double kSame =
    0.05;  // ln of the factor by which E may grow in the last steps before roll-outs take smaller time steps

/// The refinements of a fit in their order: those that an earlier call has made are not made again.
class Journal {
 public:
  Journal(VibrationFitState& state, const VibrationFitSink& sink) : state_(state), sink_(sink) {}

  void keep() const {
    if (sink_) sink_(state_);
  }
  GaussNewtonResult refine(const VibrationRollouts& rollouts, const GaussNewtonOptions& base,
                           std::span<const double> from, int iterations, double noise,
                           const Eigen::MatrixXd& jacobian = {}, double field_spread = 1) {
    GaussNewtonOptions options = rollouts.bounded(base, field_spread);
    options.max_iterations = iterations;
    options.jacobian = jacobian;
    options.parallel = options.keep_jacobian = true;
    std::vector<GaussNewtonState>& all = state_.refinements;
    const size_t k = made_++;
    if (k == all.size()) all.emplace_back();
    GaussNewtonResult result = gauss_newton(
        options, [&](std::span<const double> p) { return rollouts.residuals(p, noise); }, from, all[k],
        [&](const GaussNewtonState& now) {
          all[k] = now;
          keep();
        });
    all[k].jacobian.resize(0, 0);  // of a finished one the differences are enough
    return result;
  }

 private:
  VibrationFitState& state_;
  const VibrationFitSink& sink_;
  size_t made_ = 0;
};

/// Root mean square motion of the tracks in frames `first` to `last`.
double rms_of_rest(const TrackLoss<float>& tracks, const Particles& particles, int first, int last) {
  const std::vector<Vec3f> still = tracks.expected(initial_state(particles));
  double square = 0, weight = 0;
  const PointTracks& seen = tracks.tracks();
  for (int f = first; f <= last; ++f)
    for (size_t k = 0; k < seen.place[f].size(); ++k) {
      square += seen.weight[f][k] * (seen.place[f][k] - still[k].cast<double>()).squaredNorm();
      weight += seen.weight[f][k];
    }
  return std::sqrt(square / std::max(weight, 1e-300));
}

/// Of the common factor and the field together.  What the tracks leave open is as uncertain as before, the factor by as
/// much as the search reaches.
void set_young_sigma(VibrationFit& fit, const VibrationFitOptions& options, size_t particles,
                     const Eigen::MatrixXd& covariance) {
  const Eigen::Index size = static_cast<Eigen::Index>(fit.field.size());
  Eigen::MatrixXd scaled(1 + size, 1 + size);
  for (Eigen::Index a = 0; a <= size; ++a)
    for (Eigen::Index b = 0; b <= size; ++b) scaled(a, b) = covariance(a ? 1 + a : 0, b ? 1 + b : 0);
  std::vector<double> prior(static_cast<size_t>(1 + size), options.field_sigma);
  prior[0] = std::min(options.factor_sigma, std::log(10.0) * options.search.farthest);
  Eigen::MatrixXd by(static_cast<Eigen::Index>(particles), 1 + size);  // of ln E
  by.col(0).setOnes();
  if (size > 0) by.rightCols(size) = sensitivity(*options.field, fit.field);
  YoungPosterior posterior = young_posterior(by, with_prior_where_infinite(std::move(scaled), prior));
  fit.log10_sigma = posterior.log10_sigma;
  fit.young_sigma = std::move(posterior.young_sigma);
}

/// What remains, as a share of the noise.  Errors of neighbouring frames and points are not independent: how far they
/// reach says how much the tracks weigh against the priors, and how wide the posterior is.
double left_over(const GaussNewtonResult& result, const TrackLoss<float>& tracks) {
  return std::max(1e-6, unexplained(result.residuals, tracks.tracks().rest, tracks.tracks().axes()));
}

/// The factor, damping, the field and the start together: first over a few frames, in which no vibration has come back
/// so often that one of another frequency looks like it, and then over twice as many, up to all; in rounds, of which
/// each takes as noise what the one before has left.  The summary is of all that is done, its loss over all frames
/// (before each window without the prior).
template <class Say>
GaussNewtonResult refine_field(const VibrationFitOptions& options, const TrackLoss<float>& tracks,
                               VibrationRollouts& rollouts, Journal& journal, const std::vector<double>& from,
                               double& noise, GaussNewtonSummary& summary, const Say& say) {
  rollouts.fix_time_step(from, VibrationRollouts::kMargin);
  GaussNewtonOptions axes = options.refine;
  axes.principal_axes = true;
  GaussNewtonResult result;
  result.parameters = from;
  const int last = rollouts.last_frame(), count = last - rollouts.first_frame();
  const auto keep_loss = [&] {
    double square = 0;
    for (const double r : rollouts.residuals(result.parameters, noise)) square += 0.5 * noise * noise * r * r;
    summary.loss.push_back(square);
    ++summary.evaluations;
  };
  const auto tell = [&](const char* what, int number, const char* of) {
    say("%s %d %s: RMSE %.3g after %d steps, %d roll-outs; stopped by: %s", what, number, of,
        rollouts.rms(result.parameters), static_cast<int>(result.summary.loss.size()) - 1, result.summary.evaluations,
        result.summary.stopped_by.c_str());
  };
  axes.most_jacobians = kOfWindow;
  axes.tolerance = 10 * options.refine.tolerance;
  for (int frames = kFirstWindow; frames < kWholeWindow * count; frames *= 2) {
    keep_loss();
    rollouts.compare_until(rollouts.first_frame() + frames);
    result = journal.refine(rollouts, axes, result.parameters, kWindowSteps, noise, {}, kFirstSpread);
    summary.evaluations += result.summary.evaluations;
    tell("first", frames + 1, "frames");
    rollouts.compare_until(last);
  }
  result.jacobian.resize(0, 0);
  int left = kOfRounds;
  double fell = 0;  // the loss, in the last round
  for (int round = 0; round < kRounds; ++round) {
    if (round > 0) rollouts.find_staying(result);
    const double change = round == 0 ? 1 : left_over(result, tracks);
    if (round > 1 && change > kSameNoise && fell < kSettled * static_cast<double>(from.size())) break;
    // The transfers damp more at small time steps: when E is nearly known, rounds go on at the one that a simulation
    // will take.
    if (round == 2) rollouts.fix_time_step(result.parameters, kSame);
    noise *= change;
    axes.rough_jacobian = result.jacobian / change;
    axes.most_jacobians = std::max(1, std::min(left, kOfRound) / static_cast<int>(2 * from.size()));
    axes.tolerance = (round == 0 ? 10 : 1) * options.refine.tolerance;
    result = journal.refine(rollouts, axes, result.parameters, options.refine.max_iterations, noise, {},
                            round == 0 ? kFirstSpread : 1);
    fell = result.summary.loss.front() - result.summary.loss.back();
    left -= result.summary.evaluations;
    const GaussNewtonSummary before = std::exchange(summary, result.summary);
    summary.evaluations += before.evaluations;
    // Rounds weigh errors by other noise; as squares of the tracks' unit their losses follow on each other.
    for (double& loss : summary.loss) loss *= noise * noise;
    summary.loss.insert(summary.loss.begin(), before.loss.begin(), before.loss.end());
    tell("round", round + 1, "on all frames");
  }
  return result;
}

}  // namespace

Particles VibrationFit::fitted(const Particles& particles, const Field* further) const {
  return with_factors(particles, further, std::log(10.0) * log10_factor, field);
}

int VibrationFit::rollout_frame(int f, double fps) const {
  return static_cast<int>(std::lround((f / fps - time) * fps * subframes));
}

VibrationFit fit_vibration(const VibrationFitOptions& options, const Particles& particles,
                           const std::vector<Interaction>& interactions, const TrackLoss<float>& tracks, double fps,
                           const std::function<void(const std::string&)>& progress, VibrationFitState state,
                           const VibrationFitSink& sink) {
  const auto begin = std::chrono::steady_clock::now();
  char line[200];
  const auto say = [&](const char* format, auto... values) {
    if (!progress) return;
    std::snprintf(line, sizeof line, format, values...);
    progress(line);
  };
  VibrationFit fit;
  Journal journal(state, sink);
  if (!options.known_modes && !state.modes) {
    ModesOptions modes = options.modes;
    modes.grid = options.simulate.grid;
    state.modes = vibration_modes(modes, particles, interactions);
    journal.keep();
  }
  fit.modes = options.known_modes ? *options.known_modes : *state.modes;
  say("%d vibration modes, the lowest at %.2f Hz with the current E (%.1f s)", static_cast<int>(fit.modes.size()),
      fit.modes.omega.at(0) / 6.283185307, fit.modes.seconds);
  fit.search = modal_search(options.search, fit.modes, particles, tracks, fps);
  fit.first_frame = fit.search.first_frame;
  say("search: E x %.3g explains %.1f %% of the motion from frame %d on, %.1f periods of the dominant mode",
      std::pow(10.0, fit.search.minima[0].log10_factor), 100 * (1 - fit.search.minima[0].unexplained), fit.first_frame,
      fit.search.periods);

  const auto since = [&] { return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count(); };
  fit.seconds_search = since();

  // A few steps from each good minimum that can be simulated, then the best of them to the end.
  std::unique_ptr<VibrationRollouts> best;
  std::vector<double> parameters;
  double least = INFINITY, periods = fit.search.periods;
  std::exception_ptr unstable;
  for (size_t c = 0; c < fit.search.minima.size() && static_cast<int>(c) < options.candidates; ++c) {
    const ModalMotion& minimum = fit.search.minima[c];
    if (c > 0 && minimum.unexplained > 3 * fit.search.minima[0].unexplained + 0.02) break;
    std::unique_ptr<VibrationRollouts> fitter;
    double before = 0;
    try {
      fitter = std::make_unique<VibrationRollouts>(options, particles, interactions, tracks, fps, fit.modes, fit.search,
                                                   minimum);
      if (!(fitter->weight() > 0))
        throw input_error("fit", "video", "shows no followed point in the fitted frames",
                          "check --video-mask, --start and --periods");
      before = fitter->rms(fitter->start());
      if (!std::isfinite(before)) throw numerical_error("fit", "a roll-out has no finite errors", "give another E");
    } catch (const Error& error) {
      if (error.failure != Failure::kNumerical) throw;
      unstable = std::current_exception();
      say("roll-outs from E x %.3g cannot be simulated", std::pow(10.0, minimum.log10_factor));
      continue;
    }
    if (!best) fit.rms_search = before;
    GaussNewtonResult result;
    result.parameters = fitter->start();
    if (!options.field) result = journal.refine(*fitter, options.refine, fitter->start(), 2, std::max(before, 1e-12));
    const double after = fitter->rms(result.parameters);
    fit.candidate_factor.push_back(result.parameters[0] / std::log(10.0));
    fit.candidate_rms.push_back(after);
    say("roll-outs from E x %.3g: RMSE %.3g -> %.3g at E x %.3g", std::pow(10.0, minimum.log10_factor), before, after,
        std::exp(result.parameters[0]));
    if (after < least) {
      least = after;
      fit.search.end = fit.search.end_of(minimum);
      periods = minimum.periods;
      best = std::move(fitter);
      parameters = result.parameters;
    }
  }
  if (!best) std::rethrow_exception(unstable);
  fit.search.periods = periods;  // not before all candidates were compared over the same frames
  double noise = options.noise > 0 ? options.noise : std::max(least, 1e-12);
  GaussNewtonResult result;
  if (options.field) {
    result = refine_field(options, tracks, *best, journal, parameters, noise, fit.summary, say);
  } else {
    result = journal.refine(*best, options.refine, parameters, options.refine.max_iterations, noise);
    fit.summary = result.summary;
  }
  // So are the last steps.
  best->fix_time_step(result.parameters, kSame);
  best->find_staying(result);
  if (result.jacobian.size() > 0)
    result = journal.refine(*best, options.refine, result.parameters, kLastSteps, noise, result.jacobian);
  const double wider = left_over(result, tracks);
  if (result.jacobian.size() > 0)
    result =
        journal.refine(*best, options.refine, result.parameters, kLastSteps, noise * wider, result.jacobian / wider);
  fit.rms = best->rms(result.parameters);
  fit.log10_factor = result.parameters[0] / std::log(10.0);
  fit.damping_time = std::exp(-result.parameters[1]);
  const std::span<const double> field = best->field_of(result.parameters);
  fit.field.assign(field.begin(), field.end());
  fit.time = best->time();
  fit.subframes = best->subframes();
  fit.substeps = best->substeps();
  fit.last_frame = best->last_frame();
  fit.rms_rest = rms_of_rest(tracks, particles, fit.first_frame, fit.last_frame);
  fit.start = best->state_of(result.parameters);

  if (result.covariance.size() > 0) {
    // One weight for all errors is that of what does not change from frame to frame; every direction has its own.
    if (result.jacobian.size() > 0)
      result.covariance =
          covariance_with(ErrorCorrelation(result.residuals, tracks.tracks().rest, tracks.tracks().axes()),
                          result.jacobian, result.covariance);
    const double spread = std::exp(std::min(5.0, result.sigma(1)));
    fit.damping_time_low = fit.damping_time / spread;
    fit.damping_time_high = fit.damping_time * spread;
    set_young_sigma(fit, options, particles.size(), result.covariance);
  }
  if (fit.search.end != 0 && !options.field) {
    fit.log10_sigma = std::max(fit.log10_sigma, kOpen);
    for (double& sigma : fit.young_sigma) sigma = std::max(sigma, kOpen);
  }
  fit.seconds = since();
  say("%d roll-outs, %d steps; stopped by: %s", fit.summary.evaluations, static_cast<int>(fit.summary.loss.size()) - 1,
      fit.summary.stopped_by.c_str());
  say("E x %.4g (10^+-%.3f), damping time %.3g s, RMSE %.3g (static %.3g)", std::exp(result.parameters[0]),
      fit.log10_sigma, fit.damping_time, fit.rms, fit.rms_rest);
  return fit;
}

}  // namespace pliant

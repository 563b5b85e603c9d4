#include "fitting/fit/fit_vibration.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <utility>

#include "fitting/fit/correlation.h"
#include "fitting/fit/start_shapes.h"
#include "fitting/fit/staying_errors.h"
#include "fitting/fit/young_posterior.h"
#include "gaussians/base/error.h"

namespace pliant {
namespace {

constexpr int kRounds = 4;           // of a fit of a field, at most: more than two ...
constexpr double kSameNoise = 0.8;   // ... while less than this share of the errors remains
constexpr int kOfRound = 250, kOfRounds = 400;  // roll-outs for Jacobians, two for every parameter, in a round and in all
constexpr double kSame = 0.05;       // as kMargin, of the last steps
constexpr double kStartSpread = 0.1; // of a start at rest about the vibration's, share of its largest velocity
constexpr double kMargin = 0.4;      // ln of the factor by which E may grow before roll-outs take smaller time steps

/// `particles` with E times exp(common + field).
Particles with_factors(const Particles& particles, const Field* field, double common, std::span<const double> parameters) {
  Particles scaled = particles;
  const std::vector<double> further = field ? field->values(parameters) : std::vector<double>(particles.size(), 0.0);
  for (size_t i = 0; i < scaled.size(); ++i) scaled.young[i] = static_cast<float>(scaled.young[i] * std::exp(common + further[i]));
  return scaled;
}

/// The refinements of a fit in their order: those that an earlier call has made are not made again.
class Journal {
 public:
  Journal(VibrationFitState& state, const VibrationFitSink& sink) : state_(state), sink_(sink) {}

  void keep() const {
    if (sink_) sink_(state_);
  }
  GaussNewtonResult next(const GaussNewtonOptions& options, const Residuals& residuals, std::span<const double> from) {
    std::vector<GaussNewtonState>& all = state_.refinements;
    const size_t k = made_++;
    if (k == all.size()) all.emplace_back();
    return gauss_newton(options, residuals, from, all[k], [&](const GaussNewtonState& now) { all[k] = now, keep(); });
  }

 private:
  VibrationFitState& state_;
  const VibrationFitSink& sink_;
  size_t made_ = 0;
};

/// Roll-outs as a function of (ln factor of E, ln damping rate, the field's parameters, displacements, velocities of some
/// modes); without displacements when the motion begins at rest.
class Fitter {
 public:
  Fitter(const VibrationFitOptions& options, const Particles& particles, const std::vector<Interaction>& interactions,
         const TrackLoss<float>& tracks, double fps, const VibrationModes& modes, const ModalSearch& search,
         const ModalMotion& motion)
      : particles_(particles), interactions_(interactions), tracks_(tracks), first_(search.first_frame) {
    at_rest_ = first_ == 0;
    const int n = at_rest_ ? 1 : options.search.starts;
    time_ = at_rest_ ? 0 : time_near_rest(motion, first_ / fps, 1 / (fps * n));
    lead_ = static_cast<int>(std::lround((first_ / fps - time_) * fps * n)), subframes_ = n;
    simulate_ = options.simulate;
    simulate_.fps = fps * n;
    const int frames = static_cast<int>(tracks.tracks().place.size());
    last_ = frames - 1;
    if (search.periods > options.most_periods)
      last_ = first_ + static_cast<int>(std::ceil((last_ - first_) * options.most_periods / search.periods));
    simulate_.duration = (lead_ + (last_ - first_) * n) / simulate_.fps;
    simulate_.settle_time = 0, simulate_.sleep_speed = 0;
    shapes_ = at_rest_ ? StartShapes::smooth(particles, options.most_smooth, motion.omega[0]) : StartShapes::of_modes(modes, motion, particles, options.most_modes);
    stop_ = options.stop;
    field_ = options.field.get(), field_sigma_ = options.field_sigma, field_limit_ = options.field_limit, factor_sigma_ = options.factor_sigma;
    if (field_) field_step_ = largest_steps();
    field_size_ = field_step_.size();
    start_ = {std::log(10.0) * motion.log10_factor, std::log(motion.damping_rate)};
    start_.resize(2 + field_size_, 0.0);
    const auto append = [&](const std::vector<double>& amplitudes) { start_.insert(start_.end(), amplitudes.begin(), amplitudes.end()); };
    if (!at_rest_) append(shapes_.displacement_of(modes, motion, particles, time_));
    append(shapes_.velocity_of(modes, motion, particles, time_));
    fix_time_step(start_, kMargin);
  }

  /// The time step of all roll-outs from now on: the one that a simulation chooses for E times exp(margin).
  void fix_time_step(std::vector<double> p, double margin) {
    SimulateOptions options = simulate_;
    options.duration = 1 / options.fps, options.substeps = 0;
    p[0] += margin;
    const SimulateResult result = simulate<float>(options, particles_of(p), interactions_, state_of(p));
    simulate_.substeps = result.summary.substeps_of_frame.at(0);
  }

  const std::vector<double>& start() const { return start_; }
  double time() const { return time_; }
  int subframes() const { return subframes_; }
  int last_frame() const { return last_; }
  int substeps() const { return simulate_.substeps; }

  SimulationState state_of(std::span<const double> p) const {
    return shapes_.state(particles_, p.subspan(2 + field_size_, at_rest_ ? 0 : shapes_.size()), p.last(shapes_.size()));
  }

  Particles particles_of(std::span<const double> p) const {
    return with_factors(particles_, field_, p[0], p.subspan(2, field_size_));
  }
  size_t field_size() const { return field_size_; }

  /// Errors of all tracks over `noise`, without the share of each point's that stays.
  std::vector<double> residuals(std::span<const double> p, double noise) const {
    std::vector<double> errors = errors_of(p, noise);
    even_out(errors, errors, columns(), 0, staying_);
    return errors;
  }

  /// From what `result` leaves: how much of a point's errors stays.  `result` and later residuals are without it.
  void find_staying(GaussNewtonResult& result) {
    std::vector<double> errors = result.residuals;
    even_out(errors, errors, columns(), staying_, 0);
    const double before = std::exchange(staying_, staying_share(errors, columns()));
    even_out(result.residuals, errors, columns(), before, staying_);
    for (Eigen::Index j = 0; j < result.jacobian.cols(); ++j)
      even_out({result.jacobian.col(j).data(), errors.size()}, errors, columns(), before, staying_);
  }

  /// Errors of all tracks, each times the root of its weight; those beyond the outlier distance grow slower.
  std::vector<double> errors_of(std::span<const double> p, double noise) const {
    if (stop_ && stop_()) throw Error(Failure::kInterrupted, "fit", "", "interrupted", "run the same command to continue");
    SimulateOptions options = simulate_;
    options.damping_time = std::exp(-p[1]);
    const Particles particles = particles_of(p);
    std::vector<double> errors;
    simulate<float>(options, particles, interactions_, state_of(p), [&](const SimulationState& state) {
      if (state.frame < lead_ || (state.frame - lead_) % subframes_ != 0) return true;
      const int f = first_ + (state.frame - lead_) / subframes_;
      if (f <= last_) tracks_.append_errors(f, state, noise, errors);
      if (f == 0) std::fill(errors.begin(), errors.end(), 0.0);  // the points were taken from that frame
      return true;
    });
    return errors;
  }

  GaussNewtonResult refine(Journal& journal, const GaussNewtonOptions& base, std::span<const double> from, int iterations, double noise,
                           const Eigen::MatrixXd& jacobian = {}) const {
    const size_t count = start_.size(), first_amplitude = 2 + field_size_;
    GaussNewtonOptions options = base;
    options.max_iterations = iterations, options.jacobian = jacobian;
    options.parallel = options.keep_jacobian = true;
    options.difference.assign(count, 0.02), options.difference[0] = 0.01, options.difference[1] = 0.05;
    options.low.assign(count, -INFINITY), options.high.assign(count, INFINITY);
    options.low[1] = std::log(0.01), options.high[1] = std::log(50.0);
    options.largest_step.assign(count, 2.0), options.largest_step[0] = 0.12, options.largest_step[1] = 0.7;
    options.prior.assign(count, 0.0), options.prior_sigma.assign(count, INFINITY);
    options.prior[0] = start_[0], options.prior_sigma[0] = factor_sigma_;
    for (size_t j = 2; j < first_amplitude; ++j)
      options.low[j] = -field_limit_, options.high[j] = field_limit_, options.prior_sigma[j] = field_sigma_, options.largest_step[j] = field_step_[j - 2], options.difference[j] = 0.02 * field_sigma_;
    // What a single camera hardly sees stays of the size of what it does see; a smooth velocity, some of whose shapes die
    // away between two frames, near that of the vibration.
    double largest = 0.1;
    for (size_t j = first_amplitude; j < count; ++j) largest = std::max(largest, std::abs(start_[j]));
    for (size_t j = first_amplitude; j < count; ++j) {
      options.prior[j] = at_rest_ ? start_[j] : 0;
      options.prior_sigma[j] = at_rest_ ? kStartSpread * largest : largest;
    }
    return journal.next(options, [&](std::span<const double> p) { return residuals(p, noise); }, from);
  }

  double rms(std::span<const double> p) const {
    double square = 0, weight = 0;
    const std::vector<double> r = errors_of(p, 1);
    for (const double x : r) square += x * x;
    const PointTracks& seen = tracks_.tracks();
    for (int f = first_; f <= last_; ++f)
      if (!seen.place[f].empty())
        for (const double w : seen.weight[f]) weight += w;
    return std::sqrt(square / weight);
  }

 private:
  size_t columns() const { return tracks_.tracks().rest.size() * static_cast<size_t>(tracks_.tracks().axes()); }

  /// Of each parameter of the field: what changes ln E by a quarter where it acts most.
  std::vector<double> largest_steps() const {
    const Eigen::MatrixXd by = sensitivity(*field_, field_->constant(std::vector<double>{0.0}));
    std::vector<double> out;
    for (Eigen::Index a = 0; a < by.cols(); ++a) out.push_back(0.25 / std::max(1e-12, by.col(a).cwiseAbs().maxCoeff()));
    return out;
  }

  const Particles& particles_;
  const std::vector<Interaction>& interactions_;
  const TrackLoss<float>& tracks_;
  int first_ = 0, last_ = 0, lead_ = 0, subframes_ = 1;
  double time_ = 0, staying_ = 0;
  SimulateOptions simulate_;
  bool at_rest_ = false;               // at the start
  std::function<bool()> stop_;
  const Field* field_ = nullptr;       // of further factors
  size_t field_size_ = 0;
  std::vector<double> field_step_;     // of its parameters, at most, in an iteration
  double field_sigma_ = 1, field_limit_ = INFINITY, factor_sigma_ = INFINITY;
  StartShapes shapes_;                 // whose amplitudes are parameters
  std::vector<double> start_;
};

/// Root mean square motion of the tracks.
double rms_of_rest(const TrackLoss<float>& tracks, const Particles& particles, int first) {
  const std::vector<Vec3f> still = tracks.expected(initial_state(particles));
  double square = 0, weight = 0;
  const PointTracks& seen = tracks.tracks();
  for (size_t f = first; f < seen.place.size(); ++f)
    for (size_t k = 0; k < seen.place[f].size(); ++k) {
      square += seen.weight[f][k] * (seen.place[f][k] - still[k].cast<double>()).squaredNorm();
      weight += seen.weight[f][k];
    }
  return std::sqrt(square / std::max(weight, 1e-300));
}

/// Of the common factor and the field together.
void set_young_sigma(VibrationFit& fit, const VibrationFitOptions& options, size_t particles,
                     const Eigen::MatrixXd& covariance) {
  const Eigen::Index size = static_cast<Eigen::Index>(fit.field.size());
  Eigen::MatrixXd scaled(1 + size, 1 + size);
  for (Eigen::Index a = 0; a <= size; ++a)
    for (Eigen::Index b = 0; b <= size; ++b) scaled(a, b) = covariance(a ? 1 + a : 0, b ? 1 + b : 0);
  fit.field_covariance = scaled.bottomRightCorner(size, size);
  Eigen::MatrixXd by(static_cast<Eigen::Index>(particles), 1 + size);  // of ln E
  by.col(0).setOnes();
  if (size > 0) by.rightCols(size) = sensitivity(*options.field, fit.field);
  YoungPosterior posterior = young_posterior(by, scaled);
  fit.log10_sigma = posterior.log10_sigma, fit.young_sigma = std::move(posterior.young_sigma);
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
                           const std::function<void(const std::string&)>& progress, VibrationFitState state, const VibrationFitSink& sink) {
  const auto begin = std::chrono::steady_clock::now();
  char line[200];
  const auto say = [&](const char* format, auto... values) {
    if (!progress) return;
    std::snprintf(line, sizeof line, format, values...);
    progress(line);
  };
  VibrationFit fit;
  Journal journal(state, sink);
  if (!options.known_modes && !state.modes) state.modes = vibration_modes(options.modes, particles, interactions), journal.keep();
  fit.modes = options.known_modes ? *options.known_modes : *state.modes;
  say("%d vibration modes, the lowest at %.2f Hz with the present E (%.1f s)", static_cast<int>(fit.modes.size()),
      fit.modes.omega.at(0) / 6.283185307, fit.modes.seconds);
  fit.search = modal_search(options.search, fit.modes, particles, tracks, fps);
  fit.first_frame = fit.search.first_frame, fit.rms_rest = rms_of_rest(tracks, particles, fit.first_frame);
  say("search: E x %.3g explains %.1f %% of the motion from frame %d on, %.1f periods of the strongest mode",
      std::pow(10.0, fit.search.minima[0].log10_factor), 100 * (1 - fit.search.minima[0].unexplained), fit.first_frame,
      fit.search.periods);

  const auto since = [&] { return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count(); };
  fit.seconds_search = since();

  // A few steps from each good minimum, then the best of them to the end.
  std::unique_ptr<Fitter> best;
  std::vector<double> parameters;
  double least = INFINITY;
  for (size_t c = 0; c < fit.search.minima.size() && static_cast<int>(c) < options.candidates; ++c) {
    const ModalMotion& minimum = fit.search.minima[c];
    if (c > 0 && minimum.unexplained > 3 * fit.search.minima[0].unexplained + 0.02) break;
    auto fitter = std::make_unique<Fitter>(options, particles, interactions, tracks, fps, fit.modes, fit.search, minimum);
    const double before = fitter->rms(fitter->start());
    if (c == 0) fit.rms_search = before;
    GaussNewtonResult result;
    result.parameters = fitter->start();
    if (!options.field) result = fitter->refine(journal, options.refine, fitter->start(), 2, std::max(before, 1e-12));
    const double after = fitter->rms(result.parameters);
    fit.candidate_factor.push_back(result.parameters[0] / std::log(10.0)), fit.candidate_rms.push_back(after);
    say("roll-outs from E x %.3g: rms error %.3g -> %.3g at E x %.3g", std::pow(10.0, minimum.log10_factor), before, after,
        std::exp(result.parameters[0]));
    if (after < least) least = after, best = std::move(fitter), parameters = result.parameters;
  }
  double noise = options.noise > 0 ? options.noise : std::max(least, 1e-12);
  // What remains, as the noise.  Errors of neighbouring frames and points are not independent: how far they reach says how
  // much the tracks weigh against the priors, and how wide the posterior is.
  const auto left_over = [&](const GaussNewtonResult& r) {
    return std::max(1e-6, unexplained(r.residuals, tracks.tracks().rest, tracks.tracks().axes()));
  };
  GaussNewtonResult result;
  if (options.field) {
    best->fix_time_step(parameters, kMargin);
    GaussNewtonOptions axes = options.refine;
    axes.principal_axes = true;
    int left = kOfRounds;
    result.parameters = parameters;
    for (int round = 0; round < kRounds; ++round) {
      if (round > 0) best->find_staying(result);
      const double change = round == 0 ? 1 : left_over(result);
      if (round > 1 && change > kSameNoise) break;
      // The transfers damp more at small time steps: later rounds are made at the one that a simulation will take.
      if (round > 1) best->fix_time_step(result.parameters, kSame);
      noise *= change, axes.rough_jacobian = result.jacobian / change;
      axes.most_jacobians = std::max(1, std::min(left, kOfRound) / static_cast<int>(2 * parameters.size()));
      axes.tolerance = (round == 0 ? 10 : 1) * options.refine.tolerance;
      result = best->refine(journal, axes, result.parameters, options.refine.max_iterations, noise);
      const GaussNewtonSummary before = std::exchange(fit.summary, result.summary);
      left -= result.summary.evaluations, fit.summary.evaluations += before.evaluations;
      // Rounds weigh errors by other noise; as squares of the tracks' unit their losses follow on each other.
      for (double& loss : fit.summary.loss) loss *= noise * noise;
      fit.summary.loss.insert(fit.summary.loss.begin(), before.loss.begin(), before.loss.end());
      say("round %d: rms error %.3g after %d steps, %d roll-outs, until %s", round + 1, best->rms(result.parameters),
          static_cast<int>(result.summary.loss.size()) - 1, result.summary.evaluations, result.summary.stopped_by.c_str());
    }
  } else {
    result = best->refine(journal, options.refine, parameters, options.refine.max_iterations, noise);
    fit.summary = result.summary;
  }
  // So are the last steps.
  best->fix_time_step(result.parameters, kSame);
  best->find_staying(result);
  if (result.jacobian.size() > 0) result = best->refine(journal, options.refine, result.parameters, 8, noise, result.jacobian);
  const double wider = left_over(result);
  if (result.jacobian.size() > 0)
    result = best->refine(journal, options.refine, result.parameters, 4, noise * wider, result.jacobian / wider);
  fit.rms = best->rms(result.parameters);
  fit.log10_factor = result.parameters[0] / std::log(10.0), fit.damping_time = std::exp(-result.parameters[1]);
  fit.field.assign(result.parameters.begin() + 2, result.parameters.begin() + 2 + static_cast<std::ptrdiff_t>(best->field_size()));
  fit.time = best->time(), fit.subframes = best->subframes(), fit.substeps = best->substeps(), fit.last_frame = best->last_frame(), fit.start = best->state_of(result.parameters);

  if (result.covariance.size() > 0) {
    // One weight for all errors is that of what does not change from frame to frame; every direction has its own.
    if (result.jacobian.size() > 0)
      result.covariance = covariance_with(ErrorCorrelation(result.residuals, tracks.tracks().rest, tracks.tracks().axes()), result.jacobian, result.covariance);
    const double spread = std::exp(std::min(5.0, result.sigma(1)));
    fit.damping_time_low = fit.damping_time / spread, fit.damping_time_high = fit.damping_time * spread;
    set_young_sigma(fit, options, particles.size(), result.covariance);
  }
  fit.seconds = since();
  say("%d roll-outs, %d steps until %s", fit.summary.evaluations, static_cast<int>(fit.summary.loss.size()) - 1, fit.summary.stopped_by.c_str());
  say("E x %.4g (10^+-%.3f), damping time %.3g s, rms error %.3g of %.3g", std::exp(result.parameters[0]), fit.log10_sigma,
      fit.damping_time, fit.rms, fit.rms_rest);
  return fit;
}

}  // namespace pliant

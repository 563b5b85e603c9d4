#include "fitting/fit/vibration_rollouts.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "fitting/fit/young_posterior.h"
#include "fitting/solve/staying_errors.h"
#include "gaussians/base/error.h"

namespace pliant {
namespace {

constexpr double kAtRest = 0.1;       // of the farthest that the points get from rest: this near, they are at rest
constexpr double kStartSpread = 0.1;  // of a start at rest about the vibration's, share of its largest velocity

/// Whether the points are where they are at rest in frame 0, against how far they get.
bool begins_at_rest(const TrackLoss<float>& tracks, const Particles& particles) {
  const std::vector<SimulationState> rest = {initial_state(particles)};
  const int frames = static_cast<int>(tracks.tracks().place.size());
  double most = 0;
  for (int f = 0; f < frames; ++f) most = std::max(most, tracks.on_rollout(f, f, 0, 1).rms(rest));
  return !(tracks.on_rollout(0, 0, 0, 1).rms(rest) > kAtRest * most);  // so it is where nothing was followed
}

}  // namespace

Particles with_factors(const Particles& particles, const Field* field, double common,
                       std::span<const double> parameters) {
  Particles scaled = particles;
  const std::vector<double> further = field ? field->values(parameters) : std::vector<double>(particles.size(), 0.0);
  for (size_t i = 0; i < scaled.size(); ++i)
    scaled.young[i] = static_cast<float>(scaled.young[i] * std::exp(common + further[i]));
  return scaled;
}

VibrationRollouts::VibrationRollouts(const VibrationFitOptions& options, const Particles& particles,
                                     const std::vector<Interaction>& interactions, const TrackLoss<float>& tracks,
                                     double fps, const VibrationModes& modes, const ModalSearch& search,
                                     const ModalMotion& motion)
    : particles_(particles), interactions_(interactions), tracks_(tracks), first_(search.first_frame) {
  at_rest_ = first_ == 0 && begins_at_rest(tracks, particles);
  const int n = at_rest_ ? 1 : options.search.starts;
  time_ = at_rest_ ? 0 : time_near_rest(motion, first_ / fps, 1 / (fps * n));
  lead_ = static_cast<int>(std::lround((first_ / fps - time_) * fps * n));
  subframes_ = n;
  simulate_ = options.simulate;
  simulate_.fps = fps * n;
  const int frames = static_cast<int>(tracks.tracks().place.size());
  last_ = frames - 1;
  if (search.periods > options.most_periods)
    last_ = first_ + static_cast<int>(std::ceil((last_ - first_) * options.most_periods / search.periods));
  compare_until(last_);
  simulate_.settle_time = 0;
  simulate_.sleep_speed = 0;
  shapes_ = at_rest_ ? StartShapes::smooth(particles, options.most_smooth, motion.omega[0])
                     : StartShapes::of_modes(modes, motion, particles, options.most_modes);
  stop_ = options.stop;
  field_ = options.field.get();
  field_sigma_ = options.field_sigma;
  field_limit_ = options.field_limit;
  factor_sigma_ = options.factor_sigma;
  if (field_) field_step_ = largest_steps();
  field_size_ = field_step_.size();
  start_ = {std::log(10.0) * motion.log10_factor, std::log(motion.damping_rate)};
  start_.resize(2 + field_size_, 0.0);
  const auto append = [&](const std::vector<double>& amplitudes) {
    start_.insert(start_.end(), amplitudes.begin(), amplitudes.end());
  };
  if (!at_rest_) append(shapes_.displacement_of(modes, motion, particles, time_));
  append(shapes_.velocity_of(modes, motion, particles, time_));
  fix_time_step(start_, kMargin);
}

void VibrationRollouts::fix_time_step(std::vector<double> p, double margin) {
  SimulateOptions options = simulate_;
  options.duration = 1 / options.fps;
  options.substeps = 0;
  p[0] += margin;
  const SimulateResult result = simulate<float>(options, particles_of(p), interactions_, state_of(p));
  simulate_.substeps = result.summary.substeps_of_frame.at(0);
}

void VibrationRollouts::compare_until(int frame) {
  last_ = frame;
  simulate_.duration = (lead_ + (last_ - first_) * subframes_) / simulate_.fps;
}

SimulationState VibrationRollouts::state_of(std::span<const double> p) const {
  return shapes_.state(particles_, p.subspan(2 + field_size_, at_rest_ ? 0 : shapes_.size()), p.last(shapes_.size()));
}

Particles VibrationRollouts::particles_of(std::span<const double> p) const {
  return with_factors(particles_, field_, p[0], field_of(p));
}

std::vector<double> VibrationRollouts::residuals(std::span<const double> p, double noise) const {
  std::vector<double> errors = errors_of(p, noise);
  even_out(errors, errors, columns(), 0, staying_);
  return errors;
}

void VibrationRollouts::find_staying(GaussNewtonResult& result) {
  std::vector<double> errors = result.residuals;
  even_out(errors, errors, columns(), staying_, 0);
  const double before = std::exchange(staying_, staying_share(errors, columns()));
  even_out(result.residuals, errors, columns(), before, staying_);
  for (Eigen::Index j = 0; j < result.jacobian.cols(); ++j)
    even_out({result.jacobian.col(j).data(), errors.size()}, errors, columns(), before, staying_);
}

/// Each times the root of its weight; those beyond the outlier distance grow slower.
std::vector<double> VibrationRollouts::errors_of(std::span<const double> p, double noise) const {
  if (stop_ && stop_())
    throw Error(Failure::kInterrupted, "fit", "", "interrupted", "run the same command to continue");
  SimulateOptions options = simulate_;
  options.damping_time = std::exp(-p[1]);
  const Particles particles = particles_of(p);
  std::vector<double> errors;
  simulate<float>(options, particles, interactions_, state_of(p), [&](const SimulationState& state) {
    if (state.frame < lead_ || (state.frame - lead_) % subframes_ != 0) return true;
    const int f = first_ + (state.frame - lead_) / subframes_;
    if (f <= last_) tracks_.append_errors(f, state, noise, errors);
    if (f == 0 && at_rest_) std::fill(errors.begin(), errors.end(), 0.0);  // the points were taken from that frame
    return true;
  });
  return errors;
}

GaussNewtonOptions VibrationRollouts::bounded(GaussNewtonOptions options, double field_spread) const {
  const size_t count = start_.size(), first_amplitude = 2 + field_size_;
  options.difference.assign(count, 0.02);
  options.difference[0] = 0.01;
  options.difference[1] = 0.05;
  options.low.assign(count, -INFINITY);
  options.high.assign(count, INFINITY);
  options.low[1] = std::log(0.01);
  options.high[1] = std::log(50.0);
  options.largest_step.assign(count, 2.0);
  options.largest_step[0] = 0.12;
  options.largest_step[1] = 0.7;
  options.prior.assign(count, 0.0);
  options.prior_sigma.assign(count, INFINITY);
  options.prior[0] = start_[0];
  options.prior_sigma[0] = factor_sigma_;
  for (size_t j = 2; j < first_amplitude; ++j) {
    options.low[j] = -field_limit_;
    options.high[j] = field_limit_;
    options.prior_sigma[j] = field_spread * field_sigma_;
    options.largest_step[j] = field_step_[j - 2];
    options.difference[j] = 0.02 * field_sigma_;
  }
  // What a single camera hardly sees stays of the size of what it does see; a smooth velocity, some of whose shapes die
  // away between two frames, near that of the vibration.
  double largest = 0.1;
  for (size_t j = first_amplitude; j < count; ++j) largest = std::max(largest, std::abs(start_[j]));
  for (size_t j = first_amplitude; j < count; ++j) {
    options.prior[j] = at_rest_ ? start_[j] : 0;
    options.prior_sigma[j] = at_rest_ ? kStartSpread * largest : largest;
  }
  return options;
}

double VibrationRollouts::weight() const {
  double weight = 0;
  const PointTracks& seen = tracks_.tracks();
  for (int f = first_; f <= last_; ++f)
    if (!seen.place[f].empty())
      for (const double w : seen.weight[f]) weight += w;
  return weight;
}

double VibrationRollouts::rms(std::span<const double> p) const {
  double square = 0;
  const std::vector<double> r = errors_of(p, 1);
  for (const double x : r) square += x * x;
  return std::sqrt(square / weight());
}

/// Of each parameter of the field: what changes ln E by a quarter where it acts most.
std::vector<double> VibrationRollouts::largest_steps() const {
  const Eigen::MatrixXd by = sensitivity(*field_, field_->constant(std::vector<double>{0.0}));
  std::vector<double> out;
  for (Eigen::Index a = 0; a < by.cols(); ++a) out.push_back(0.25 / std::max(1e-12, by.col(a).cwiseAbs().maxCoeff()));
  return out;
}

}  // namespace pliant

#include "fitting/fit/fit_vibration.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>

#include "gaussians/base/error.h"

namespace pliant {
namespace {

/// `particles` with E times exp(common + deviation of its part).
Particles with_factors(const Particles& particles, const std::vector<uint32_t>& part, double common, std::span<const double> deviation) {
  Particles scaled = particles;
  for (size_t i = 0; i < scaled.size(); ++i)
    scaled.young[i] = static_cast<float>(scaled.young[i] * std::exp(common + (deviation.empty() ? 0 : deviation[part[i]])));
  return scaled;
}

/// Roll-outs as a function of (ln factor of E, ln damping rate, ln factors of the parts, displacements, velocities of
/// some modes).
class Fitter {
 public:
  Fitter(const VibrationFitOptions& options, const Particles& particles, const std::vector<Interaction>& interactions,
         const TrackLoss<float>& tracks, double fps, const VibrationModes& modes, const ModalSearch& search,
         const ModalMotion& motion)
      : particles_(particles), interactions_(interactions), tracks_(tracks), modes_(modes), first_(search.first_frame) {
    const int n = options.search.starts;
    time_ = time_near_rest(motion, first_ / fps, 1 / (fps * n));
    lead_ = static_cast<int>(std::lround((first_ / fps - time_) * fps * n)), subframes_ = n;
    simulate_ = options.simulate;
    simulate_.fps = fps * n;
    const int frames = static_cast<int>(tracks.tracks().place.size());
    last_ = frames - 1;
    if (search.periods > options.most_periods)
      last_ = first_ + static_cast<int>(std::ceil((last_ - first_) * options.most_periods / search.periods));
    simulate_.duration = (lead_ + (last_ - first_) * n) / simulate_.fps;
    simulate_.settle_time = 0, simulate_.sleep_speed = 0;
    choose_modes(motion, options.most_modes);
    part_ = options.part, part_sigma_ = std::log(10.0) * options.part_sigma;
    for (const uint32_t p : part_) parts_ = std::max<size_t>(parts_, p + 1);
    start_ = {std::log(10.0) * motion.log10_factor, std::log(motion.damping_rate)};
    start_.resize(2 + parts_, 0.0);
    for (const size_t k : chosen_) start_.push_back(motion.displacement(k, time_) / unit_[k]);
    for (const size_t k : chosen_) start_.push_back(motion.velocity(k, time_) / (unit_[k] * motion.omega[k]));
    omega_ = motion.omega;
    fix_time_step();
  }

  const std::vector<double>& start() const { return start_; }
  double time() const { return time_; }
  int lead() const { return lead_; }
  size_t modes() const { return chosen_.size(); }

  SimulationState state_of(std::span<const double> p) const {
    std::vector<double> displacement(modes_.size(), 0.0), velocity(modes_.size(), 0.0);
    for (size_t j = 0; j < chosen_.size(); ++j) {
      const size_t k = chosen_[j];
      const std::span<const double> amplitude = p.subspan(2 + parts_);
      displacement[k] = amplitude[j] * unit_[k], velocity[k] = amplitude[chosen_.size() + j] * unit_[k] * omega_[k];
    }
    return modal_state(modes_, particles_, displacement, velocity);
  }

  Particles particles_of(std::span<const double> p) const { return with_factors(particles_, part_, p[0], p.subspan(2, parts_)); }
  size_t parts() const { return parts_; }

  /// Errors of all tracks, each times the root of its weight; those beyond the outlier distance grow slower.
  std::vector<double> residuals(std::span<const double> p, double noise) const {
    SimulateOptions options = simulate_;
    options.damping_time = std::exp(-p[1]);
    const Particles particles = particles_of(p);
    const PointTracks& seen = tracks_.tracks();
    std::vector<double> errors;
    simulate<float>(options, particles, interactions_, state_of(p), [&](const SimulationState& state) {
      if (state.frame < lead_ || (state.frame - lead_) % subframes_ != 0) return true;
      const size_t f = first_ + (state.frame - lead_) / subframes_;
      if (static_cast<int>(f) > last_ || seen.place[f].empty()) return true;
      const std::vector<Vec3f> expected = tracks_.expected(state);
      for (size_t k = 0; k < expected.size(); ++k) {
        Vec3d error = expected[k].cast<double>() - seen.place[f][k];
        const double s = error.squaredNorm(), d2 = tracks_.outlier() * tracks_.outlier();
        if (s > 0) error *= std::sqrt(2 * d2 * (std::sqrt(1 + s / d2) - 1) / s);
        error *= seen.weight[f][k] > 0 ? std::sqrt(seen.weight[f][k]) / noise : 0;
        for (int a = 0; a < (seen.camera ? 2 : 3); ++a) errors.push_back(error[a]);
      }
      return true;
    });
    return errors;
  }

  GaussNewtonResult refine(const GaussNewtonOptions& base, std::span<const double> from, int iterations, double noise) const {
    const size_t count = start_.size(), first_amplitude = 2 + parts_;
    GaussNewtonOptions options = base;
    options.max_iterations = iterations;
    options.difference.assign(count, 0.02), options.difference[0] = 0.01, options.difference[1] = 0.05;
    options.low.assign(count, -INFINITY), options.high.assign(count, INFINITY);
    options.low[1] = std::log(0.01), options.high[1] = std::log(50.0);
    options.largest_step.assign(count, 2.0), options.largest_step[0] = 0.12, options.largest_step[1] = 0.7;
    options.prior.assign(count, 0.0), options.prior_sigma.assign(count, INFINITY);
    for (size_t j = 2; j < first_amplitude; ++j)
      options.prior_sigma[j] = part_sigma_, options.largest_step[j] = 0.5, options.low[j] = -4.6, options.high[j] = 4.6;
    // What a single camera hardly sees stays of the size of what it does see.
    double largest = 0.1;
    for (size_t j = first_amplitude; j < count; ++j) largest = std::max(largest, std::abs(start_[j]));
    for (size_t j = first_amplitude; j < count; ++j) options.prior_sigma[j] = largest;
    return gauss_newton(options, [&](std::span<const double> p) { return residuals(p, noise); }, from);
  }

  double rms(std::span<const double> p) const {
    double square = 0, weight = 0;
    const std::vector<double> r = residuals(p, 1);
    for (const double x : r) square += x * x;
    const PointTracks& seen = tracks_.tracks();
    for (int f = first_; f <= last_; ++f)
      if (!seen.place[f].empty())
        for (const double w : seen.weight[f]) weight += w;
    return std::sqrt(square / weight);
  }

 private:
  void choose_modes(const ModalMotion& motion, int most) {
    std::vector<std::pair<double, size_t>> strength;
    for (size_t k = 0; k < modes_.size(); ++k) {
      double largest = 0;
      for (const Vec3d& u : modes_.shape[k]) largest = std::max(largest, u.norm());
      unit_.push_back(particles_.cell_size / largest);
      strength.push_back({std::hypot(motion.cosine[k], motion.sine[k]) / unit_[k], k});
    }
    std::stable_sort(strength.begin(), strength.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
    for (size_t j = 0; j < strength.size() && static_cast<int>(j) < most; ++j)
      if (strength[j].first > 0.01 * strength[0].first) chosen_.push_back(strength[j].second);
    std::sort(chosen_.begin(), chosen_.end());
  }

  /// The time step of all roll-outs, short enough for somewhat stiffer bodies too.
  void fix_time_step() {
    SimulateOptions options = simulate_;
    options.duration = 1 / options.fps;
    std::vector<double> p = start_;
    p[0] += parts_ > 0 ? 1.0 : 0.4;
    const Particles stiffer = particles_of(p);
    const SimulateResult result = simulate<float>(options, stiffer, interactions_, state_of(start_));
    simulate_.substeps = result.summary.substeps_of_frame.at(0);
  }

  const Particles& particles_;
  const std::vector<Interaction>& interactions_;
  const TrackLoss<float>& tracks_;
  const VibrationModes& modes_;
  int first_ = 0, last_ = 0, lead_ = 0, subframes_ = 1;
  double time_ = 0;
  SimulateOptions simulate_;
  std::vector<uint32_t> part_;         // [N] or empty
  size_t parts_ = 0;                   // with a parameter of their own; 0 = all alike
  double part_sigma_ = 0;              // ln
  std::vector<size_t> chosen_;         // modes whose amplitudes are parameters
  std::vector<double> unit_, omega_;   // of an amplitude: the mode moves nothing farther than a cell
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

}  // namespace

Particles VibrationFit::fitted(const Particles& particles, const std::vector<uint32_t>& part) const {
  std::vector<double> deviation;
  for (const double d : part_log10) deviation.push_back(std::log(10.0) * d);
  return with_factors(particles, part, std::log(10.0) * log10_factor, deviation);
}

int VibrationFit::rollout_frame(int f, double fps) const {
  return static_cast<int>(std::lround((f / fps - time) * fps * subframes));
}

VibrationFit fit_vibration(const VibrationFitOptions& options, const Particles& particles,
                           const std::vector<Interaction>& interactions, const TrackLoss<float>& tracks, double fps,
                           const std::function<void(const std::string&)>& progress) {
  const auto begin = std::chrono::steady_clock::now();
  char line[200];
  const auto say = [&](const char* format, auto... values) {
    if (!progress) return;
    std::snprintf(line, sizeof line, format, values...);
    progress(line);
  };
  VibrationFit fit;
  fit.modes = vibration_modes(options.modes, particles, interactions);
  say("%d vibration modes, the lowest at %.2f Hz with the present E (%.1f s)", static_cast<int>(fit.modes.size()),
      fit.modes.omega.at(0) / 6.283185307, fit.modes.seconds);
  fit.search = modal_search(options.search, fit.modes, particles, tracks, fps);
  fit.first_frame = fit.search.first_frame, fit.rms_rest = rms_of_rest(tracks, particles, fit.first_frame);
  say("search: E x %.3g explains %.1f %% of the motion from frame %d on, %.1f periods of the strongest mode",
      std::pow(10.0, fit.search.minima[0].log10_factor), 100 * (1 - fit.search.minima[0].unexplained), fit.first_frame,
      fit.search.periods);

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
    const GaussNewtonResult result = fitter->refine(options.refine, fitter->start(), 2, std::max(before, 1e-12));
    const double after = fitter->rms(result.parameters);
    fit.candidate_factor.push_back(result.parameters[0] / std::log(10.0)), fit.candidate_rms.push_back(after);
    say("roll-outs from E x %.3g: rms error %.3g -> %.3g at E x %.3g", std::pow(10.0, minimum.log10_factor), before, after,
        std::exp(result.parameters[0]));
    if (after < least) least = after, best = std::move(fitter), parameters = result.parameters;
  }
  const double noise = options.noise > 0 ? options.noise : std::max(least, 1e-12);
  const GaussNewtonResult result = best->refine(options.refine, parameters, options.refine.max_iterations, noise);
  fit.summary = result.summary, fit.rms = best->rms(result.parameters);
  fit.log10_factor = result.parameters[0] / std::log(10.0), fit.damping_time = std::exp(-result.parameters[1]);
  for (size_t j = 0; j < best->parts(); ++j) fit.part_log10.push_back(result.parameters[2 + j] / std::log(10.0));
  fit.part_sigma.assign(best->parts(), options.part_sigma);
  fit.time = best->time(), fit.subframes = options.search.starts, fit.start = best->state_of(result.parameters);

  // Errors of neighbouring frames are not independent: the covariance is widened by what remains and by how long it lasts.
  if (result.covariance.size() > 0) {
    const size_t columns = tracks.tracks().rest.size() * (tracks.tracks().camera ? 2 : 3);
    const double variance = result.summary.rms * result.summary.rms * correlation_factor(result.residuals, columns);
    for (size_t j = 0; j < best->parts(); ++j)
      fit.part_sigma[j] = std::min(options.part_sigma, std::sqrt(result.covariance(2 + j, 2 + j) * std::max(1.0, variance)) / std::log(10.0));
    fit.log10_sigma = std::sqrt(result.covariance(0, 0) * variance) / std::log(10.0);
    const double spread = std::exp(std::min(5.0, std::sqrt(result.covariance(1, 1) * variance)));
    fit.damping_time_low = fit.damping_time / spread, fit.damping_time_high = fit.damping_time * spread;
  }
  fit.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  say("E x %.4g (10^+-%.3f), damping time %.3g s, rms error %.3g of %.3g", std::exp(result.parameters[0]), fit.log10_sigma,
      fit.damping_time, fit.rms, fit.rms_rest);
  return fit;
}

}  // namespace pliant

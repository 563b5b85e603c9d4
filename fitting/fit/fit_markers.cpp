#include "fitting/fit/fit_markers.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>

#include "fitting/fit/marker_window.h"
#include "fitting/solve/correlation.h"
#include "gaussians/base/error.h"

namespace pliant {
namespace {

constexpr double kRealGain = 1e-3;  // share of the loss, by which a neighbour on the grid has to be better
constexpr double kAtEnd = 1e-6;     // of log E

class MarkerFit {
 public:
  MarkerFit(const MarkerFitOptions& options, const Particles& particles, const std::vector<Interaction>& interactions,
            const MarkerTracks& recorded, const std::function<void(const std::string&)>& progress, MarkerFitState state,
            const MarkerFitSink& sink)
      : options_(options),
        progress_(progress),
        state_(std::move(state)),
        sink_(sink),
        tracks_(without_spikes(recorded, options.rest_begin)),
        window_{options.rest_begin, options.release, options.release_range, options.window},
        onset_(marker_release(window_, tracks_)),
        rest_(mean_position(tracks_, options.rest_begin, onset_)),
        model_(options.model, particles, interactions, rest_) {
    size_t unseen = 0;  // at rest
    for (size_t k = 0; k < tracks_.markers(); ++k) {
      const double distance = model_.distance(k);
      if (distance <= options.model.reach) continue;
      if (!std::isfinite(distance)) ++unseen;
      result_.warnings.push_back("marker '" + tracks_.name[k] +
                                 (std::isfinite(distance)
                                      ? fmt::format("' is {:.4g} mm from the body", 1e3 * distance)
                                      : fmt::format("' was not measured at rest, before {:.4g} s,", onset_)) +
                                 " and was ignored");
    }
    if (model_.bound().empty() && unseen == tracks_.markers())
      throw input_error("markers", "", fmt::format("none was measured at rest, before {:.4g} s", onset_),
                        "check --marker-rest and --marker-release");
    if (model_.bound().empty())
      throw input_error("markers", "", "none is on the body at rest", "check the units and axes of the markers");
    for (const std::string& spike : spike_warnings(recorded, tracks_, model_.bound()))
      result_.warnings.push_back(spike);
    double log_young = 0;
    for (size_t i = 0; i < particles.size(); ++i) log_young += particles.volume[i] * std::log(particles.young[i]);
    young_ = std::exp(log_young / particles.total_volume());
    measured_ = marker_window(window_, tracks_, onset_, model_.bound(), rest_);
  }

  MarkerFitResult run() {
    const auto begin = std::chrono::steady_clock::now();
    MarkerParameters p{1, options_.damping_time, onset_};
    if (options_.search && options_.fit_young) search(p);
    // From here on the time step stays, so that differences see only what the parameters do.
    say(fmt::format("refining from E = {:.4g} Pa, damping time {:.3g} s, release at {:.4g} s", young_ * p.young_factor,
                    p.damping_time, p.release));
    model_.run(p, 1 / options_.model.simulate.fps);
    substeps_ = model_.substeps();
    motions_.clear();
    refine(p);
    finish(p);
    result_.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return result_;
  }

 private:
  void say(const std::string& line) const {
    if (progress_) progress_(line);
  }

  void keep() const {
    if (sink_) sink_(state_);
  }

  double duration() const { return options_.window + options_.release_range + 3 / options_.model.simulate.fps; }

  const MarkerMotion& motion(const MarkerParameters& p, double duration) {
    const std::pair<double, double> key{p.young_factor, p.damping_time};
    const auto known = motions_.find(key);
    if (known != motions_.end() && known->second.duration() >= duration - 0.5 / known->second.fps) return known->second;
    if (motions_.size() > 100) motions_.clear();
    ++result_.rollouts;
    result_.simulated_seconds += duration;
    return motions_[key] = model_.run(p, duration, substeps_);
  }

  /// [T, bound, 3] in units of sigma; expected(time since release, marker).
  template <class Expected>
  std::vector<double> residuals(Expected&& expected, double release) const {
    std::vector<double> r;
    for (size_t t = 0; t < measured_.time.size(); ++t) {
      for (size_t k = 0; k < model_.bound().size(); ++k) {
        const Vec3d difference = expected(measured_.time[t] - release, k) - measured_.displacement[t][k];
        for (const double d : difference) r.push_back(measured_.weight[t][k] * d / options_.sigma);
      }
    }
    return r;
  }
  std::vector<double> residuals(const MarkerMotion& motion, double release) const {
    return residuals([&](double s, size_t k) { return motion.at(s, k); }, release);
  }
  static double squares(const std::vector<double>& r) {
    double sum = 0;
    for (const double x : r) sum += x * x;
    return sum;
  }

  /// Loss of a simulated E.  Infinite where it cannot be simulated.
  double simulated(MarkerParameters p, int step) {
    for (const MarkerFitState::Simulated& known : state_.simulated)
      if (known.step == step) return known.loss;
    p.young_factor = factor(step);
    double loss = INFINITY;
    try {
      loss = squares(residuals(motion(p, duration()), p.release));
    } catch (const Error& error) {
      if (error.failure != Failure::kNumerical) throw;
    }
    state_.simulated.push_back({step, loss});
    const MarkerFitResult::Candidate c = candidate(state_.simulated.back());
    say(std::isfinite(loss) ? fmt::format("E = {:.4g} Pa: RMSE {:.3g} mm", c.young, 1e3 * c.rms)
                            : fmt::format("E = {:.4g} Pa cannot be simulated", c.young));
    keep();
    return loss;
  }
  MarkerFitResult::Candidate candidate(const MarkerFitState::Simulated& simulated) const {
    return {young_ * factor(simulated.step), options_.sigma * std::sqrt(simulated.loss / measured_.total_weight())};
  }
  double factor(int step) const { return std::pow(10.0, step * options_.search_step); }
  int steps(double decades) const { return static_cast<int>(std::lround(decades / options_.search_step)); }
  double farthest() const { return std::max(options_.search_decades, options_.search_farthest); }  // decades

  /// Best step of the grid by what a motion simulated at `from` says of the others.
  int proposal(const MarkerParameters& p, int from, double stretch) {
    MarkerParameters at = p;
    at.young_factor = factor(from);
    const MarkerMotion& base = motion(at, duration() * stretch);
    const int limit = steps(options_.search_decades);
    int best = from;
    double least = INFINITY;
    for (int step = -limit; step <= limit; ++step) {
      const double ratio = factor(step - from), hurry = std::sqrt(ratio);
      if (hurry > stretch) break;
      const double loss =
          squares(residuals([&](double s, size_t k) { return Vec3d(base.at(s * hurry, k) / ratio); }, p.release));
      if (loss < least) {
        least = loss;
        best = step;
      }
    }
    return best;
  }

  void search(MarkerParameters& p) {
    if (!state_.searched) {
      state_.best = searched(p);
      state_.searched = true;
      keep();
    }
    p.young_factor = factor(state_.best);
    if (std::abs(state_.best) >= steps(farthest())) result_.search_end = state_.best > 0 ? 1 : -1;
    for (const MarkerFitState::Simulated& one : state_.simulated)
      if (std::isfinite(one.loss)) result_.search.push_back(candidate(one));
  }

  /// Best step of the grid.
  int searched(const MarkerParameters& p) {
    int best = 0;
    double stretch = std::pow(10.0, options_.search_decades / 2);
    for (int round = 0; round < 6; ++round) {
      const int next = proposal(p, best, stretch);
      const bool stays = next == best;
      best = next;
      stretch = std::pow(10.0, 0.15);  // from now on up to 0.3 decades stiffer
      if (stays) break;
    }
    // What was proposed is compared with its neighbours.  Where nothing explains the motion, a stiffer body that hardly
    // moves is always a little better.
    const int limit = steps(farthest());
    for (bool moved = true; moved;) {
      moved = false;
      for (const int side : {-1, 1})
        if (std::abs(best + side) <= limit && simulated(p, best + side) < (1 - kRealGain) * simulated(p, best)) {
          best += side;
          moved = true;
        }
    }
    return best;
  }

  void refine(MarkerParameters& p) {
    struct Unknown {
      double start, difference, low, high, largest_step;
    };
    std::vector<Unknown> unknowns;
    const double log_young = std::log(p.young_factor), widest = std::log(factor(steps(farthest())));
    if (options_.fit_young)
      unknowns.push_back({log_young, 0.02, std::min(log_young, -widest), std::max(log_young, widest), 0.3});
    if (options_.fit_damping) unknowns.push_back({std::log(p.damping_time), 0.05, std::log(1e-5), std::log(1e3), 1});
    if (options_.fit_release)
      unknowns.push_back({p.release, 1e-3,
                          std::max(p.release - options_.release_range, seen_at_rest(window_, tracks_, model_.bound())),
                          p.release + options_.release_range, 0.02});
    if (unknowns.empty()) return;
    GaussNewtonOptions gauss;
    std::vector<double> start;
    for (const Unknown& u : unknowns) {
      start.push_back(u.start);
      gauss.difference.push_back(u.difference);
      gauss.largest_step.push_back(u.largest_step);
      gauss.low.push_back(u.low);
      gauss.high.push_back(u.high);
    }
    gauss.max_iterations = options_.max_iterations;
    gauss.tolerance = 1e-4;
    gauss.jacobian = options_.jacobian;
    const auto parameters_of = [&, base = p](std::span<const double> x) {
      MarkerParameters q = base;
      size_t at = 0;
      if (options_.fit_young) q.young_factor = std::exp(x[at++]);
      if (options_.fit_damping) q.damping_time = std::exp(x[at++]);
      if (options_.fit_release) q.release = x[at++];
      return q;
    };
    auto fit = gauss_newton(
        gauss,
        [&](std::span<const double> x) {
          const MarkerParameters q = parameters_of(x);
          return residuals(motion(q, duration()), q.release);
        },
        start, state_.refinement,
        [&](const GaussNewtonState& now) {
          state_.refinement = now;
          keep();
        });
    p = parameters_of(fit.parameters);
    result_.jacobian = fit.jacobian;
    result_.loss = fit.summary.loss;
    result_.converged = fit.summary.converged;
    // Errors of a marker go on for a while, and neighbours share them.
    std::vector<Vec3f> place;
    for (const int k : model_.bound()) place.push_back(rest_[k].cast<float>());
    fit.covariance = fit.jacobian.size() > 0
                         ? covariance_with(ErrorCorrelation(fit.residuals, place, 3), fit.jacobian, fit.covariance)
                         : Eigen::MatrixXd(std::pow(fit.summary.rms, 2) * fit.covariance);
    int at = 0;
    if (options_.fit_young) {
      const double found = fit.parameters[0];
      if (found > gauss.high[0] - kAtEnd) result_.search_end = 1;
      if (found < gauss.low[0] + kAtEnd) result_.search_end = -1;
      const double sigma = std::min(fit.sigma(at++) / std::log(10.0), farthest());
      result_.sigma_log10_young = result_.search_end != 0 ? std::max(1.0, sigma) : sigma;
    }
    if (options_.fit_damping) result_.sigma_log_damping = fit.sigma(at++);
    if (options_.fit_release) result_.sigma_release = fit.sigma(at++);
  }

  void finish(const MarkerParameters& p) {
    const MarkerMotion& moved = motion(p, duration());
    result_.parameters = p;
    result_.young = young_ * p.young_factor;
    result_.markers = model_.bound();
    for (const int k : model_.bound()) result_.expected.name.push_back(tracks_.name[k]);
    Vec3d sum = Vec3d::Zero();
    double seen = 0, still = 0;
    for (size_t t = 0; t < measured_.time.size(); ++t) {
      const double s = measured_.time[t] - p.release;
      if (s < 0) continue;
      result_.expected.time.push_back(measured_.time[t]);
      result_.expected.position.emplace_back();
      result_.expected.weight.push_back(measured_.weight[t]);
      for (size_t k = 0; k < model_.bound().size(); ++k) {
        const Vec3d expected = moved.at(s, k);
        result_.expected.position.back().push_back(rest_[model_.bound()[k]] + expected);
        sum += measured_.weight[t][k] * (expected - measured_.displacement[t][k]).cwiseAbs2();
        still += measured_.weight[t][k] * measured_.displacement[t][k].squaredNorm();
        seen += measured_.weight[t][k];
      }
    }
    result_.rms_axis = (sum / seen).cwiseSqrt();
    result_.rms = std::sqrt(sum.sum() / seen);
    result_.rms_still = std::sqrt(still / seen);
  }

  const MarkerFitOptions& options_;
  const std::function<void(const std::string&)>& progress_;
  MarkerFitState state_;
  const MarkerFitSink& sink_;
  const MarkerTracks tracks_;  // without spikes
  MarkerWindowOptions window_;
  double onset_;
  std::vector<Vec3d> rest_;  // [K]
  MarkerModel model_;
  double young_ = 0;  // of the particles as given
  MarkerWindow measured_;
  int substeps_ = 0;
  std::map<std::pair<double, double>, MarkerMotion> motions_;  // by E factor and damping
  MarkerFitResult result_;
};

}  // namespace

MarkerFitResult fit_markers(const MarkerFitOptions& options, const Particles& particles,
                            const std::vector<Interaction>& interactions, const MarkerTracks& tracks,
                            const std::function<void(const std::string&)>& progress, MarkerFitState state,
                            const MarkerFitSink& sink) {
  return MarkerFit(options, particles, interactions, tracks, progress, std::move(state), sink).run();
}

}  // namespace pliant

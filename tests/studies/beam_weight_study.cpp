// Known push, frozen, another push: the silicone beam of shared/data/physics_beam, with real forces.
//   beam_weight_study DATA CELLS...   E and damping from the release under gravity; then also, with the density, from
//   the release with .51012 N on the tip's lower edge; what both say for 0, .51012 and 1.00062 N.  Each number of cells
//   starts from the one before, with its derivatives.
// grid=eulerian|lagrangian anywhere among them.  One JSON object per line.
// What held the tip was not gone at once: the swing is smaller than that of a body let go.  So its amplitude is a free
// factor, and what counts begins with the first low point.
// The body is elastic; silicone creeps.  So a sag comes twice: that of the elastic body, and after some seconds, which
// is larger by the creep that the fitted recordings themselves show.  Nothing is chosen by the load of 1.00062 N.

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "fitting/fit/marker_model.h"
#include "fitting/solve/correlation.h"
#include "fitting/solve/gauss_newton.h"
#include "tests/studies/silicone_beam.h"
#include "tests/studies/study_grid.h"

namespace pliant {
namespace {

using nlohmann::json;
using namespace fixture;

constexpr double kPi = 3.14159265358979324, kPoisson = 0.45, kSigma = 5e-4;
constexpr double kWindow = 1, kRange = 0.03, kFps = 200;  // s from the release, s about it
constexpr double kHung = 0.51012, kPredicted = 1.00062;   // N
// What no fit sees: where along the beam the markers sit, and what the grid leaves open (beam_study fem).
constexpr double kMarkerPlace = 2e-3, kGridSag = 0.03, kGridFrequency = 0.015;
GridKind grid = GridKind::kAutomatic;

/// A release, as measured.
struct Recording {
  std::string name;
  double weight = 0;  ///< N
  double from = 0, until = 0;
  MarkerTracks tracks;
  std::vector<Vec3d> rest;
  double onset = 0, first_low = 0;  ///< s

  Recording(const std::string& folder, const std::string& which, double newtons, double begin, double end)
      : name(which), weight(newtons), from(begin), until(end) {
    tracks = beam_recording(folder + "/beam_" + which + ".csv", folder + "/beam_gravity_a.csv", from, until);
    rest = mean_position(tracks, from, until);
    onset = onset_of_motion(tracks, rest);
    const auto fall = [&](size_t t) {
      const auto& x = tracks.position[t];
      return rest[0].x() - x[0].x() + rest[1].x() - x[1].x() + rest[2].x() - x[2].x();
    };
    size_t t = 1;
    while (t + 2 < tracks.samples() &&
           !(tracks.time[t] > onset + kRange && fall(t) > fall(t - 1) && fall(t) >= fall(t + 1)))
      ++t;
    first_low = tracks.time[t];
  }
  double final_sag() const { return mean_sag(tracks, from, until, tracks.time.back() - 0.5, tracks.time.back()); }
};

struct Parameters {
  double young = kPublishedYoung, density = kPublishedDensity;
  std::array<double, 2> damping_time = {0.35, 0.6}, release = {0, 0};  ///< s; of the recordings
  std::array<double, 2> amplitude = {1, 1};  ///< of the swing, as a share of that of a body let go at once
};

/// Sag of the markers at rest, m; frequency, Hz, and decay, 1/s, of their swing.
struct Figures {
  double sag = 0, frequency = 0, decay = 0;
  json to_json() const { return {{"sag_mm", 1e3 * sag}, {"frequency_Hz", frequency}, {"decay_1_s", decay}}; }
};

/// Of a swing y(t) about its centre: frequency and decay by its extremes.
Figures swing_figures(const std::vector<double>& y, double fps) {
  std::vector<double> time, value;
  for (size_t k = 1; k + 1 < y.size(); ++k) {
    const double a = y[k - 1], b = y[k], c = y[k + 1], bend = a - 2 * b + c;
    if (!((b > a && b >= c) || (b < a && b <= c)) || bend == 0) continue;
    const double v = b - 0.125 * (a - c) * (a - c) / bend;
    if (!value.empty() && std::abs(v - value.back()) < 0.15 * std::abs(value.front())) continue;  // a higher mode
    time.push_back((static_cast<double>(k) + 0.5 * (a - c) / bend) / fps);
    value.push_back(v);
  }
  Figures out;
  if (value.size() < 4) return out;
  const size_t last = value.size() - 1;
  out.frequency = 0.5 * static_cast<double>(last) / (time[last] - time[0]);
  // Differences of successive extremes do not depend on the centre.
  const double first = std::abs(value[1] - value[0]), end = std::abs(value[last] - value[last - 1]);
  out.decay = std::log(first / end) / (time[last - 1] - time[0]);
  return out;
}

std::vector<double> fall_of(const Recording& r, double seconds, double fps) {
  std::vector<double> y, at;
  for (double t = 0; t < seconds; t += 1 / fps) at.push_back(r.onset + t);
  for (const auto& frame : resampled(r.tracks, at).position) {
    double sum = 0;
    for (size_t k = 0; k < 3; ++k) sum += r.rest[k].x() - frame[k].x();
    y.push_back(sum / 3);
  }
  return y;
}

class Model {
 public:
  Model(int cells, const std::vector<Recording>& recordings) : cells_(cells), recordings_(recordings) {
    // One time step for all, so that differences see only what parameters do.
    MarkerModelOptions o = options();
    const Beam b = silicone_beam(cells, 1.5 * kPublishedYoung, kPoisson);
    const MarkerModel stiff(o, b.particles, b.interactions, recordings[0].rest);
    stiff.run({1, 0.3, 0}, 1 / kFps);
    substeps_ = stiff.substeps();
  }

  /// Displacements of the markers of recording r under a weight [N].
  const MarkerMotion& motion(size_t r, const Parameters& p, double weight, double damping_time, double duration,
                             DampingKind kind = DampingKind::kMassProportional) {
    const std::array<double, 7> key = {static_cast<double>(r),   p.young, p.density, weight, damping_time, duration,
                                       static_cast<double>(kind)};
    const auto known = motions_.find(key);
    if (known != motions_.end()) return known->second;
    MarkerModelOptions o = options();
    o.damping = kind;
    const Beam b = silicone_beam(cells_, p.young, kPoisson, p.density, weight);
    ++rollouts;
    return motions_[key] = MarkerModel(o, b.particles, b.interactions, recordings_[r].rest)
                               .run({1, damping_time, 0}, duration, substeps_);
  }

  Figures figures(size_t r, const Parameters& p, double weight, double damping_time,
                  DampingKind kind = DampingKind::kMassProportional) {
    const MarkerMotion& still = motion(r, p, weight, 0.12, 0.9);
    const MarkerMotion& swing = motion(r, p, weight, damping_time, 1.1, kind);
    std::vector<double> y;
    for (const auto& frame : swing.displacement) y.push_back(-(frame[0] + frame[1] + frame[2]).x() / 3);
    Figures out = swing_figures(y, kFps);
    for (size_t k = 0; k < 3; ++k) out.sag -= still.at(0.89, k).x() / 3;
    return out;
  }

  int rollouts = 0;

 private:
  MarkerModelOptions options() const {
    MarkerModelOptions o;
    o.simulate.gravity.setZero();
    o.simulate.fps = kFps;
    o.simulate.courant = 0.5;
    o.simulate.grid = grid;
    o.reach = 0.02;
    return o;
  }

  int cells_;
  const std::vector<Recording>& recordings_;
  int substeps_ = 0;
  std::map<std::array<double, 7>, MarkerMotion> motions_;
};

/// What is fitted to which recordings.
struct Plan {
  std::string name;
  std::vector<size_t> recordings;
  bool density = false;
};

struct Fit {
  Parameters parameters;
  double sigma_log_young = 0, sigma_log_density = 0;
  std::array<double, 2> rms = {0, 0};  ///< m, of each recording
  Eigen::MatrixXd jacobian;
  bool converged = false;
};

Fit fit(const Plan& plan, Model& model, const std::vector<Recording>& recordings, const Parameters& start,
        const Eigen::MatrixXd& jacobian) {
  GaussNewtonOptions gauss;
  std::vector<double> from;
  const auto unknown = [&](double value, double difference, double largest) {
    from.push_back(value);
    gauss.difference.push_back(difference);
    gauss.largest_step.push_back(largest);
  };
  unknown(std::log(start.young), 0.02, 0.2);
  if (plan.density) unknown(std::log(start.density), 0.03, 0.2);
  for (const size_t r : plan.recordings) {
    unknown(std::log(start.damping_time[r]), 0.05, 1);
    unknown(start.release[r], 1e-3, 0.02);
    unknown(start.amplitude[r], 0.05, 0.5);
  }
  gauss.tolerance = 1e-4;
  gauss.max_iterations = jacobian.size() > 0 ? 3 : 8;
  gauss.jacobian = jacobian;
  const auto parameters_of = [&](std::span<const double> x) {
    Parameters p = start;
    size_t at = 0;
    p.young = std::exp(x[at++]);
    if (plan.density) p.density = std::exp(x[at++]);
    for (const size_t r : plan.recordings) {
      p.damping_time[r] = std::exp(x[at++]);
      p.release[r] = x[at++];
      p.amplitude[r] = x[at++];
    }
    return p;
  };
  const auto residuals_of = [&](size_t r, const Parameters& p) {
    const Recording& real = recordings[r];
    const MarkerMotion& motion = model.motion(r, p, real.weight, p.damping_time[r], kWindow + kRange + 3 / kFps);
    const MarkerMotion& still = model.motion(r, p, real.weight, 0.12, 0.9);
    std::vector<double> out;
    for (size_t t = 0; t < real.tracks.samples(); ++t) {
      const double time = real.tracks.time[t];
      if (time < real.first_low || time > real.onset + kWindow) continue;
      for (size_t k = 0; k < 3; ++k) {
        const Vec3d sag = still.at(0.89, k), swung = sag + p.amplitude[r] * (motion.at(time - p.release[r], k) - sag);
        for (const double d : Vec3d(swung - (real.tracks.position[t][k] - real.rest[k]))) out.push_back(d / kSigma);
      }
    }
    return out;
  };
  const auto found = gauss_newton(
      gauss,
      [&](std::span<const double> x) {
        std::vector<double> out;
        for (const size_t r : plan.recordings) {
          const std::vector<double> one = residuals_of(r, parameters_of(x));
          out.insert(out.end(), one.begin(), one.end());
        }
        return out;
      },
      from);
  Fit result;
  result.parameters = parameters_of(found.parameters);
  result.jacobian = found.jacobian;
  result.converged = found.summary.converged;
  for (const size_t r : plan.recordings) {
    double squares = 0;
    const std::vector<double> one = residuals_of(r, result.parameters);
    for (const double x : one) squares += x * x;
    result.rms[r] = kSigma * std::sqrt(3 * squares / static_cast<double>(one.size()));
  }
  // Errors of a marker go on for a while, and neighbours share them.
  std::vector<Vec3f> place;
  for (const Vec3d& x : recordings[plan.recordings[0]].rest) place.push_back(x.cast<float>());
  const Eigen::MatrixXd covariance =
      found.jacobian.size() > 0
          ? covariance_with(ErrorCorrelation(found.residuals, place, 3), found.jacobian, found.covariance)
          : found.covariance;
  result.sigma_log_young = std::sqrt(covariance(0, 0));
  if (plan.density) result.sigma_log_density = std::sqrt(covariance(1, 1));
  return result;
}

void print(const json& j) {
  std::printf("%s\n", j.dump().c_str());
  std::fflush(stdout);
}

/// Sag of the middle of the tip at the published E and density, against that of the tip face by finite elements:
/// 27-node hexahedra, neo-Hookean, large displacements, nu = .45, the weight along the lower edge.
void compare_with_finite_elements(int cells) {
  constexpr double kSag = 6.786e-3, kHungSag = 15.801e-3;
  double sag[2];
  for (const bool hung : {false, true}) {
    const Beam b = silicone_beam(cells, kPublishedYoung, kPoisson, kPublishedDensity, hung ? kHung : 0);
    MarkerModelOptions o;
    o.simulate.gravity.setZero();
    o.simulate.fps = 50;
    o.simulate.courant = 0.5;
    o.simulate.grid = grid;
    const std::vector<Vec3d> tip = {{0.5 * kBeamHeight, 0.5 * kBeamHeight, kBeamLength}};
    sag[hung] = -MarkerModel(o, b.particles, b.interactions, tip).run({1, 0.12, 0}, 0.9).at(0.89, 0).x();
  }
  print({{"study", "finite elements"},
         {"cells", cells},
         {"sag_mm", 1e3 * sag[0]},
         {"sag_error", sag[0] / kSag - 1},
         {"hung_sag_mm", 1e3 * sag[1]},
         {"hung_sag_error", sag[1] / kHungSag - 1}});
}

/// What a fit says of a weight, with bands of one standard deviation, and where they come from.
json prediction(const Plan& plan, const Fit& fit, Model& model, const std::vector<Recording>& recordings,
                double weight) {
  const Parameters& p = fit.parameters;
  // Markers where they sat under a weight; damping of the fitted recording that is most alike.
  const size_t like = weight > 0 ? plan.recordings.back() : plan.recordings.front();
  const Figures mid = model.figures(weight > 0 ? 1 : 0, p, weight, p.damping_time[like]);
  // Creep that the fitted recordings show, and how far they differ in it.
  double creep = 0, least = INFINITY, most = 0;
  for (const size_t r : plan.recordings) {
    const double one = recordings[r].final_sag() / model.figures(r, p, recordings[r].weight, p.damping_time[r]).sag;
    creep += one / static_cast<double>(plan.recordings.size());
    least = std::min(least, one);
    most = std::max(most, one);
  }
  // Damping as a share of the critical one depends on the frequency as that of the mass or as that of the strain rate;
  // what lies between is taken, and of two recordings the power of the frequency that joins them.
  const Figures fitted =
      model.figures(plan.recordings[0], p, recordings[plan.recordings[0]].weight, p.damping_time[plan.recordings[0]]);
  const double rate = 1 / p.damping_time[plan.recordings[0]];
  double power = 1;  // rate goes as frequency^power: 0 mass, 2 strain rate
  if (plan.recordings.size() > 1) {
    const Figures other = model.figures(1, p, recordings[1].weight, p.damping_time[1]);
    power = std::log(p.damping_time[0] / p.damping_time[1]) / std::log(other.frequency / fitted.frequency);
  }
  const double ratio = mid.frequency / fitted.frequency, decay = rate * std::pow(ratio, power);
  const double decay_spread = plan.recordings.size() > 1 ? 0.15 * decay : 0.5 * std::abs(rate - rate * ratio * ratio);
  const double place = 1.3 * kMarkerPlace / kBeamLength;  // of the slope at the tip
  const double elastic = std::hypot(fit.sigma_log_young, kGridSag, place);
  const double slow = std::hypot(elastic, 0.5 * (most - least) / creep);
  const double swing = std::hypot(kGridFrequency, 0.5 * fit.sigma_log_young);
  return {{"study", "prediction"},
          {"from", plan.name},
          {"weight_N", weight},
          {"sag_elastic_mm", 1e3 * mid.sag},
          {"sag_elastic_sigma_mm", 1e3 * mid.sag * elastic},
          {"creep", creep},
          {"sag_after_seconds_mm", 1e3 * mid.sag * creep},
          {"sag_after_seconds_sigma_mm", 1e3 * mid.sag * creep * slow},
          {"frequency_Hz", mid.frequency},
          {"frequency_sigma_Hz", mid.frequency * swing},
          {"decay_1_s", decay},
          {"decay_sigma_1_s", decay_spread},
          {"decay_power_of_frequency", power}};
}

void study(const std::string& folder, const std::vector<int>& grids) {
  const std::vector<Recording> recordings = {{folder, "gravity_a", 0, 0.2, 0.6}, {folder, "load52_a", kHung, 0.1, 0.4}};
  const std::vector<Recording> repeats = {{folder, "gravity_b", 0, 0.2, 0.6}, {folder, "load52_b", kHung, 0.1, 0.4}};
  for (const auto* set : {&recordings, &repeats})
    for (const Recording& r : *set) {
      json j = swing_figures(fall_of(r, 1.1, kFps), kFps).to_json();
      j["study"] = "measured";
      j["recording"] = r.name;
      j["sag_mm"] = 1e3 * r.final_sag();
      j["sag_after_1_s_mm"] = 1e3 * mean_sag(r.tracks, r.from, r.until, r.onset + 0.8, r.onset + 1.3);
      j["onset_s"] = r.onset;
      print(j);
    }
  const std::vector<Plan> plans = {
      {"gravity", {0}, false}, {"load alone, density given", {1}, false}, {"gravity and load", {0, 1}, true}};
  std::vector<Fit> fits(plans.size());
  for (Fit& f : fits) f.parameters.release = {recordings[0].onset, recordings[1].onset};
  for (const int cells : grids) {
    compare_with_finite_elements(cells);
    Model model(cells, recordings);
    for (size_t k = 0; k < plans.size(); ++k) {
      // A first fit starts where the one to gravity ended.
      if (cells == grids[0] && k > 0) fits[k].parameters.young = fits[0].parameters.young;
      if (cells == grids[0] && k == 2)
        for (const size_t r : {0, 1}) {
          fits[k].parameters.damping_time[r] = fits[r].parameters.damping_time[r];
          fits[k].parameters.release[r] = fits[r].parameters.release[r];
          fits[k].parameters.amplitude[r] = fits[r].parameters.amplitude[r];
        }
      fits[k] = fit(plans[k], model, recordings, fits[k].parameters, fits[k].jacobian);
      const Fit& f = fits[k];
      print({{"study", "fit"},
             {"to", plans[k].name},
             {"cells", cells},
             {"young_Pa", f.parameters.young},
             {"sigma_log_young", f.sigma_log_young},
             {"density", f.parameters.density},
             {"sigma_log_density", f.sigma_log_density},
             {"damping_time_s", f.parameters.damping_time},
             {"release_s", f.parameters.release},
             {"amplitude", f.parameters.amplitude},
             {"rms_mm", {1e3 * f.rms[0], 1e3 * f.rms[1]}},
             {"converged", f.converged},
             {"rollouts", model.rollouts}});
      if (k == 1) continue;  // says how much softer larger strain is, and predicts nothing
      for (const double weight : {0.0, kHung, kPredicted}) {
        json j = prediction(plans[k], f, model, recordings, weight);
        j["cells"] = cells;
        print(j);
      }
    }
  }
}

}  // namespace
}  // namespace pliant

int main(int argc, char** argv) {
  using namespace pliant;
  pliant::grid = pliant::fixture::take_grid(argc, argv);
  if (argc < 3) {
    std::fprintf(stderr, "usage: beam_weight_study [grid=eulerian|lagrangian] DATA CELLS...\n");
    return 2;
  }
  std::vector<int> grids;
  for (int i = 2; i < argc; ++i) grids.push_back(std::atoi(argv[i]));
  study(argv[1], grids);
  return 0;
}

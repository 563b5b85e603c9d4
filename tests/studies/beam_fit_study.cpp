// E of the real silicone beam 30 x 30 x 100 mm, clamped at one end, from motion capture of its release under gravity.
//   beam_fit_study fit A.csv WRONG CELLS...   from WRONG times the published E, over these numbers of cells in the
//   height beam_fit_study predict A.csv B.csv CELLS YOUNG DAMPING_TIME   run b with only its release instant fitted,
//   beside two naive
//                         predictors; then masses hung at the tip
//   beam_fit_study kelvin A.csv CELLS YOUNG DAMPING_TIME   both kinds of damping
// grid=eulerian|lagrangian anywhere among them; default: the solver's own choice.  One JSON object per case.

#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <string>

#include "fitting/fit/fit_markers.h"
#include "tests/studies/silicone_beam.h"
#include "tests/studies/study_grid.h"

namespace pliant {
namespace {

using nlohmann::json;
using namespace fixture;

constexpr double kPi = 3.14159265358979324;
GridKind grid = GridKind::kAutomatic;
constexpr double kPoisson = 0.45;
constexpr double kFrom = 0.2, kUntil = 0.6;  // s at which both recordings are at rest

Beam beam(int cells, double young) { return silicone_beam(cells, young, kPoisson); }

MarkerTracks recording(const std::string& file) { return beam_recording(file, file, kFrom, kUntil); }

MarkerFitOptions options() {
  MarkerFitOptions o;
  o.model.simulate.gravity.setZero();
  o.model.simulate.fps = 200;
  o.model.simulate.courant = 0.5;
  o.model.simulate.grid = grid;
  o.model.reach = 0.012;
  o.rest_begin = kFrom;
  return o;
}

json report(const char* study, int cells, const MarkerFitResult& r) {
  json search = json::array();
  for (const auto& c : r.search) search.push_back({{"young", c.young}, {"rms_mm", 1e3 * c.rms}});
  return {{"study", study},
          {"cells", cells},
          {"young", r.young},
          {"sigma_log10_young", r.sigma_log10_young},
          {"damping_time", r.parameters.damping_time},
          {"sigma_log_damping", r.sigma_log_damping},
          {"release", r.parameters.release},
          {"sigma_release", r.sigma_release},
          {"rms_mm", 1e3 * r.rms},
          {"rms_axis_mm", {1e3 * r.rms_axis.x(), 1e3 * r.rms_axis.y(), 1e3 * r.rms_axis.z()}},
          {"markers", r.markers},
          {"search", search},
          {"loss", r.loss},
          {"converged", r.converged},
          {"rollouts", r.rollouts},
          {"simulated_seconds", r.simulated_seconds},
          {"seconds", r.seconds}};
}

void print(const json& j) {
  std::printf("%s\n", j.dump().c_str());
  std::fflush(stdout);
}

/// From WRONG times the published E at the first number of cells; finer grids start where the coarser one ended, with
/// its derivatives.
void fit(const std::string& a, double wrong, const std::vector<int>& grids) {
  const MarkerTracks tracks = recording(a);
  MarkerFitOptions o = options();
  double young = wrong * kPublishedYoung;
  for (const int cells : grids) {
    const Beam body = beam(cells, young);
    const MarkerFitResult r = fit_markers(o, body.particles, body.interactions, tracks);
    json j = report("fit", cells, r);
    j["start"] = young;
    print(j);
    young = r.young;
    o.search = false;
    o.damping_time = r.parameters.damping_time;
    o.jacobian = r.jacobian;
    o.max_iterations = 3;
  }
}

/// rms over markers and samples of the first second, m, of displacements that a naive predictor gives: distance, and
/// along x.
template <class Expected>
std::pair<double, double> naive(const MarkerTracks& tracks, const MarkerFitResult& like, Expected&& expected) {
  const auto rest = mean_position(tracks, kFrom, kUntil);
  double all = 0, down = 0, n = 0;
  for (const double t : like.expected.time) {
    const MarkerTracks now = resampled(tracks, std::vector<double>{t});
    for (int k = 0; k < 3; ++k, ++n) {
      const Vec3d d = expected(t - like.parameters.release, k) - (now.position[0][k] - rest[k]);
      all += d.squaredNorm();
      down += d.x() * d.x();
    }
  }
  return {std::sqrt(all / n), std::sqrt(down / n)};
}

void predict(const std::string& a, const std::string& b, int cells, double young, double damping_time) {
  const MarkerTracks first = recording(a), second = recording(b);
  const Beam body = beam(cells, young);
  MarkerFitOptions o = options();
  o.search = o.fit_young = o.fit_damping = false;
  o.damping_time = damping_time;
  const MarkerFitResult model = fit_markers(o, body.particles, body.interactions, second);
  json j = report("run b", cells, model);
  print(j);
  // Naive 1: it hangs where run a ended.  Naive 2: the same E without damping.
  const auto rest = mean_position(first, kFrom, kUntil),
             last = mean_position(first, first.time.back() - 0.5, first.time.back());
  const auto [sag, sag_x] = naive(second, model, [&](double, int k) { return Vec3d(last[k] - rest[k]); });
  const MarkerModel undamped(o.model, body.particles, body.interactions, mean_position(second, kFrom, kUntil));
  const MarkerMotion motion = undamped.run({1, 0, 0}, 1.1);
  const auto [swing, swing_x] = naive(second, model, [&](double s, int k) { return motion.at(s, k); });
  print({{"study", "naive"},
         {"static_sag_rms_mm", 1e3 * sag},
         {"static_sag_rms_x_mm", 1e3 * sag_x},
         {"undamped_rms_mm", 1e3 * swing},
         {"undamped_rms_x_mm", 1e3 * swing_x},
         {"final_sag_a_mm", 1e3 * mean_sag(first, kFrom, kUntil, 4.5, 5)},
         {"final_sag_b_mm", 1e3 * mean_sag(second, kFrom, kUntil, 4.5, 5)},
         {"sag_a_after_1_s_mm", 1e3 * mean_sag(first, kFrom, kUntil, 1.6, 1.86)}});
}

/// Both kinds of damping fitted to run a at the same E, from the same damping ratio of the first mode: 1 / (omega t)
/// and omega t / 2.
void kelvin(const std::string& a, int cells, double young, double damping_time) {
  const MarkerTracks tracks = recording(a);
  const Beam body = beam(cells, young);
  MarkerFitOptions o = options();
  o.search = o.fit_young = false;
  o.max_iterations = 3;
  o.damping_time = damping_time;
  print(report("mass proportional", cells, fit_markers(o, body.particles, body.interactions, tracks)));
  o.model.damping = DampingKind::kKelvinVoigt;
  o.damping_time = 2 / (damping_time * std::pow(2 * kPi * 7.75, 2));
  print(report("Kelvin-Voigt", cells, fit_markers(o, body.particles, body.interactions, tracks)));
}

}  // namespace
}  // namespace pliant

int main(int argc, char** argv) {
  using namespace pliant;
  pliant::grid = pliant::fixture::take_grid(argc, argv);
  const std::string study = argc > 1 ? argv[1] : "";
  if (study == "fit" && argc >= 5) {
    std::vector<int> grids;
    for (int i = 4; i < argc; ++i) grids.push_back(std::atoi(argv[i]));
    fit(argv[2], std::atof(argv[3]), grids);
  } else if (study == "predict" && argc == 7) {
    predict(argv[2], argv[3], std::atoi(argv[4]), std::atof(argv[5]), std::atof(argv[6]));
  } else if (study == "kelvin" && argc == 6) {
    kelvin(argv[2], std::atoi(argv[3]), std::atof(argv[4]), std::atof(argv[5]));
  } else {
    std::fprintf(stderr,
                 "usage: beam_fit_study [grid=eulerian|lagrangian] fit A.csv WRONG CELLS... | predict A.csv B.csv "
                 "CELLS YOUNG DAMPING_TIME "
                 "| kelvin A.csv CELLS YOUNG DAMPING_TIME\n");
    return 2;
  }
  return 0;
}

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
#include "tests/physics/shapes.h"
#include "tests/studies/study_grid.h"

namespace pliant {
namespace {

using nlohmann::json;

constexpr double kPi = 3.14159265358979324;
GridKind grid = GridKind::kAutomatic;
constexpr double kPublished = 263824, kPoisson = 0.45, kDensity = 1070, kHeight = 0.03, kLength = 0.1, kGravity = 9.81;
constexpr double kFrom = 0.2, kUntil = 0.6;  // s at which both recordings are at rest

/// The beam along z, clamped at z = 0 by a foot of three cells; up is x.  Eight particles to a cell.
struct Beam {
  Particles particles;
  std::vector<Interaction> interactions;
  double dx = 0;
};

Beam beam(int cells, double young) {
  Beam out;
  out.dx = kHeight / cells;
  out.particles =
      fixture::block<float>({kHeight, kHeight, kLength + 3 * out.dx}, out.dx, 0.0, young, kPoisson, kDensity);
  for (Vec3f& x : out.particles.position) x.z() -= static_cast<float>(3 * out.dx);
  Interaction pin, load;
  pin.type = InteractionType::kPin;
  pin.region = Region::half_space(Vec3d::Zero(), Vec3d(0, 0, 1));
  load.type = InteractionType::kGust;
  load.vector = Vec3d(-kGravity, 0, 0);
  out.interactions = {pin, load};
  return out;
}

/// The recording in the beam's frame.  Where the beam lies in the frame of the cameras is not documented: the outermost
/// marker is taken to be at the tip; of the two across, the beam's axis is midway between the markers on its sides, and
/// at the height at which the final tilt of the section leaves only the shortening that bending causes.
MarkerTracks recording(const std::string& file) {
  MarkerTracks tracks = read_markers(file);
  const std::vector<Vec3d> rest = mean_position(tracks, kFrom, kUntil),
                           last = mean_position(tracks, tracks.time.back() - 0.5, tracks.time.back());
  const Vec3d top = last[0] - rest[0], low = last[2] - rest[2];
  const double tilt = (top.z() - low.z()) / (rest[0].x() - rest[2].x());
  const double shortening = 0.5 * tilt * tilt * kLength * 0.643;  // integral of the slope squared, uniform load
  const double axis = rest[0].x() - (top.z() + shortening) / tilt;
  const Vec3d origin(axis - 0.5 * kHeight, 0.5 * (rest[1].y() + rest[2].y()) - 0.5 * kHeight, rest[1].z() - kLength);
  // The other three markers are on the clamp.
  tracks.name.resize(3);
  for (auto& frame : tracks.position) {
    frame.resize(3);
    for (Vec3d& x : frame) x -= origin;
  }
  for (auto& frame : tracks.weight) frame.resize(3);
  return tracks;
}

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

/// Mean fall of the markers, m, over the samples in [begin, end].
double mean_sag(const MarkerTracks& tracks, double begin, double end) {
  const auto rest = mean_position(tracks, kFrom, kUntil), now = mean_position(tracks, begin, end);
  return (rest[0] - now[0] + rest[1] - now[1] + rest[2] - now[2]).x() / 3;
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
  double young = wrong * kPublished;
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

/// Static sag and frequency with a weight [N] hung at the tip: its mass joined to the outermost layer of cells, which
/// it does not stiffen.
json hung(int cells, double young, double damping_time, double weight, const MarkerTracks& tracks) {
  Beam b = beam(cells, young);
  Particles& p = b.particles;
  std::vector<size_t> layer;
  for (size_t i = 0; i < p.size(); ++i)
    if (p.position[i].z() > kLength - b.dx) layer.push_back(i);
  const double mass = weight / kGravity;
  for (const size_t i : layer) p.mass[i] += static_cast<float>(mass / static_cast<double>(layer.size()));
  const auto rest = mean_position(tracks, kFrom, kUntil);
  MarkerModelOptions o = options().model;
  const std::vector<Vec3d> places = {rest[0], rest[1], rest[2], {0.5 * kHeight, 0.5 * kHeight, kLength}};
  const MarkerModel model(o, p, b.interactions, places);
  // At rest: strongly damped; the frequency: of the swing after release with the fitted damping.
  const MarkerMotion still = model.run({1, 0.12, 0}, 0.9), swing = model.run({1, damping_time, 0}, 1.1);
  double sag = 0;
  for (int k = 0; k < 3; ++k) sag -= still.at(0.89, k).x() / 3;
  std::vector<double> crossings;
  double before = 0, before_time = 0;
  for (double t = 0.005; t < 1.09; t += 0.001) {
    const double y = -(swing.at(t, 0) + swing.at(t, 1) + swing.at(t, 2)).x() / 3 - sag;
    if (before < 0 && y >= 0) crossings.push_back(before_time + (t - before_time) * before / (before - y));
    before = y;
    before_time = t;
  }
  const double frequency = (static_cast<double>(crossings.size()) - 1) / (crossings.back() - crossings.front());
  return {{"study", "hung"},
          {"cells", cells},
          {"weight_N", weight},
          {"sag_of_markers_mm", 1e3 * sag},
          {"sag_of_tip_mm", -1e3 * still.at(0.89, 3).x()},
          {"frequency", frequency},
          {"periods", crossings.size() - 1}};
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
         {"final_sag_a_mm", 1e3 * mean_sag(first, 4.5, 5)},
         {"final_sag_b_mm", 1e3 * mean_sag(second, 4.5, 5)},
         {"sag_a_after_1_s_mm", 1e3 * mean_sag(first, 1.6, 1.86)}});
  for (const double weight : {0.0, 0.510, 1.001}) print(hung(cells, young, damping_time, weight, first));
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

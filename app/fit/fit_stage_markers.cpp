#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "app/fit/fit_limits.h"
#include "app/fit/fit_options.h"
#include "app/fit/fit_progress.h"
#include "app/fit/fit_report.h"
#include "app/fit/start_material.h"
#include "app/import/interactions.h"
#include "app/report/chart.h"
#include "app/run/attach_scene.h"
#include "app/simulate/simulate_stage.h"
#include "app/simulate/simulated_body.h"
#include "app/store/material.h"
#include "app/store/velocity.h"
#include "fitting/fit/fit_markers.h"
#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/images/image_io.h"

namespace pliant {
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

/// Rows: the scene's axes; one entry of each row and column is 1 or -1.
Mat3d parse_axes(const std::string& text) {
  const auto refused = [&] {
    return usage_error("--marker-axes", text, "does not name each column once", "write it like x,y,z or y,-x,z");
  };
  Mat3d axes = Mat3d::Zero();
  size_t begin = 0;
  for (int row = 0; row < 3; ++row) {
    const size_t end = std::min(text.find(',', begin), text.size());
    if (begin > text.size()) throw refused();
    std::string word = text.substr(begin, end - begin);
    const double sign = !word.empty() && word[0] == '-' ? -1 : 1;
    if (!word.empty() && (word[0] == '-' || word[0] == '+')) word.erase(0, 1);
    if (word.size() != 1 || word[0] < 'x' || word[0] > 'z') throw refused();
    axes(row, word[0] - 'x') = sign;
    begin = end + 1;
  }
  if (begin != text.size() + 1 || std::abs(std::abs(axes.determinant()) - 1) > 0.5) throw refused();
  return axes;
}

/// The recording in metres along the scene's axes, as the particles are.
MarkerTracks markers_in_scene(const MarkerStage& stage, const Scene& scene) {
  const double unit = stage.units == "scene" ? scene.metres_per_unit : 1;
  MarkerTracks tracks = read_markers(stage.file, unit);
  const Mat3d axes = parse_axes(stage.axes);
  if (axes.determinant() < 0)
    throw usage_error("--marker-axes", stage.axes, "mirrors the markers",
                      "one sign, or the order of two columns, is wrong");
  const Vec3d offset = stage.offset.empty() ? Vec3d::Zero() : Vec3d(stage.offset[0], stage.offset[1], stage.offset[2]);
  for (auto& frame : tracks.position)
    for (Vec3d& x : frame) x = axes * x + unit * offset;
  return tracks;
}

/// What acts from the release on: a script, or the gravity that the body was kept from before; and what holds it.
std::vector<Interaction> load_of(const MarkerStage& stage, const Scene& scene, const ParticleFile& file) {
  std::vector<Interaction> all;
  if (stage.interactions.empty()) {
    Interaction gravity;
    gravity.type = InteractionType::kGust;
    gravity.vector = -9.81 * scene.up;
    all.push_back(gravity);
  } else {
    all = parse_interactions(read_text(stage.interactions), {scene.metres_per_unit, scene.up}, stage.interactions);
  }
  const std::vector<Interaction> pins = pins_of(file.pinned_json, scene);
  all.insert(all.end(), pins.begin(), pins.end());
  return all;
}

/// About twice as many states as samples, so that what is between them is smooth.
double state_rate(const MarkerTracks& tracks) {
  const double rate = static_cast<double>(tracks.samples() - 1) / (tracks.time.back() - tracks.time.front());
  return std::clamp(2 * rate, 60.0, 400.0);
}

/// Distance from rest over time of the marker that moves most, and of the others up to four: measured and expected.
ImageF marker_chart(const MarkerTracks& tracks, const MarkerFitResult& r, const MarkerFitOptions& options) {
  const MarkerTracks& expected = r.expected;
  std::vector<std::pair<double, size_t>> order;
  const std::vector<Vec3d> rest = mean_position(tracks, options.rest_begin, r.parameters.release);
  for (size_t k = 0; k < expected.markers(); ++k) {
    double most = 0;
    for (const auto& frame : expected.position) most = std::max(most, (frame[k] - rest[r.markers[k]]).norm());
    order.push_back({-most, k});
  }
  std::sort(order.begin(), order.end());
  order.resize(std::min<size_t>(order.size(), 4));
  Chart chart;
  chart.title = "Markers after the release: measured (dots) and simulated (lines)";
  chart.x_label = "recording time [s]";
  chart.y_label = "distance from rest [mm]";
  chart.from_zero = true;
  chart.marks = {r.parameters.release + options.window};
  int color = 0;
  for (const auto& [most, k] : order) {
    Curve measured{"", {}, {}, true, color}, simulated{tracks.name[r.markers[k]], {}, {}, false, color};
    ++color;
    for (size_t t = 0; t < expected.samples(); ++t) {
      simulated.x.push_back(expected.time[t]);
      simulated.y.push_back(1e3 * (expected.position[t][k] - rest[r.markers[k]]).norm());
      const size_t row =
          std::lower_bound(tracks.time.begin(), tracks.time.end(), expected.time[t]) - tracks.time.begin();
      measured.x.push_back(expected.time[t]);
      measured.y.push_back(
          expected.weight[t][k] > 0 ? 1e3 * (tracks.position[row][r.markers[k]] - rest[r.markers[k]]).norm() : NAN);
    }
    chart.curves.push_back(measured);
    chart.curves.push_back(simulated);
  }
  return draw_chart(chart);
}

ImageF search_chart(const MarkerFitResult& r) {
  Curve curve{"", {}, {}, true, 0}, best{"fitted", {std::log10(r.young)}, {1e3 * r.rms}, true, 1};
  for (const auto& c : r.search) {
    curve.x.push_back(std::log10(c.young));
    curve.y.push_back(1e3 * c.rms);
  }
  return draw_chart({"Search: marker RMSE for each stiffness",
                     "log10 of Young's modulus [Pa]",
                     "RMSE [mm]",
                     {curve, best},
                     {},
                     true});
}

}  // namespace

json fit_to_markers(const Context& context, const RunDirectory& run, const FitInputs& in,
                    const std::string& provenance) {
  const FitStage& stage = in.options;
  const Scene& scene = in.scene;
  const MarkerStage& m = stage.markers;
  parse_axes(m.axes);
  const MarkerTracks tracks = markers_in_scene(m, scene);
  ParticleFile particles = read_particles(in.files.at("particles"));
  StartMaterial material = start_material(in, particles, &context.progress);
  const bool guessed = !material.given && material.young == kUnknownYoung && !stage.material.young;
  const SimulatedBody body = make_body(std::move(particles), scene, material.solid, material.law);
  const std::vector<Interaction> load = load_of(m, scene, body.file);
  MarkerFitOptions options;
  options.model.simulate = rollout_options(stage);
  options.model.simulate.gravity = m.interactions.empty() ? Vec3d::Zero() : Vec3d(-9.81 * scene.up);
  options.model.simulate.fps = state_rate(tracks);
  options.model.simulate.courant = 0.5;
  options.model.reach = m.reach > 0 ? m.reach : 2 * body.particles.cell_size;
  options.release_range =
      std::clamp(0.15 * m.window, 0.03, 0.2);  // a slow body has moved little when it is seen to move
  options.window = m.window;
  options.search_decades = guessed ? 2 : 1.5;
  if (m.rest) options.rest_begin = *m.rest;
  if (m.release) options.release = *m.release;
  const auto say = [&](const std::string& line) {
    if (context.interrupted())
      throw Error(Failure::kInterrupted, "fit", "", "interrupted", "run the same command again");
    context.progress.say("fit: " + line);
  };
  say(fmt::format("{} markers, {} samples from {:.4g} s to {:.4g} s", tracks.markers(), tracks.samples(),
                  tracks.time.front(), tracks.time.back()));
  const KeptMarkerFit kept = kept_marker_fit(context, run, provenance);
  MarkerFitResult found = fit_markers(options, body.particles, load, tracks, say, kept.state, kept.sink);
  // E of the material: that of driving particles is lower in thin parts.
  const double of_material = material.young * found.parameters.young_factor / found.young;
  found.young *= of_material;
  for (auto& point : found.search) point.young *= of_material;
  for (const std::string& warning : found.warnings) context.progress.warn(warning);
  for (const std::string& doubt : doubts_of(found, options)) context.progress.warn("fit: " + doubt);

  // As much again, that the fit has not seen: a prediction.
  MarkerFitOptions later = options;
  later.fit_young = later.fit_damping = later.fit_release = later.search = false;
  later.release = found.parameters.release;
  later.damping_time = found.parameters.damping_time;
  later.window = std::min(2 * options.window, tracks.time.back() - found.parameters.release);
  Particles fitted = body.particles;
  for (float& young : fitted.young) young = static_cast<float>(young * found.parameters.young_factor);
  const bool more = later.window > 1.05 * options.window;
  const MarkerFitResult seen = more ? fit_markers(later, fitted, load, tracks) : found;

  clear_fit_pictures(run);
  ElasticSamples& solid = material.solid;
  for (float& young : solid.young) young = static_cast<float>(young * found.parameters.young_factor);
  MaterialFile stored{solid.young, solid.poisson, solid.density, "", {}, {}};
  stored.source =
      std::string(material.given ? "the initial material times one factor" : "homogeneous") + ", fitted to markers";
  stored.branch = solid.branch;
  write_material(run / in.outputs[0], stored, provenance);
  VelocityFile start;
  const size_t n = body.particles.size();
  start.velocity.assign(n, Vec3f::Zero());
  start.displacement.assign(n, Vec3f::Zero());
  start.F.assign(n, Mat3f::Identity());
  start.C.assign(n, Mat3f::Zero());
  start.position = body.file.driving_position;
  start.time = found.parameters.release;
  start.damping_time = found.parameters.damping_time;
  start.source = "at rest until its release";
  write_velocity(run / in.outputs[1], start, provenance);
  write_image(run / "fit/markers.png", marker_chart(without_spikes(tracks, options.rest_begin), seen, options));
  write_image(run / "fit/search.png", search_chart(found));

  say(fmt::format(
      "E = {:.4g} Pa (10^+-{:.3f}), damping time {:.3g} s, release at {:.4f} s; RMSE {:.3g} mm over {} markers (static "
      "object: {:.3g} mm)",
      found.young, found.sigma_log10_young, found.parameters.damping_time, found.parameters.release, 1e3 * found.rms,
      found.markers.size(), 1e3 * found.rms_still));
  if (more)
    say(fmt::format("RMSE {:.3g} mm including {:.3g} s of held-out motion", 1e3 * seen.rms,
                    later.window - options.window));
  json names = json::array(), curve = json::array();
  for (const int k : found.markers) names.push_back(tracks.name[k]);
  for (const auto& c : found.search) curve.push_back({c.young, 1e3 * c.rms});
  json out = {{"source", "markers"},
              {"young_pa", found.young},
              {"log10_sigma", found.sigma_log10_young},
              {"damping_time_s", found.parameters.damping_time},
              {"log_damping_sigma", found.sigma_log_damping},
              {"release_s", found.parameters.release},
              {"release_sigma_s", found.sigma_release},
              {"search_end", found.search_end},
              {"rms_mm", 1e3 * found.rms},
              {"rms_still_mm", 1e3 * found.rms_still},
              {"rms_with_later_mm", more ? json(1e3 * seen.rms) : json()},
              {"window_s", options.window},
              {"markers", names},
              {"converged", found.converged},
              {"rollouts", found.rollouts},
              {"seconds", found.seconds},
              {"undetermined", undetermined_by_markers(found, options, m.interactions.empty(), material.given)}};
  json full = out;
  full["search_young_pa_rms_mm"] = curve;
  full["loss"] = found.loss;
  full["rms_axis_mm"] = {1e3 * found.rms_axis.x(), 1e3 * found.rms_axis.y(), 1e3 * found.rms_axis.z()};
  full["warnings"] = found.warnings;
  write_text(run / "fit/results.json", full.dump(2) + "\n");
  forget_progress(run);
  return out;
}

}  // namespace pliant

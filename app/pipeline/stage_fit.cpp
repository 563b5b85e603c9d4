#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/pipeline/fit_limits.h"
#include "app/pipeline/fit_report.h"
#include "app/pipeline/fit_video.h"
#include "app/store/fit_checkpoint.h"
#include "app/store/material.h"
#include "app/store/velocity.h"
#include "fitting/fit/fit_material.h"
#include "gaussians/base/error.h"
#include "gaussians/io/files.h"

namespace pliant {
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr double kOutlier = 3;    // px of a track's error beyond which it counts less and less
/// The fitted motion to the end of the video.
FittedMotion replay(const FitScene& fit, const VibrationFit& found, const Particles& particles, const SimulateOptions& base) {
  SimulateOptions options = base;
  options.fps = fit.video.fps * found.subframes, options.damping_time = found.damping_time, options.settle_time = 0;
  options.duration = found.rollout_frame(static_cast<int>(fit.video.frames.size()) - 1, fit.video.fps) / options.fps;
  FittedMotion motion;
  motion.first_frame = found.first_frame;
  int frame = 0;
  simulate<float>(options, particles, fit.pins, found.start, [&](const SimulationState& state) {
    const int wanted = found.rollout_frame(motion.first_frame + static_cast<int>(motion.frames.size()), fit.video.fps);
    if (frame++ == wanted) motion.frames.push_back(state);
    return true;
  });
  return motion;
}

VelocityFile velocity_of(const FitScene& fit, const VibrationFit& found) {
  VelocityFile out;
  out.position = fit.body.file.driving_position, out.velocity = found.start.v, out.F = found.start.F, out.C = found.start.C;
  for (size_t i = 0; i < found.start.size(); ++i) out.displacement.push_back(found.start.x[i] - fit.body.particles.position[i]);
  out.time = found.time, out.damping_time = found.damping_time, out.source = "fitted to the reference video";
  return out;
}

json curve_to_json(const ModalSearch& search) {
  json rows = json::array();
  for (size_t i = 0; i < search.log10_factor.size(); ++i) rows.push_back({search.log10_factor[i], search.unexplained[i]});
  return rows;
}

constexpr const char* kCheckpoint = "fit/checkpoint.h5";

/// What an interrupted fit of the same options and inputs left, and the hooks that keep what is done from now on.
MaterialFitProgress kept_progress(const Context& context, const fs::path& file, const std::string& provenance) {
  auto checkpoint = std::make_shared<FitCheckpoint>();
  if (fs::exists(file) && read_fit_checkpoint_provenance(file) == provenance) {
    *checkpoint = read_fit_checkpoint(file);
    context.progress.say(checkpoint->gradient.rows.empty() ? "fit: goes on from the best constant of an interrupted fit"
                                                           : fmt::format("fit: goes on after {} iterations of an interrupted fit", checkpoint->gradient.rows.size()));
  }
  checkpoint->provenance_json = provenance;
  MaterialFitProgress kept{checkpoint->homogeneous, checkpoint->gradient, {}, {}};
  kept.keep_homogeneous = [checkpoint, file](const VibrationFit& fit) {
    checkpoint->homogeneous = fit;
    write_fit_checkpoint(file, *checkpoint);
  };
  kept.keep_gradient = [checkpoint, file, &context](const GradientFitState& state) {
    checkpoint->gradient = state;
    const bool stop = context.interrupted && context.interrupted();
    if (stop || state.rows.size() % 5 == 0) write_fit_checkpoint(file, *checkpoint);
    return !stop;
  };
  return kept;
}

json steps_to_json(const std::vector<FitStep>& steps) {
  json rows = json::array();
  for (const FitStep& step : steps) rows.push_back({{"name", step.name}, {"rms_px", step.rms}, {"seconds", step.seconds}});
  return rows;
}

/// E of the material at the drivers.  That of the particles is lower or higher where parts thinner than the cells bend.
std::vector<double> fitted_young(const MaterialFit& fit, const Particles& before, double young_before) {
  std::vector<double> young;
  for (size_t i = 0; i < before.size(); ++i) young.push_back(young_before * fit.young[i] / before.young[i]);
  return young;
}

FitFindings findings_of(const MaterialFit& fit, const Particles& before, double young_before) {
  FitFindings out;
  const VibrationFit &constant = fit.homogeneous, &found = fit.found;
  out.young = young_before * std::pow(10.0, found.log10_factor);
  out.young_of_driver = fitted_young(fit, before, young_before), out.sigma_of_driver = fit.sigma;
  for (const double factor : constant.search.log10_factor) out.search_young.push_back(young_before * std::pow(10.0, factor));
  out.search_unexplained = constant.search.unexplained;
  for (const GradientFitRow& row : fit.iterations) out.loss_of_step.push_back(row.loss);
  if (!out.loss_of_step.empty()) return out;
  // Half the sum of squares, as pixels of the tracks.
  for (const double loss : found.summary.loss) out.loss_of_step.push_back(found.rms * std::sqrt(loss / std::max(found.summary.loss.back(), 1e-30)));
  out.loss_label = "points off by [px]";
  return out;
}

FitEvidence evidence_of(const FitScene& scene, const MaterialFit& fit, MaterialKind kind, double young) {
  const VibrationFit& found = fit.found;
  FitEvidence out;
  out.young = young, out.log10_sigma = found.log10_sigma, out.rms = found.rms, out.periods = fit.homogeneous.search.periods;
  out.damping_time = found.damping_time, out.damping_low = found.damping_time_low, out.damping_high = found.damping_time_high;
  const double seconds = (scene.used - fit.homogeneous.search.first_frame) / scene.video.fps;
  out.strongest_hz = seconds > 0 ? fit.homogeneous.search.periods / seconds : 0;
  for (size_t k = 0; k < fit.homogeneous.candidate_factor.size(); ++k) {
    out.rival_factor.push_back(std::pow(10.0, fit.homogeneous.candidate_factor[k] - fit.homogeneous.log10_factor));
    out.rival_rms.push_back(fit.homogeneous.candidate_rms[k] * found.rms / std::max(fit.homogeneous.rms, 1e-12));
  }
  out.one_stiffness = kind == MaterialKind::kUniform, out.errors_known = !fit.sigma.empty();
  double whole = 0, undecided = 0;
  for (size_t i = 0; i < fit.sigma.size(); ++i) {
    const double volume = scene.body.particles.volume[i];
    whole += volume, undecided += fit.determined(i) ? 0 : volume;
  }
  out.undecided_volume = whole > 0 ? undecided / whole : 0;
  return out;
}

}  // namespace

bool is_fitted(const RunDirectory& run) { return run.has("fit"); }

json run_fit(const Context& context, RunDirectory& run, const Scene& scene, const FitStage& stage) {
  if (!stage.markers.file.empty()) return run_marker_fit(context, run, scene, stage);
  if (stage.released_young) return run_released_fit(context, run, scene, stage);
  const std::string folder = object_folder(run);
  run.summary("seed", "run `pliant seed` first");
  const ObjectMaterial material = check_material(scene, stage.material, true);
  StageKey key{"fit",
               {{"material", material_to_json(material)}, {"from", stage.from}, {"until", stage.until}, {"points", stage.points}, {"field", stage.field}, {"parts", stage.field == "parts" ? stage.parts : 0}},
               {{"particles", run / (folder + "/particles.h5")}, {"object", run / (folder + "/object.ply")}, {"background", run / "background_repaired.ply"}},
               {folder + "/material.h5", folder + "/velocity.h5", "fit/results.json", "fit/side_by_side.mp4"}};
  add_video_to_key(key, scene, stage);

  const json summary = run.stage(context, key, [&]() -> json {
    const std::string provenance = run.provenance(context, key);
    fs::create_directories(run / "fit");
    const FitScene fit = load_fit_scene(context, run, scene, stage);
    const TrackLoss<float> tracks(follow_points(context, fit), fit.body.file.driving_position, scene.metres_per_unit, kOutlier);
    VibrationFitOptions options;
    options.simulate.gravity = -9.81 * scene.up;
    options.search.first = stage.from;
    options.refine.tolerance = 1e-3, options.modes.most = 6;
    options.most_modes = 4, options.most_periods = 3.5;
    const auto say = [&](const std::string& line) { context.progress.say("fit: " + line); };
    MaterialFitOptions material_options;
    material_options.vibration = options;
    if (stage.field == "parts") material_options.kind = MaterialKind::kParts, material_options.part = parts_of(fit, stage.parts);
    if (stage.field == "smooth") material_options.kind = MaterialKind::kSmooth;
    if (stage.field == "triplanes") material_options.kind = MaterialKind::kTriplanes;
    material_options.vibration.stop = context.interrupted;
    const MaterialFit found_material = fit_material(material_options, fit.body.particles, fit.pins, tracks, fit.video.fps, say,
                                                    kept_progress(context, run / kCheckpoint, provenance));
    const VibrationFit& found = found_material.found;
    const Particles& fitted = found_material.particles;
    // Factors of E of the particles hold for their samples too, whose E does not know of thin parts' equivalent stiffness.
    const std::string sources[] = {"homogeneous", "by parts", "a smooth field", "triplanes"};
    MaterialFile stored{fit.solid.young, fit.solid.poisson, fit.solid.density, sources[static_cast<int>(material_options.kind)] + ", fitted to the reference video", {}, {}};
    double log_young = 0;
    size_t moving = 0;
    for (size_t s = 0; s < stored.young.size(); ++s) {
      const int driver = fit.body.file.solid_driver[s];
      const double factor = driver >= 0 ? found_material.young[driver] / fit.body.particles.young[driver] : std::pow(10.0, found.log10_factor);
      stored.young[s] = static_cast<float>(stored.young[s] * factor);
      if (driver >= 0) log_young += std::log(stored.young[s]), ++moving;
      if (!found_material.sigma.empty())
        stored.log10_young_sigma.push_back(static_cast<float>(driver >= 0 ? found_material.sigma[driver] : found.log10_sigma));
    }
    const double young = std::exp(log_young / std::max<size_t>(1, moving));
    write_material(run / (folder + "/material.h5"), stored, provenance);
    write_velocity(run / (folder + "/velocity.h5"), velocity_of(fit, found), provenance);

    const VibrationFit& constant = found_material.homogeneous;
    const MotionScores constant_scores = compare_motion(fit, replay(fit, constant, constant.fitted(fit.body.particles), options.simulate), {});
    const FittedMotion motion = replay(fit, found, fitted, options.simulate);
    const MotionScores scores = compare_motion(fit, motion, run / "fit");
    write_fit_pictures(run / "fit", fit, findings_of(found_material, fit.body.particles, material.young));
    context.progress.say(fmt::format("fit: E = {:.4g} Pa{} (+-{:.1f} % by noise alone), damping time {:.3g} s; {:.1f} dB where it moves (held first frame {:.1f}, scene at rest against it {:.1f})",
                                     young, stage.field == "uniform" ? "" : " in the mean of its logarithm", 100 * (std::pow(10.0, found.log10_sigma) - 1), found.damping_time, scores.psnr_used, scores.still_used, scores.rest));
    if (scores.frames_later > 0)
      context.progress.say(fmt::format("fit: {:.1f} dB over the {} frames that it did not see (best constant E {:.1f}, held first frame {:.1f})",
                                       scores.psnr_later, scores.frames_later, constant_scores.psnr_later, scores.still_later));
    const json result = {{"young_pa", young}, {"log10_sigma", found.log10_sigma}, {"damping_time_s", found.damping_time},
                         {"damping_time_range_s", {found.damping_time_low, found.damping_time_high}}, {"first_frame", found.first_frame},
                         {"start_s", found.time}, {"periods", found.search.periods}, {"rms_px", found.rms}, {"rms_search_px", found.rms_search},
                         {"rms_still_px", found.rms_rest}, {"psnr_used", scores.psnr_used}, {"psnr_later", scores.psnr_later},
                         {"psnr_rest", scores.rest}, {"still_used", scores.still_used}, {"still_later", scores.still_later}, {"frames_later", scores.frames_later},
                         {"constant_used", constant_scores.psnr_used}, {"constant_later", constant_scores.psnr_later}, {"constant_young_pa", material.young * std::pow(10.0, constant.log10_factor)},
                         {"rms_homogeneous_px", found_material.homogeneous.rms}, {"steps", steps_to_json(found_material.steps)},
                         {"undetermined", undetermined_by_video(evidence_of(fit, found_material, material_options.kind, young), find_blindness(fit, motion), fit.video.fps)}};
    json full = result;
    full["search"] = curve_to_json(found_material.homogeneous.search), full["modes_hz"] = json::array();
    for (const double omega : found.modes.omega) full["modes_hz"].push_back(omega / 6.283185307179586);
    for (const GradientFitRow& row : found_material.iterations)
      full["iterations"].push_back({{"frames", row.frames}, {"loss", row.loss}, {"rollout_s", row.rollout_seconds}, {"frames_s", row.frames_seconds},
                                    {"reverse_s", row.reverse_seconds}, {"field_s", row.field_seconds}});
    write_text(run / "fit/results.json", full.dump(2) + "\n");
    fs::remove(run / kCheckpoint);
    return result;
  });
  write_fit_page(run);
  return summary;
}

}  // namespace pliant

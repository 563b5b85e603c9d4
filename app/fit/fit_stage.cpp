#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "app/fit/fit_options.h"
#include "app/fit/fit_outcome.h"
#include "app/fit/fit_progress.h"
#include "app/fit/fit_video.h"
#include "app/run/attach_scene.h"
#include "app/simulate/simulate_stage.h"
#include "fitting/fit/fit_physdreamer.h"
#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"

namespace pliant {
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

/// The fitted motion to the end of the video.
FittedMotion replay(const FitScene& fit, const VibrationFit& found, const Particles& particles,
                    const SimulateOptions& base) {
  SimulateOptions options = base;
  options.fps = fit.video.fps * found.subframes;
  options.damping_time = found.damping_time;
  options.settle_time = 0;
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

}  // namespace

json fit_to_video(const Context& context, const RunDirectory& run, const FitInputs& in, const std::string& provenance) {
  const FitStage& stage = in.options;
  const Scene& scene = in.scene;
  clear_fit_pictures(run);
  const FitScene fit = load_fit_scene(context, run, in);
  const TrackLoss<float> tracks(follow_points(context, fit), fit.body.file.driving_position, scene.metres_per_unit,
                                kTrackOutlier);
  const auto say = [&](const std::string& line) { context.progress.say("fit: " + line); };
  const MaterialFitProgress kept = kept_progress(context, run, with_video(run, stage, provenance));
  const MaterialFitOptions options =
      material_fit_options(context, run, scene, stage, fit, static_cast<int>(kept.gradient.rows.size()));
  const auto fit_by_recipe = stage.physdreamer() ? fit_physdreamer : fit_material;
  const MaterialFit found_material =
      fit_by_recipe(options, fit.body.particles, fit.pins, tracks, fit.video.fps, say, kept);
  const VibrationFit& found = found_material.found;
  const Particles& fitted = found_material.particles;
  MaterialFile stored = fitted_material(fit, fitted, std::pow(10.0, found.log10_factor),
                                        source_of(fit.start, found_material, options.kind));
  if (!found_material.sigma.empty())
    for (const int driver : fit.body.file.solid_driver)
      stored.log10_young_sigma.push_back(
          static_cast<float>(driver >= 0 ? found_material.sigma[driver] : found.log10_sigma));
  const double young = mean_young(fit.body.file, stored.young);
  write_material(run / in.outputs[0], stored, provenance);
  write_velocity(run / in.outputs[1], fitted_velocity(fit, found, found_material.losses), provenance);

  const VibrationFit& constant = found_material.homogeneous;
  const MotionScores constant_scores =
      compare_motion(fit, replay(fit, constant, constant.fitted(fit.body.particles), options.vibration.simulate),
                     found.last_frame, {});
  const FittedMotion motion = replay(fit, found, fitted, options.vibration.simulate);
  const MotionScores scores = compare_motion(fit, motion, found.last_frame, run / "fit");
  FitEvidence evidence = evidence_of(fit, found_material, options, young);
  evidence.scores = scores;
  for (const std::string& doubt : doubts_of(evidence)) context.progress.warn("fit: " + doubt);
  write_fit_pictures(run / "fit", fit, findings_of(fit, found_material));
  context.progress.say(fmt::format(
      "fit: E = {:.4g} Pa{} (+-{:.1f} % from noise alone), damping time {:.3g} s; PSNR {:.1f} dB in the moving "
      "region, fitted frames {} to {} (static first frame: {:.1f}; rest render against the first frame: {:.1f})",
      young, stage.field == "uniform" ? "" : " (geometric mean)", 100 * (std::pow(10.0, found.log10_sigma) - 1),
      found.damping_time, scores.fitted.psnr, scores.fitted.first, scores.fitted.last, scores.fitted.still,
      scores.rest));
  const auto tell_later = [&](const char* what, MotionScores::Span MotionScores::*span) {
    const MotionScores::Span& later = scores.*span;
    if (later.frames > 0)
      context.progress.say(
          fmt::format("fit: PSNR {:.1f} dB over {} {} frames (best uniform E {:.1f}, static first frame {:.1f})",
                      later.psnr, later.frames, what, (constant_scores.*span).psnr, later.still));
  };
  tell_later("further", &MotionScores::searched);
  tell_later("held-out", &MotionScores::later);
  json result = {{"young_pa", young},
                 {"log10_sigma", found.log10_sigma},
                 {"damping_time_s", found.damping_time},
                 {"damping_time_range_s", {found.damping_time_low, found.damping_time_high}},
                 {"first_frame", found.first_frame},
                 {"fps", fit.video.fps},
                 {"frames_used", fit.used},
                 {"start_s", fit.video.start + found.time},
                 {"periods", found.search.periods},
                 {"rms_px", found.rms},
                 {"rms_search_px", found.rms_search},
                 {"rms_still_px", found.rms_rest},
                 {"constant", scores_to_json(constant_scores)},
                 {"constant_young_pa", fit.start.young * std::pow(10.0, constant.log10_factor)},
                 {"rms_homogeneous_px", found_material.homogeneous.rms},
                 {"steps", steps_to_json(found_material.steps)},
                 {"undetermined", undetermined_by_video(evidence, find_blindness(fit, motion), fit.video.fps)}};
  result.update(scores_to_json(scores));
  if (found_material.losses.whole > 0) result["whole_damping_time_s"] = 1 / found_material.losses.whole;
  add_constants_beside(stage.compare.poisson, stage.compare.density, fit, stored, result);
  json full = result;
  full["search"] = curve_to_json(found_material.homogeneous.search);
  full["modes_hz"] = json::array();
  for (const double omega : found.modes.omega) full["modes_hz"].push_back(omega / 6.283185307179586);
  if (!found_material.iterations.empty()) full["iterations"] = iterations_to_json(found_material.iterations);
  write_text(run / "fit/results.json", full.dump(2) + "\n");
  forget_progress(run);
  return result;
}

}  // namespace pliant

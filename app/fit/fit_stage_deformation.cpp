#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/fit/fit_options.h"
#include "app/fit/fit_outcome.h"
#include "app/fit/fit_progress.h"
#include "app/fit/fit_video.h"
#include "app/run/attach_scene.h"
#include "app/store/trajectory.h"
#include "fitting/fields/hexplane_field.h"
#include "fitting/fields/weighted_field.h"
#include "fitting/fit/fit_deformation.h"
#include "gaussians/io/files/files.h"

namespace pliant {
using nlohmann::json;

namespace {

constexpr double kUnit = 0.1;  // of the body's size: a displacement that the network says as 1
constexpr const char* kSentence =
    "Nothing was simulated: the motion was fitted to this video alone, and says nothing of other forces or later "
    "times.";

/// Displacements in space and time that are nothing in the first frame and where the body is held.
WeightedField displacement_field(const Context& context, const FitScene& fit) {
  const Particles& body = fit.body.particles;
  std::vector<double> times;
  for (int f = 0; f < fit.used; ++f) times.push_back(double(f) / std::max(1, fit.used - 1));
  Box box;
  for (const Vec3f& x : body.position) box.add(x);
  HexplaneOptions planes;
  planes.seed = context.seed;
  planes.threads = std::max(1, context.threads);
  return {make_hexplane_field(planes, body.position, times),
          deformation_weight(free_particles(body, fit.pins), fit.used, kUnit * double(box.size().norm()))};
}

TrajectoryFile trajectory_of(const FitScene& fit, const std::vector<SimulationState>& frames, const Scene& scene) {
  TrajectoryFile out;
  out.fps = fit.video.fps;
  out.metres_per_unit = scene.metres_per_unit;
  out.cell_size = fit.body.particles.cell_size / scene.metres_per_unit;
  out.up = scene.up;
  for (const SimulationState& state : frames) {
    TrajectoryFile::Frame frame{state.time, 0, state.x, state.v, state.F};
    for (Vec3f& x : frame.position) x /= static_cast<float>(scene.metres_per_unit);
    out.frames.push_back(std::move(frame));
  }
  return out;
}

}  // namespace

json fit_without_physics(const Context& context, const RunDirectory& run, const FitInputs& in,
                         const std::string& provenance) {
  const FitStage& stage = in.options;
  clear_fit_pictures(run);
  const FitScene fit = load_fit_scene(context, run, in);
  const TrackLoss<float> tracks(follow_points(context, fit), fit.body.file.driving_position, in.scene.metres_per_unit,
                                kTrackOutlier);
  const MaterialFitProgress kept = kept_progress(context, run, with_video(run, stage, provenance));
  const ClipTerms terms = material_fit_options(context, run, in.scene, stage, fit, 0).clip;
  const ClipFrames frames{0, fit.used - 1, 0, 1, fit.video.fps};
  DeformationFitOptions options;
  options.iterations = *stage.compare.iterations;
  options.fps = fit.video.fps;
  const WeightedField field = displacement_field(context, fit);
  const DeformationFit found = fit_deformation(
      options, fit.body.particles, field, clip_objective(terms, &tracks, frames), kept.velocity,
      [&](const std::string& line) { context.progress.say("fit: " + line); }, kept.keep_velocity);

  // Frame 0 is the scene at rest; after the frames that were fitted, the last is held.
  FittedMotion motion{1, {found.frames.begin() + 1, found.frames.end()}};
  motion.frames.resize(fit.video.frames.size() - 1, found.frames.back());
  const MotionScores scores = compare_motion(fit, motion, fit.used - 1, run / "fit");
  FitFindings findings;
  findings.refinements = {{"displacements", "loss", {}}};
  for (const GradientFitRow& row : found.iterations) findings.refinements[0].value.push_back(row.loss);
  write_fit_pictures(run / "fit", fit, findings);
  write_trajectory(run / in.outputs[0], trajectory_of(fit, found.frames, in.scene), provenance);
  const double rms = tracks.on_rollout(0, fit.used - 1, 0, 1).rms(found.frames);
  context.progress.say(
      fmt::format("fit: a motion without physics; PSNR {:.1f} dB in the moving region, frames {} to {} (static first "
                  "frame: {:.1f})",
                  scores.fitted.psnr, scores.fitted.first, scores.fitted.last, scores.fitted.still));
  json result = {{"source", stage.recipe},
                 {"fps", fit.video.fps},
                 {"frames_used", fit.used},
                 {"rms_px", rms},
                 {"loss_first", found.iterations.front().loss},
                 {"loss_last", found.iterations.back().loss},
                 {"undetermined", {kSentence}}};
  result.update(scores_to_json(scores));
  json full = result;
  full["iterations"] = iterations_to_json(found.iterations);
  write_text(run / "fit/results.json", full.dump(2) + "\n");
  forget_progress(run);
  return result;
}

}  // namespace pliant

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "app/fit/fit_options.h"
#include "app/fit/fit_outcome.h"
#include "app/fit/fit_progress.h"
#include "app/fit/fit_video.h"
#include "app/run/attach_scene.h"
#include "app/simulate/simulate_stage.h"
#include "app/simulate/simulation_plan.h"
#include "fitting/fit/fit_distilled.h"
#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/images/video.h"

namespace pliant {
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr double kFps = 24;

/// The body at rest under what acts on it.
Motion<float> pushed_motion(const SimulationPlan& plan, const FitScene& fit) {
  Motion<float> motion{fit.body.particles, initial_state(fit.body.particles), plan.interactions, {}};
  motion.options.simulate = plan.options;
  motion.options.simulate.settle_time = 0;
  motion.options.simulate.sleep_speed = 0;
  motion.options.simulate.substeps =
      rollout<float>(motion.options, motion.particles, motion.interactions, motion.start).substeps;
  return motion;
}

RelaxingBranch branch_of(const Material& m, double factor) {
  return {static_cast<float>(factor * m.branch_shear), static_cast<float>(factor * m.branch_lambda),
          static_cast<float>(factor * m.branch_viscosity)};
}

/// The particles' own relaxing branches: that of the scene's law everywhere, else the usual one.
void add_branches(const Material& law, Particles& particles) {
  std::vector<RelaxingBranch> branch;
  for (size_t i = 0; i < particles.size(); ++i)
    branch.push_back(law.law == Law::kViscoelastic ? branch_of(particles.material(i), 1)
                                                   : usual_branch(particles.young[i], particles.poisson[i]));
  give_branches(branch, law, particles);
}

/// The branches of each solid sample, those of thin parts as they really are; those that are held get the mean.
std::vector<RelaxingBranch> sample_branches(const SimulatedBody& body, const Particles& particles) {
  std::vector<RelaxingBranch> of_driver;
  RelaxingBranch mean;
  const float share = 1 / static_cast<float>(particles.size());
  for (size_t d = 0; d < particles.size(); ++d) {
    const RelaxingBranch branch = branch_of(particles.material(d), 1 / thin_factors(body.drivers, d).stiffness);
    mean.shear += share * branch.shear;
    mean.lambda += share * branch.lambda;
    mean.viscosity += share * branch.viscosity;
    of_driver.push_back(branch);
  }
  std::vector<RelaxingBranch> out;
  for (const int d : body.file.solid_driver) out.push_back(d < 0 ? mean : of_driver[d]);
  return out;
}

void write_clip(const fs::path& file, const FitScene& fit, const Motion<float>& motion) {
  VideoWriter writer(file, motion.options.simulate.fps, fit.video.camera.width, fit.video.camera.height);
  for (const SimulationState& state :
       rollout<float>(motion.options, motion.particles, motion.interactions, motion.start).frames)
    writer.write(picture_of(*fit.drawn, fit.video.camera, state));
  writer.close();
}

}  // namespace

json fit_to_guide(const Context& context, const RunDirectory& run, const FitInputs& in, const std::string& provenance) {
  const FitStage& stage = in.options;
  const Scene& scene = in.scene;
  const CompareStage& compare = stage.compare;
  const double fps = stage.fps > 0 ? stage.fps : kFps;
  clear_fit_pictures(run);
  DistilledFitOptions recipe =
      stage.recipe == "physics3d" ? DistilledFitOptions::physics3d() : DistilledFitOptions::dreamphysics();
  recipe.iterations = *compare.iterations;
  recipe.network = stage.field == "kan";
  recipe.seed = network_seed(context);
  const int clips = stage.distilled() ? recipe.stages : 1;  // that an iteration asks about
  const int drawn = *compare.guide_frames * clips;
  FitScene fit = load_still_scene(context, in, unfilmed_camera(context, in.files.at("object"), scene, stage));
  if (stage.distilled() && recipe.branch) add_branches(fit.start.law, fit.body.particles);
  SimulateStage forces;
  forces.interactions = compare.load;
  forces.fps = fps;
  forces.duration = (drawn - 1) / fps;
  forces.settle = 0;
  forces.solver = stage.solver;
  const SimulationPlan plan = plan_simulation(context, in.files, in.found, scene, forces, fit.body, 0.0);
  write_text(run / "fit/interactions.json", plan.script.dump(2) + "\n");
  const Motion<float> motion = pushed_motion(plan, fit);

  const MaterialFitProgress kept = kept_progress(context, run, provenance);
  MaterialFitOptions options =
      material_fit_options(context, run, scene, stage, fit, clips * static_cast<int>(kept.gradient.rows.size()));
  options.clip.track_weight = 0;
  const auto say = [&](const std::string& line) { context.progress.say("fit: " + line); };
  const auto find = [&] {
    if (stage.distilled())
      return fit_distilled(recipe, motion, options.clip, fps, kept.gradient, say, kept.keep_gradient);
    ClipFitOptions varied = gradient_fields(options, motion.particles, motion.interactions);
    varied.velocity = nullptr;  // forces move it ...
    varied.keep_mass = false;   // ... which are known
    Motion<float> cut = motion;
    cut.options.gradient_window = *compare.window;
    return fit_clip(varied, cut, clip_objective(options.clip, nullptr, {0, drawn - 1, 0, 1, fps}), kept.gradient, say,
                    kept.keep_gradient);
  };
  const ClipFit found = find();

  const std::string guided = ", guided by '" + options.clip.guide->name() + "'";
  MaterialFile stored = fitted_material(
      fit, found.motion.particles, 1,
      (stage.distilled() ? stage.recipe + (recipe.network ? " with a KAN" : "") : stage.field) + guided);
  const double young = mean_young(fit.body.file, stored.young),
               damping_time = found.motion.options.simulate.damping_time;
  for (size_t s = 0; s < stored.young.size(); ++s)
    if (fit.body.file.solid_driver[s] < 0) stored.young[s] *= static_cast<float>(young / fit.start.young);
  if (stage.distilled() && recipe.branch) stored.branch = sample_branches(fit.body, found.motion.particles);
  write_material(run / in.outputs[0], stored, provenance);
  VibrationFit start;
  start.start = motion.start;
  start.damping_time = damping_time;
  VelocityFile velocity = fitted_velocity(fit, start, {});
  velocity.source = "at rest" + guided;
  write_velocity(run / in.outputs[1], velocity, provenance);

  write_clip(run / "fit/guided.mp4", fit, found.motion);
  FitFindings findings;
  findings.young = young;
  findings.refinements = {{"guided", "loss of the guidance program", {}}};
  for (size_t i = 0; i < found.motion.particles.size(); ++i)
    findings.young_of_driver.push_back(fit.start.driver_young[i] * found.motion.particles.young[i] /
                                       fit.body.particles.young[i]);
  for (const GradientFitRow& row : found.iterations) findings.refinements[0].value.push_back(row.loss);
  write_fit_pictures(run / "fit", fit, findings);
  context.progress.say(fmt::format("fit: E = {:.4g} Pa (before: {:.4g}), damping time {:.3g} s, after {} steps", young,
                                   fit.start.young, damping_time, found.iterations.size()));
  json result = {{"source", "guidance"},
                 {"guide", options.clip.guide->name()},
                 {"young_pa", young},
                 {"young_before_pa", fit.start.young},
                 {"damping_time_s", damping_time},
                 {"loss_first", found.iterations.front().loss},
                 {"loss_last", found.iterations.back().loss},
                 {"undetermined",
                  {"Nothing was measured: E and damping are those for which the guidance program prefers the rendered "
                   "motion under these forces."}}};
  add_constants_beside(compare.poisson, compare.density, fit, stored, result);
  json full = result;
  full["iterations"] = iterations_to_json(found.iterations);
  write_text(run / "fit/results.json", full.dump(2) + "\n");
  forget_progress(run);
  return result;
}

}  // namespace pliant

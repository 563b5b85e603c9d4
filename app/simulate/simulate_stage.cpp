#include "app/simulate/simulate_stage.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/simulate/assemble_trajectory.h"
#include "app/simulate/frame_store.h"
#include "app/simulate/given_fields.h"
#include "app/simulate/interactions_file.h"
#include "app/simulate/motion.h"
#include "app/simulate/simulated_body.h"
#include "app/simulate/simulation_plan.h"
#include "app/simulate/stiffness_sheet.h"
#include "app/store/material.h"
#include "app/store/trajectory.h"
#include "app/store/velocity.h"
#include "fitting/modal/dissipation.h"
#include "gaussians/base/error.h"
#include "gaussians/io/images/image_io.h"
#include "gaussians/io/splats/ply.h"
#include "physics/laws/law.h"
#include "physics/simulate/simulate.h"

namespace pliant {
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

json space_to_json(const SimulationSpace& space) {
  json rows = json::array();
  for (int i = 0; i < 3; ++i) rows.push_back({space.R(i, 0), space.R(i, 1), space.R(i, 2)});
  return {
      {"rotation", rows}, {"scale", space.scale}, {"offset", {space.offset.x(), space.offset.y(), space.offset.z()}}};
}

json rest_shape_to_json(const SimulateSummary& s) {
  return {{"iterations", s.rest_shape_iterations}, {"residual_m", s.rest_shape_residual}, {"sag_m", s.rest_shape_sag}};
}

/// The stage's options, with the damping that a fit found unless the user gave another.
SimulateStage with_fitted_damping(SimulateStage stage, const fs::path& file) {
  if (!stage.damping_time) stage.damping_time = read_velocity(file).damping_time;
  return stage;
}

/// Of a start that was found on another grid: the drag that lets it die away as fast on this one, over its first
/// second.
double damping_on_this_grid(const Context& context, const VelocityFile& start, const SimulatedBody& body,
                            const SimulationState& state, const SimulateOptions& options,
                            const std::vector<Interaction>& pins) {
  constexpr double kLongest = 1;  // s
  Motion<float> motion{body.particles, state, pins, {}};
  motion.options.simulate = options;
  motion.options.simulate.grid = is_lagrangian(options, body.particles) ? GridKind::kLagrangian : GridKind::kEulerian;
  motion.options.simulate.rest_shape = RestShapeMode::kCaptured;
  motion.options.simulate.gravity.setZero();
  motion.options.simulate.settle_time = motion.options.simulate.sleep_speed = 0;
  motion.options.simulate.duration = std::min(options.duration, kLongest);
  const double time = damping_time_beside_transfers(std::move(motion), start.whole_damping_time);
  if (time > 0)
    context.progress.say(
        fmt::format("simulate: total damping time {:.3g} s: {:.3g} s in addition to this grid's dissipation",
                    start.whole_damping_time, time));
  else
    context.progress.warn(fmt::format(
        "this grid alone dissipates more than a damping time of {:.3g} s allows: seed more particles for a finer grid",
        start.whole_damping_time));
  return time;
}

/// Momentum that each interaction gave to the body, in the order of interactions.json and what was added to it.
json impulses_to_json(const SimulateSummary& s) {
  std::vector<Vec3d> sum;
  for (const std::vector<Vec3d>& frame : s.impulse_of_frame) {
    sum.resize(frame.size(), Vec3d::Zero());
    for (size_t k = 0; k < frame.size(); ++k) sum[k] += frame[k];
  }
  json rows = json::array();
  for (const Vec3d& v : sum) rows.push_back({v.x(), v.y(), v.z()});
  return rows;
}

/// Relative to the run directory where it lies in there.
std::string recorded_path(const RunDirectory& run, const fs::path& file) {
  const fs::path relative = fs::absolute(file).lexically_relative(fs::absolute(run.path()));
  return relative.empty() || *relative.begin() == ".." ? fs::absolute(file).string() : relative.string();
}

json simulate_object(const Context& context, RunDirectory& run, const StageInputs<SimulateStage>& in,
                     const std::string& provenance) {
  const SimulateStage& stage = in.options;
  const Scene& scene = in.scene;
  const bool physgaussian = !stage.physgaussian.empty(), given = !stage.material_file.empty();
  const bool fields = in.files.count("material"), predicted = in.found.contains("predicted"),
             replay = in.found["replay"], timed = in.files.count("velocity");
  const ObjectMaterial material =
      fields ? check_material(scene, stage.material, predicted ? SetBy::kPrediction : SetBy::kFields)
             : check_material(scene, stage);
  ParticleFile particles = read_particles(in.files.at("particles"));
  ElasticSamples solid = fields ? given_material(in.files.at("material"), particles.solid_position, &context.progress)
                                : solid_material(particles, material);
  if (const std::string doubt = given ? unit_doubt(solid) : ""; !doubt.empty())
    context.progress.warn(stage.material_file + " " + doubt);
  // A law on the command line is not that of a fitted branch.
  if (!stage.material.law.empty() && material.material.law != Law::kViscoelastic) solid.branch.clear();
  if (predicted)
    context.progress.say("simulate: material as predicted for '" + in.found["predicted"].get<std::string>() + "'");
  else if (fields)
    context.progress.say("simulate: material " + (given ? "of " + stage.material_file : "and damping of the fit"));
  SimulatedBody body = make_body(std::move(particles), scene, solid, material.material);
  SimulationPlan plan = physgaussian
                            ? plan_physgaussian(context, in.files, stage, body)
                            : plan_simulation(context, in.files, in.found, scene,
                                              timed ? with_fitted_damping(stage, in.files.at("velocity")) : stage, body,
                                              replay ? std::nullopt : std::optional(kPushStart));

  const std::optional<ElasticSamples> boxes = physgaussian ? physgaussian_field(stage, body) : std::nullopt;
  if (boxes) solid = *boxes;

  const fs::path out = run / in.outputs[0];
  FrameStore frames(fs::path(out).replace_extension(".partial"), provenance);
  const SimulationState rest =
      replay ? given_start(in.files.at("velocity"), body.file, body.particles) : initial_state(body.particles);
  if (!stage.velocity_file.empty() && !stage.damping_time && !physgaussian)
    if (const VelocityFile v = read_velocity(in.files.at("velocity")); v.whole_damping_time > 0)
      plan.options.damping_time =
          damping_on_this_grid(context, v, body, rest, plan.options, pins_of(body.file.pinned_json, scene));
  const int total = static_cast<int>(std::lround(plan.options.fps * plan.options.duration));
  context.progress.begin("simulate", total);
  SimulateSummary s;
  const SimulationState start = frames.resume(rest, s);
  const FrameSink keep = [&](const SimulationState& state) {
    frames.add(state, s);
    context.progress.done(state.frame);
    return !context.interrupted();
  };
  const bool stopped = simulate(plan.options, body.particles, plan.interactions, start, keep, s).stopped;
  context.progress.end();
  if (stopped) throw Error(Failure::kInterrupted, "simulate", "", "interrupted", "run the same command to continue");
  for (const std::string& warning : s.warnings) context.progress.warn(warning);

  TrajectoryFile trajectory = assemble_trajectory(frames, total + 1, body, rest, s.rest_shape_iterations > 0);
  trajectory.object = group_name(in.found["name"]);
  trajectory.fps = plan.options.fps;
  trajectory.up = scene.up;
  // Together, so that a simulation that fails leaves the previous one whole.
  fs::path written;
  for (const std::string& output : in.outputs)
    if (output.ends_with("material.h5")) {
      written = run / output;
      const char* source = predicted ? "predicted" : boxes ? "configuration of PhysGaussian" : "homogeneous";
      write_material(written, {solid.young, solid.poisson, solid.density, source, {}, {}}, provenance);
    }
  if (fields)
    write_image(run / "stiffness.png",
                stiffness_sheet(read_ply(in.files.at("object")), scene.up, body.file.solid_position, solid.young,
                                "Young's modulus E of the object"));
  record_loads(context, run, plan.script);
  write_trajectory(out, trajectory, provenance);
  frames.remove();

  const double height = in.found["height"].get<double>() * scene.metres_per_unit;
  if (s.settle_displacement > 0.02 * height)
    context.progress.warn(
        fmt::format("{}: settling moved it by {:.0f} % of its height before the first frame "
                    "(--settle-time 0 starts from the captured position)",
                    flows(material.material.law) ? "the object's material flows" : "the object is not pinned",
                    100 * s.settle_displacement / height));
  const ObjectTip tip = physgaussian ? tip_of(body.file, {}, scene.up) : tip_of(body, scene);
  const json motion = describe_motion(trajectory, body.file, tip, in.found["height"].get<double>());
  context.progress.say(fmt::format("simulate: tip moves {:.1f} % of the object's height and ends at {:.1f} %",
                                   100 * motion["tip_peak"].get<double>(), 100 * motion["tip_end"].get<double>()));
  ObjectMaterial simulated = material;
  simulated.material.law = body.particles.materials[0].law;
  json session = {{"law", law_name(simulated.material.law)},
                  {"material", material_to_json(simulated)},
                  {"gravity_m_s2", {plan.options.gravity.x(), plan.options.gravity.y(), plan.options.gravity.z()}},
                  {"contact_friction", plan.options.object_friction},
                  {"solver", stage.solver},
                  {"flip_time_s", plan.options.flip_time},
                  {"sleep_speed_m_s", plan.options.sleep_speed},
                  {"duration_s", plan.options.duration},
                  {"obstacles", stage.obstacles},
                  {"physgaussian", physgaussian}};
  if (fields || boxes)
    session["material_file"] = recorded_path(run, fields ? in.files.at("material") : written);
  else
    session["uniform"] = {{"young", material.young}, {"poisson", material.poisson}, {"density", material.density}};
  return {{"frames", total},
          {"mass_kg", s.mass},
          {"cell_size_m", s.cell_size},
          {"dt_min_s", s.min_dt},
          {"dt_max_s", s.max_dt},
          {"substeps_max",
           s.substeps_of_frame.empty() ? 0 : *std::max_element(s.substeps_of_frame.begin(), s.substeps_of_frame.end())},
          {"max_stretch", s.max_stretch},
          {"strays", s.strays},
          {"retries", s.retries},
          {"solver", is_lagrangian(plan.options, body.particles) ? "lagrangian" : "eulerian"},
          {"gravity_cancelled", s.gravity_cancelled},
          {"settle_displacement_m", s.settle_displacement},
          {"rest_shape", rest_shape_to_json(s)},
          {"thin_share", s.thin_share},
          {"impulses_Ns", impulses_to_json(s)},
          {"push", plan.push},
          {"damping_time_s", plan.options.damping_time},
          {"motion", motion},
          {"floor", plan.floor},
          {"session", session},
          {"space", space_to_json(body.space)}};
}

}  // namespace

json run_simulate(const Context& context, RunDirectory& run, const Scene& scene, const SimulateStage& stage) {
  return run_stage(context, run, inputs_of(run, scene, stage), simulate_object);
}

}  // namespace pliant

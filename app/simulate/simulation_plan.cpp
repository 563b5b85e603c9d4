#include "app/simulate/simulation_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/import/interactions.h"
#include "app/import/physgaussian_config.h"
#include "app/simulate/clip_work.h"
#include "app/simulate/default_push.h"
#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/splats/ply.h"
#include "physics/body/scene_distance.h"
#include "physics/simulate/loads.h"

namespace pliant {
using nlohmann::json;

namespace {

/// Whether a ground is about the plane of the floor, or above it, from the start; both normals are of length 1.
bool replaces(const Interaction& ground, const Interaction& floor, double height) {
  constexpr double kAlike = 0.866, kDeeper = 0.05;  // cosine of 30 degrees; share of the object's height
  const Region &plane = ground.region, &below = floor.region;
  const double along = plane.vector.dot(below.vector);
  if (ground.type != InteractionType::kGround || ground.start > 0 || along < kAlike) return false;
  // Where it crosses the floor's normal.
  return (plane.point - below.point).dot(plane.vector) / along > -kDeeper * height;
}

}  // namespace

std::optional<Interaction> floor_of(const json& extract, const std::vector<Interaction>& interactions,
                                    const Scene& scene) {
  constexpr double kFriction = 0.5;
  if (!extract.contains("contact")) return std::nullopt;
  const json& contact = extract["contact"];
  const auto vector = [&](const char* key) {
    return Vec3d(contact[key][0].get<double>(), contact[key][1].get<double>(), contact[key][2].get<double>());
  };
  Interaction floor;
  floor.type = InteractionType::kGround;
  floor.friction = kFriction;
  floor.region = Region::half_space(vector("point"), vector("normal")).scaled(scene.metres_per_unit);
  const double height = extract.at("height").get<double>() * scene.metres_per_unit;
  const bool replaced = std::any_of(interactions.begin(), interactions.end(),
                                    [&](const Interaction& it) { return replaces(it, floor, height); });
  return replaced ? std::nullopt : std::optional(floor);
}

namespace {

/// Chooses which part of the background becomes an obstacle: that within half of the object's size, and as much around
/// it as kNodes nodes reach, kCoarser times as far apart as those of the least part.
void choose_part(const Box& object, const Box& background, SceneDistanceOptions& options) {
  constexpr float kMargin = 0.5f, kMostMargin = 100, kGrowth = 1.1f;  // of the object's size; of one margin to the next
  constexpr double kSteps = 64, kCoarser = 1.5, kNodes = 1 << 21;     // along the least part; of its spacing
  const float size = object.size().maxCoeff(), least = kMargin * size;
  const auto around = [&](float margin) {
    Box box;
    box.low = (object.low.array() - margin * size).max(background.low.array() - least).min(object.low.array() - least);
    box.high =
        (object.high.array() + margin * size).min(background.high.array() + least).max(object.high.array() + least);
    return box;
  };
  const auto nodes = [&](const Box& box, double spacing) {
    return (box.size().cast<double>().array() / spacing + 1).prod();
  };
  options.box = around(kMargin);
  options.spacing = options.box.size().maxCoeff() / kSteps;
  const double coarsest = kCoarser * options.spacing;
  for (float margin = kMargin; margin < kMostMargin && nodes(around(margin), coarsest) <= kNodes; margin *= kGrowth)
    options.box = around(margin);
  while (nodes(options.box, options.spacing) > kNodes) options.spacing *= kGrowth;
}

/// The rest of the scene around the object as an obstacle.
Interaction obstacle_of(const Context& context, const std::filesystem::path& file, const Scene& scene,
                        const Particles& particles) {
  constexpr double kFriction = 0.5;
  const float units = static_cast<float>(1 / scene.metres_per_unit);
  SceneDistanceOptions options;
  Box object;
  for (const Vec3f& x : particles.position) object.add(x * units);
  if (!scene.cameras_are_orbit)
    for (const Camera& camera : scene.cameras) options.viewpoints.push_back(camera.centre().cast<float>());
  const GaussianCloud background = read_ply(file);
  Box everything;
  for (const Vec3f& x : background.position) everything.add(x);
  choose_part(object, everything, options);
  std::vector<int> near;
  for (size_t i = 0; i < background.size(); ++i)
    if (options.box.contains(background.position[i])) near.push_back(static_cast<int>(i));
  const SceneDistanceResult distance = make_scene_distance(options, make_surfels({}, background.select(near)));
  if (distance.grid.value.empty())
    throw usage_error("--collide-scene", "", "finds no part of the scene near the object", "leave it out");
  context.progress.say(
      fmt::format("simulate: collisions with {} surface elements of the rest of the scene, friction {}",
                  distance.summary.surfels, kFriction));
  Interaction obstacle;
  obstacle.type = InteractionType::kCollider;
  obstacle.friction = kFriction;
  obstacle.distance = std::make_shared<SignedDistanceGrid>(scaled(distance.grid, scene.metres_per_unit));
  return obstacle;
}

void warn_of_work(const Context& context, const SimulateOptions& options, const Particles& particles) {
  if (const std::string sentence = describe_work(options, particles); !sentence.empty())
    context.progress.warn(sentence);
}

/// Whether one of the interactions is a pin that holds the body at the start.
bool is_held(const SimulationPlan& plan, const std::vector<Interaction>& pins, const Particles& particles) {
  std::vector<Interaction> all = pins;
  for (const Interaction& it : plan.interactions)
    if (it.type == InteractionType::kPin) all.push_back(it);
  return LoadSchedule<float>(plan.options, particles, all).pinned(0);
}

/// Damping by default, and whether a rest shape can be solved: both ask whether a pin holds the body at the start.
void set_by_hold(const Context& context, const SimulateStage& stage, bool held, SimulateOptions& options) {
  if (!held && stage.rest_shape == "solve")
    throw usage_error("--rest-shape", "solve", "does nothing: no pin holds the object at the start",
                      "leave it out, or pin the object");
  options.damping_time = stage.damping_time.value_or(held ? kDampingTime : 0);
  if (!held && !stage.damping_time)
    context.progress.say("simulate: no pin holds the object: its motion is not damped (see --damping-time)");
}

/// Whether something stops the fall of a body that no pin holds: a floor, or of the interactions what stands there at
/// the start.
bool is_stopped(const SimulationPlan& plan, const SimulateStage& stage, const json& extract, const Scene& scene) {
  if (stage.obstacles || (stage.floor && floor_of(extract, plan.interactions, scene))) return true;
  return std::any_of(plan.interactions.begin(), plan.interactions.end(), [](const Interaction& it) {
    return it.start <= 0 && (it.type == InteractionType::kGround || it.type == InteractionType::kCollider);
  });
}

/// Of what nothing stops: it would be gone before the first frame, and where nobody asks for it it does not fall.
void set_by_fall(const Context& context, const SimulateStage& stage, SimulationPlan& plan) {
  plan.options.settle_time = 0;  // also under a gravity that is zero for the first while only
  Vec3d gravity = plan.options.gravity;
  for (const Interaction& it : plan.interactions)
    if (it.type == InteractionType::kGravity && it.start <= 0) gravity = it.vector;
  if (gravity.isZero()) return;
  // A floor that is left out, and a script, are for what falls.
  const bool falls = !stage.interactions.empty() || !stage.floor;
  if (!falls) plan.options.gravity.setZero();
  context.progress.say(
      falls
          ? "simulate: nothing holds or stops the object: it falls from the captured position, without settling"
          : "simulate: nothing holds or stops the object: it stays where it is, without gravity (pin a part of it with "
            "`seed --pin-below`, or give a ground with --interactions)");
}

void add_floor(const Context& context, const json& extract, const Scene& scene, SimulationPlan& plan) {
  if (!floor_of(extract, {}, scene)) return;
  const std::string support = extract["contact"]["support"].get<std::string>();
  const auto floor = floor_of(extract, plan.interactions, scene);
  if (!floor) {
    context.progress.say("simulate: the ground of the interactions takes the place of the plane of '" + support + "'");
    return;
  }
  const bool beside = std::any_of(plan.interactions.begin(), plan.interactions.end(),
                                  [](const Interaction& it) { return it.type == InteractionType::kGround; });
  context.progress.say(fmt::format("simulate: the plane of '{}' is a floor, friction {}{}", support, floor->friction,
                                   beside ? ", beside the ground of the interactions (--no-floor leaves it out)" : ""));
  plan.floor = true;
  plan.interactions.push_back(*floor);
}

}  // namespace

SimulationPlan plan_simulation(const Context& context, const InputFiles& files, const json& extract, const Scene& scene,
                               const SimulateStage& stage, const SimulatedBody& body,
                               std::optional<double> push_start) {
  const bool moving = !push_start;
  SimulationPlan plan;
  plan.options.interrupted = context.interrupted;
  plan.options.fps = stage.fps;
  plan.options.duration = stage.duration;
  plan.options.rest_shape = stage.rest_shape == "solve" ? RestShapeMode::kSolve : RestShapeMode::kCaptured;
  if (moving && stage.settle != SimulateStage().settle)
    throw usage_error("--settle-time", fmt::format("{:g}", stage.settle),
                      "does nothing where the motion's start is given", "leave it out");
  plan.options.settle_time = moving ? 0 : stage.settle;
  plan.options.sleep_speed = stage.sleep_speed;
  plan.options.flip_time = stage.flip_time;
  plan.options.grid = grid_kind(stage.solver);
  plan.options.object_friction = stage.contact_friction;
  plan.options.gravity = stage.gravity ? Vec3d(-9.81 * scene.up) : Vec3d::Zero();
  if (stage.contact_friction != SimulateStage().contact_friction && !is_lagrangian(plan.options, body.particles))
    throw usage_error("--contact-friction", "", "does nothing on the Eulerian grid, where touching parts stick",
                      "leave it out, or use an elastic law and --solver lagrangian");
  const std::vector<Interaction> pins = pins_of(body.file.pinned_json, scene);
  const InteractionFrame frame{scene.metres_per_unit, scene.up};
  plan.script = json::array();
  if (!moving && !stage.interactions.empty()) {
    const std::string text = read_text(stage.interactions);
    plan.interactions = parse_interactions(text, frame, stage.interactions);
    plan.script = json::parse(text);
  }
  const bool held = is_held(plan, pins, body.particles);
  set_by_hold(context, stage, held, plan.options);
  if (!moving && !held && !is_stopped(plan, stage, extract, scene)) set_by_fall(context, stage, plan);
  warn_of_work(context, plan.options, body.particles);
  const bool pushed = !moving && stage.interactions.empty();
  if (pushed && stage.duration > *push_start) {
    plan.script = sized_push(context, plan.options, files.at("object"), extract, scene, stage, body, pins, *push_start,
                             plan.push);
    plan.interactions = parse_interactions(plan.script.dump(), frame, "interactions.json");
  } else if (pushed && stage.expects_push) {
    context.progress.say(
        "simulate: the clip ends before the push begins: nothing pushes the object; give a longer --duration");
  }
  plan.interactions.insert(plan.interactions.end(), pins.begin(), pins.end());
  if (stage.obstacles) plan.interactions.push_back(obstacle_of(context, files.at("background"), scene, body.particles));
  if (stage.floor && !stage.obstacles) add_floor(context, extract, scene, plan);
  return plan;
}

SimulationPlan plan_physgaussian(const Context& context, const InputFiles& files, const SimulateStage& stage,
                                 SimulatedBody& body) {
  const PhysGaussianConfig config = read_physgaussian_config(stage.physgaussian);
  const Compatibility compatibility =
      stage.physgaussian_bugs ? Compatibility::kPhysGaussian : Compatibility::kCorrected;
  const GaussianCloud object = read_ply(files.at("object"));
  const std::vector<uint8_t> members = physgaussian_members(config, object);
  const SimulationSpace space = simulation_space(config, object, members);

  // From metres of the scene into the configuration's space, whose unit stands for a metre.
  const double ratio = space.scale / body.space.scale;
  for (Vec3f& x : body.particles.position) x = space.from_scene(x.cast<double>() / body.space.scale).cast<float>();
  for (float& volume : body.particles.volume) volume *= static_cast<float>(ratio * ratio * ratio);
  body.particles.cell_size *= static_cast<float>(ratio);
  body.space = space;
  set_physgaussian_material(config, compatibility, body.particles);

  std::vector<Vec3d> gaussians;
  for (size_t i = 0; i < object.size(); ++i)
    if (members[i]) gaussians.push_back(space.from_scene(object.position[i].cast<double>()));
  const PhysGaussianWorld world = physgaussian_world(config, compatibility, body.particles, gaussians);
  for (const std::string& note : world.notes) context.progress.say("physgaussian: " + note);
  context.progress.say(fmt::format("physgaussian: cells of {:.4g} (configuration: {:.4g}), {} particles",
                                   body.particles.cell_size, config.cell_size(), body.particles.size()));
  SimulationPlan plan;
  plan.options = world.options;
  plan.options.interrupted = context.interrupted;
  plan.options.grid = GridKind::kEulerian;  // as in that program
  plan.interactions = world.interactions;
  warn_of_work(context, plan.options, body.particles);
  plan.script = {{"physgaussian", json::parse(read_text(stage.physgaussian))}, {"notes", world.notes}};
  return plan;
}

std::optional<ElasticSamples> physgaussian_field(const SimulateStage& stage, const SimulatedBody& body) {
  const PhysGaussianConfig config = read_physgaussian_config(stage.physgaussian);
  if (config.additional_material.empty()) return std::nullopt;
  Particles samples;
  for (const Vec3f& x : body.file.solid_position)
    samples.position.push_back(body.space.from_scene(x.cast<double>()).cast<float>());
  samples.volume.assign(samples.size(), 1);  // so that masses are densities
  for (auto* values : {&samples.mass, &samples.young, &samples.poisson}) values->resize(samples.size());
  set_physgaussian_material(config, Compatibility::kCorrected, samples);
  return ElasticSamples{std::move(samples.young), std::move(samples.poisson), std::move(samples.mass)};
}

}  // namespace pliant

#include "app/demo/reference.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "gaussians/base/error.h"
#include "physics/mpm/particles.h"
#include "physics/simulate/push.h"

namespace pliant {
namespace {

constexpr double kPushStart = 0.125, kPushDuration = 0.25;  // s
constexpr double kFraction = 0.16;                          // of the height that an interaction moves a body
constexpr double kPullTime = 0.5, kHoldTime = 0.75;         // s
constexpr double kGustStart = 0.125, kGustDuration = 1.0;   // s
constexpr double kGustRate = 0.5;                           // 1/s, drag of the air
const Vec3d kUp = Vec3d::UnitZ();

/// Samples of the moving solid down to three cells below the pinned plane, about `count` of them.
ObjectSolid flower_solid(const Flower& flower, int count, uint64_t seed) {
  const FlowerMechanics mechanics = flower_mechanics(flower);
  // Spacing and depth of the layer below the plane depend on each other only weakly.
  double spacing = std::cbrt(mechanics.volume / count);
  ObjectSolid solid;
  for (int i = 0; i < 2; ++i) {
    solid = sample_flower(flower, spacing, flower.pin_height - 6 * spacing, seed);
    if (i == 0) spacing = std::cbrt(solid.volume() / count);
  }
  return solid;
}

SimulateOptions simulate_options(const ReferenceOptions& options) {
  SimulateOptions out;
  out.fps = options.fps;
  out.duration = options.seconds;
  out.courant = options.courant;
  out.damping_time = options.damping_time;
  out.object_friction = options.contact_friction;
  return out;
}

std::vector<Interaction> pins_of(const Stage& stage) {
  std::vector<Interaction> pins;
  for (const Region& region : stage.pins()) {
    pins.emplace_back();
    pins.back().type = InteractionType::kPin;
    pins.back().region = region;
  }
  return pins;
}

/// A value with four digits, so that scripts read well.
double short_number(double x) {
  if (x == 0) return 0;
  const double unit = std::pow(10.0, std::floor(std::log10(std::abs(x))) - 3);
  return unit * std::round(x / unit);
}

}  // namespace

ReferenceBody reference_body(const Stage& stage, const ObjectSolid& solid) {
  ReferenceBody body;
  body.piece = solid.material;
  body.cell_size = 2 * solid.cell;
  body.samples.spacing = static_cast<float>(solid.cell);
  Particles& particles = body.particles;
  particles.cell_size = static_cast<float>(body.cell_size);
  const double volume = solid.cell * solid.cell * solid.cell;
  for (size_t i = 0; i < solid.position.size(); ++i) {
    const Vec3f x = (stage.world_from_object() * solid.position[i]).cast<float>();
    const ElasticSolid& material = stage.object().materials[solid.material[i]].solid;
    body.samples.position.push_back(x);
    body.samples.volume.push_back(static_cast<float>(volume));
    body.material.young.push_back(static_cast<float>(material.young));
    body.material.poisson.push_back(static_cast<float>(material.poisson));
    body.material.density.push_back(static_cast<float>(material.density));
    particles.mass.push_back(static_cast<float>(volume * material.density));
  }
  body.samples.thickness.assign(body.samples.position.size(), 0.0f);
  particles.position = body.samples.position;
  particles.volume = body.samples.volume;
  particles.young = body.material.young;
  particles.poisson = body.material.poisson;
  return body;
}

ReferenceBody reference_body(const Stage& stage, const ReferenceOptions& options) {
  return reference_body(stage, sample_object(stage.object(), options.particles, options.seed));
}

ReferenceBody flower_body(const Stage& stage, const Flower& flower, const ReferenceOptions& options) {
  return reference_body(stage, flower_solid(flower, options.particles, options.seed));
}

Region jolted_region(const Stage& stage, const ReferenceBody& body) {
  if (stage.object().jolted) return stage.in_world(*stage.object().jolted);
  const std::vector<Region> pins = stage.pins();
  Eigen::AlignedBox3d box;
  for (const Vec3f& position : body.particles.position) {
    const Vec3d x = position.cast<double>();
    if (std::none_of(pins.begin(), pins.end(), [&](const Region& pin) { return pin.contains(x); })) box.extend(x);
  }
  CHECK_MSG(!box.isEmpty(), "nothing of the object can move");
  return Region::box(box.min(), box.max());
}

ReferenceScript flower_script(const Stage& stage, const Flower& flower, const ReferenceOptions& options) {
  // A short push on a body that swings at frequency f moves it 2 sin(pi f T) times as far as the same force at rest.
  const FlowerMechanics mechanics = flower_mechanics(flower);
  Interaction push;
  push.type = InteractionType::kPointForce;
  push.start = kPushStart;
  push.duration = kPushDuration;
  push.region = Region::sphere(stage.tip(), stage.object().tip_radius);
  const double gain = 2 * std::sin(std::numbers::pi * mechanics.frequency * kPushDuration);
  push.vector = Vec3d(std::round(1e4 * options.travel / (mechanics.compliance * gain)) / 1e4, 0, 0);
  ReferenceScript script{"push", pins_of(stage)};
  script.interactions.push_back(push);
  return script;
}

std::vector<ReferenceScript> reference_scripts(const Stage& stage, const ReferenceBody& body,
                                               const ReferenceOptions& options) {
  const DemoObject& object = stage.object();
  const auto in_world = [&](const Vec3d& v) { return Vec3d(stage.world_from_object().linear() * v); };
  const std::vector<Interaction> pins = pins_of(stage);
  PushOptions sizing;
  sizing.simulate = simulate_options(options);
  sizing.height = object.height;
  sizing.fraction = kFraction;
  std::vector<ReferenceScript> scripts;
  const auto add = [&](const char* name, const Interaction& interaction) {
    scripts.push_back({name, pins});
    scripts.back().interactions.push_back(interaction);
  };
  const auto add_sized = [&](const char* name, Interaction interaction, const Vec3d& direction) {
    interaction.vector = in_world(direction);
    interaction.vector *= short_number(size_load(sizing, body.particles, pins, interaction).length);
    add(name, interaction);
  };

  Interaction poke;
  poke.type = InteractionType::kPointForce;
  poke.start = kPushStart;
  poke.duration = kPushDuration;
  poke.region = Region::sphere(stage.tip(), object.tip_radius);
  add_sized("poke", poke, object.push);

  // A hand takes hold of the tip, draws it aside, waits and lets go.
  Interaction pull;
  pull.type = InteractionType::kGrab;
  pull.region = poke.region;
  Vec3d centre = Vec3d::Zero();
  double mass = 0;
  for (size_t i = 0; i < body.particles.size(); ++i) {
    const Vec3d x = body.particles.position[i].cast<double>();
    if (!pull.region.contains(x)) continue;
    centre += body.particles.mass[i] * x;
    mass += body.particles.mass[i];
  }
  CHECK_MSG(mass > 0, "the tip of the object holds nothing");
  centre /= mass;
  const Vec3d drawn = centre + kFraction * object.height * in_world(object.pull);
  pull.path = {{0, centre}, {kPullTime, drawn}, {kHoldTime, drawn}};
  add("pull", pull);

  Interaction wind;
  wind.type = InteractionType::kGust;
  wind.start = kGustStart;
  wind.duration = kGustDuration;
  wind.rate = kGustRate;
  add_sized("wind", wind, (0.8 * object.push + 0.6 * object.push.cross(kUp)).normalized());

  // Of what moves alone: a pinned part would take the share of its mass, and the body has no more of it than its top.
  Interaction jolt;
  jolt.type = InteractionType::kImpulse;
  jolt.start = kPushStart;
  jolt.region = jolted_region(stage, body);
  add_sized("jolt", jolt, -object.push);
  return scripts;
}

ReferenceMotion without_frames(const ReferenceBody& body, const std::vector<Interaction>& interactions,
                               const ReferenceOptions& options) {
  ReferenceMotion motion;
  motion.samples = body.samples;
  motion.interactions = interactions;
  motion.fps = options.fps;
  motion.damping_time = options.damping_time;
  motion.cell_size = body.cell_size;
  motion.particles = body.particles.size();
  return motion;
}

ReferenceMotion simulate_reference(const ReferenceBody& body, const std::vector<Interaction>& interactions,
                                   const ReferenceOptions& options) {
  ReferenceMotion motion = without_frames(body, interactions, options);
  const size_t count = static_cast<size_t>(std::lround(options.seconds * options.fps));
  bool interrupted = false;
  const auto result = simulate<float>(simulate_options(options), body.particles, interactions,
                                      initial_state(body.particles), [&](const SimulationState& state) {
                                        motion.frames.push_back(state);
                                        interrupted = is_interrupted(options.interrupted);
                                        return motion.frames.size() < count && !interrupted;
                                      });
  stop_demo_if(interrupted);
  motion.time_step = result.summary.min_dt;
  motion.max_stretch = result.summary.max_stretch;
  return motion;
}

namespace {
template <class Points>
double farthest_from_first(const Points& points) {
  double farthest = 0;
  for (const auto& x : points) farthest = std::max(farthest, (x - points.front()).norm());
  return farthest;
}
}  // namespace

double ReferenceFilm::peak_pixels() const { return farthest_from_first(pixel); }
double ReferenceFilm::peak_metres() const { return farthest_from_first(tip); }

}  // namespace pliant

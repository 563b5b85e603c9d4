#include "app/demo/reference.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "physics/mpm/particles.h"

namespace pliant {
namespace {

constexpr double kPushStart = 0.125, kPushDuration = 0.25;  // s

/// Samples of the moving solid down to three cells below the pinned plane, about `count` of them.
FlowerSolid solid_for(const Flower& flower, int count, uint64_t seed) {
  const FlowerMechanics mechanics = flower_mechanics(flower);
  // Spacing and depth of the layer below the plane depend on each other only weakly.
  double spacing = std::cbrt(mechanics.volume / count);
  FlowerSolid solid;
  for (int i = 0; i < 2; ++i) {
    solid = sample_flower(flower, spacing, flower.pin_height - 6 * spacing, seed);
    if (i == 0) spacing = std::cbrt(solid.volume() / count);
  }
  return solid;
}

}  // namespace

ReferenceMotion simulate_reference(const Stage& stage, const ReferenceOptions& options) {
  const Flower& flower = stage.flower();
  const FlowerMechanics mechanics = flower_mechanics(flower);
  const FlowerSolid solid = solid_for(flower, options.particles, options.seed);
  ReferenceMotion motion;
  motion.cell_size = 2 * solid.cell;
  motion.samples.spacing = static_cast<float>(solid.cell);
  Particles particles;
  particles.cell_size = static_cast<float>(motion.cell_size);
  const double volume = solid.cell * solid.cell * solid.cell;
  for (size_t i = 0; i < solid.position.size(); ++i) {
    const Vec3f x = (stage.world_from_flower() * solid.position[i]).cast<float>();
    const ElasticSolid& material = flower.solid(solid.part[i]);
    motion.samples.position.push_back(x);
    motion.samples.volume.push_back(static_cast<float>(volume));
    motion.material.young.push_back(static_cast<float>(material.young));
    motion.material.poisson.push_back(static_cast<float>(material.poisson));
    motion.material.density.push_back(static_cast<float>(material.density));
    particles.mass.push_back(static_cast<float>(volume * material.density));
  }
  motion.samples.thickness.assign(motion.samples.position.size(), 0.0f);
  particles.position = motion.samples.position;
  particles.volume = motion.samples.volume;
  particles.young = motion.material.young;
  particles.poisson = motion.material.poisson;

  // A short push on a body that swings at frequency f moves it 2 sin(pi f T) times as far as the same force at rest.
  const auto [low, high] = stage.pinned_box();
  Interaction pin, push;
  pin.type = InteractionType::kPin;
  pin.region = Region::box(low, high);
  push.type = InteractionType::kPointForce;
  push.start = kPushStart;
  push.duration = kPushDuration;
  push.region = Region::sphere(stage.world_from_flower() * flower.blossom_centre, 1.2 * flower.tip_diameter);
  const double gain = 2 * std::sin(std::numbers::pi * mechanics.frequency * kPushDuration);
  push.vector = Vec3d(std::round(1e4 * options.travel / (mechanics.compliance * gain)) / 1e4, 0, 0);
  motion.interactions = {pin, push};

  motion.options.fps = options.fps;
  motion.options.duration = options.seconds;
  motion.options.courant = options.courant;
  motion.options.damping_time = options.damping_time;
  const size_t count = static_cast<size_t>(std::lround(options.seconds * options.fps));
  const auto result = simulate<float>(motion.options, particles, motion.interactions, initial_state(particles),
                                      [&](const SimulationState& state) {
                                        motion.frames.push_back(state);
                                        return motion.frames.size() < count;
                                      });
  motion.summary = result.summary;
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

#pragma once

// A small pinned block that moves, drawn by Gaussians in its inside in front of a wall.

#include "fitting/objective/motion.h"
#include "fitting/objective/picture_loss.h"
#include "fitting/objective/track_loss.h"
#include "gaussians/base/random.h"
#include "gaussians/render/bind.h"
#include "tests/gaussians/cloud_cast.h"
#include "tests/physics/shapes.h"

namespace pliant::fixture {

template <class T>
Motion<T> swinging_block(int frames, double young = 2e4, double speed = 0.4) {
  Motion<T> m;
  const double dx = 0.01;
  m.particles = block<T>(Vec3d(2, 2, 4) * dx, dx, 0.7, young, 0.3, 1000);
  m.start = initial_state(m.particles);
  for (size_t i = 0; i < m.particles.size(); ++i) m.start.v[i].x() = T(speed * m.particles.position[i].z() / 0.04);
  Interaction pin;
  pin.type = InteractionType::kPin;
  pin.region = Region::half_space(Vec3d(0, 0, 0.008), Vec3d(0, 0, 1));
  m.interactions = {pin};
  m.options.simulate.fps = 100;
  m.options.simulate.duration = frames / 100.0;
  m.options.simulate.damping_time = 0.3;
  m.options.simulate.substeps = 24;
  return m;
}

/// Twelve centimetres before the block; pictures with cut-offs want scene units of 0.1 m or less.
inline Camera block_camera(int width, int height, double metres_per_unit = 1) {
  Camera camera = look_at({0.01, -0.12, 0.025}, {0.01, 0.01, 0.02}, {0, 0, 1}, width, height, 1.9 * width);
  camera.cam_from_world.translation() /= metres_per_unit;
  return camera;
}

/// `count` coloured Gaussians in the block, scene units of 0.1 m if so told, and nine of a wall behind it.
template <class T>
std::shared_ptr<DrawnObject<T>> drawn_block(const BasicParticles<T>& particles, int count, double metres_per_unit = 1) {
  auto drawn = std::make_shared<DrawnObject<T>>();
  drawn->metres_per_unit = metres_per_unit;
  GaussianCloud object, wall;
  object.sh_degree = wall.sh_degree = 1;
  object.resize(count);
  wall.resize(9);
  const auto paint = [&](GaussianCloud& cloud, size_t g, Vec3d x, double size, uint64_t seed) {
    Random random(seed, g);
    cloud.position[g] = (x / metres_per_unit).cast<float>();
    for (int k = 0; k < 3; ++k)
      cloud.log_scale[g][k] = static_cast<float>(std::log(size / metres_per_unit) + 0.3 * random.normal());
    for (int k = 0; k < 4; ++k) cloud.rotation[g][k] = static_cast<float>(random.normal());
    cloud.opacity_logit[g] = static_cast<float>(random.uniform(0, 2));
    for (int k = 0; k < 12; ++k) cloud.sh_of(g)[k] = static_cast<float>((k < 3 ? 0.8 : 0.1) * random.normal());
  };
  for (int g = 0; g < count; ++g) {
    Random random(5, g);
    paint(object, g, {random.uniform(0, 0.02), random.uniform(0, 0.02), random.uniform(0.005, 0.04)}, 0.003, 6);
  }
  for (int g = 0; g < 9; ++g) paint(wall, g, {0.01 + 0.02 * (g % 3 - 1), 0.06, 0.02 + 0.02 * (g / 3 - 1)}, 0.01, 7);
  std::vector<Vec3f> drivers;
  for (const Vec3<T>& x : particles.position) drivers.push_back((x / T(metres_per_unit)).template cast<float>());
  drawn->binding = pliant::bind({}, object.position, drivers);
  for (const Vec3f& x : drivers) drawn->drivers.push_back(x.cast<T>());
  drawn->object = cloud_cast<T>(object);
  drawn->background = cloud_cast<T>(wall);
  return drawn;
}

/// What a camera sees of a motion.
template <class T, bool kCutOffs>
SeenFrames<T> film(const Motion<T>& motion, const DrawnObject<T>& drawn, const Camera& camera) {
  SeenFrames<T> seen;
  seen.camera = camera;
  for (const auto& state : rollout<T>(motion.options, motion.particles, motion.interactions, motion.start).frames)
    seen.frames.push_back(render_as<T, kCutOffs>(drawn.at(state), camera, drawn.render).color);
  return seen;
}

}  // namespace pliant::fixture

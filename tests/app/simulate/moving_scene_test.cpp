// What hangs on nothing is carried by what is simulated, at any distance and with any number of drivers.

#include "app/simulate/moving_scene.h"

#include <gtest/gtest.h>

#include "app/simulate/driver_level.h"

namespace pliant {
namespace {

constexpr float kStep = 0.02f, kCell = 2 * kStep;

/// A post of 3 x 3 samples in 30 layers, each with a driver, and a cube of 27 samples `gap` above it that follows the
/// middle of its top; a Gaussian at every sample.
struct Post {
  ParticleFile particles;
  GaussianCloud object;
  size_t posts = 0;

  explicit Post(float gap) {
    for (int layer = 0; layer < 30; ++layer) add_layer(kStep * static_cast<float>(layer));
    posts = particles.solid_position.size();
    particles.driving_position = particles.solid_position;
    particles.driving_volume = particles.solid_volume;
    const float top = particles.solid_position.back().z();
    for (int layer = 0; layer < 3; ++layer) add_layer(top + gap + kStep * static_cast<float>(layer));
    const int middle = static_cast<int>(posts) - 5;
    for (size_t s = 0; s < particles.solid_position.size(); ++s) {
      particles.solid_driver.push_back(s < posts ? static_cast<int>(s) : -1);
      particles.solid_follows.push_back(s < posts ? -1 : middle);
    }
    particles.cell_size = kCell;
    object.sh_degree = 0;
    object.resize(particles.solid_position.size());
    for (size_t i = 0; i < object.size(); ++i) {
      object.position[i] = particles.solid_position[i];
      object.log_scale[i] = Vec3f::Constant(-5);
      object.rotation[i] = Vec4f(1, 0, 0, 0);
    }
  }

 private:
  void add_layer(float z) {
    for (int x = -1; x <= 1; ++x)
      for (int y = -1; y <= 1; ++y) {
        particles.solid_position.push_back(Vec3f(kStep * static_cast<float>(x), kStep * static_cast<float>(y), z));
        particles.solid_volume.push_back(kStep * kStep * kStep);
      }
  }
};

const Mat3f kTurn = Eigen::AngleAxisf(0.5f, Vec3f::UnitY()).toRotationMatrix();

/// The upper half of the post turns.
TrajectoryFile::Frame turned(const std::vector<Vec3f>& drivers) {
  const Vec3f joint(0, 0, 0.29f);
  TrajectoryFile::Frame frame;
  for (const Vec3f& x : drivers) {
    const bool turns = x.z() > joint.z();
    frame.position.push_back(turns ? Vec3f(kTurn * (x - joint) + joint) : x);
    frame.F.push_back(turns ? kTurn : Mat3f::Identity());
  }
  return frame;
}

TEST(MovingScene, DisconnectedPiecesMoveAsOneWithTheNearestSimulatedPart) {
  const Scene scene;
  for (const float cells : {5.0f, 40.0f}) {
    const Post post(cells * kCell);
    MovingScene moving;
    moving.object = post.object;
    moving.particles = post.particles;
    moving.binding = bind_object(scene, post.particles, post.object);
    EXPECT_EQ(moving.moving(), post.object.size());
    const TrajectoryFile::Frame frame = turned(post.particles.driving_position);
    const GaussianCloud now = moving.object_at(frame);
    const size_t tip = post.posts - 5;
    for (size_t i = post.posts; i < now.size(); ++i) {
      const Vec3f from_tip = post.object.position[i] - post.object.position[tip];
      EXPECT_LT((now.position[i] - now.position[tip] - kTurn * from_tip).norm(), 1e-3f * from_tip.norm()) << cells;
    }

    // No driver of a coarser level lies in the piece, which follows those of the post there too.
    moving.trajectory.frames = {frame};
    const ParticleFile level = with_drivers(post.particles, scene, 90);
    ASSERT_LT(level.driving_position.size(), post.posts);
    for (const Vec3f& x : level.driving_position) EXPECT_LT(x.z(), 0.6f);
    const DriverFrame coarse = motion_of(moving, level)[0];
    MovingScene few = moving;
    few.particles = level;
    few.binding = bind_object(scene, level, post.object);
    TrajectoryFile::Frame coarse_frame;
    coarse_frame.position = coarse.position;
    coarse_frame.F = coarse.F;
    const GaussianCloud there = few.object_at(coarse_frame);
    for (size_t i = post.posts; i < now.size(); ++i)
      EXPECT_LT((there.position[i] - now.position[i]).norm(),
                0.1f * (now.position[i] - post.object.position[i]).norm());
  }
}

TEST(MovingScene, HazeFarFromEverySampleStaysWhereItIs) {
  Post post(5 * kCell);
  const size_t last = post.object.size() - 1;
  post.object.position[last] += Vec3f(0, 0, 5 * kCell);
  const Binding binding = bind_object({}, post.particles, post.object);
  EXPECT_EQ(binding.driver[last * Binding::kCount], -1);
  EXPECT_GE(binding.driver[(last - 1) * Binding::kCount], 0);
}

}  // namespace
}  // namespace pliant

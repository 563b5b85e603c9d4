// Parts that nearly touch at rest and do not hang together: none takes the other along.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "app/run/attach_scene.h"
#include "app/simulate/driver_level.h"
#include "app/simulate/moving_scene.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/splats/ply.h"
#include "tests/app/page/two_sheets.h"
#include "tests/app/run_pliant.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

constexpr float kHeight = 1, kGap = 0.08f, kMiddle = kHeight + 0.5f * kGap;

/// Two leaves of 2.4 x .03 along x, one above the other, out of a block that is held.
void make_leaves_scene(const fs::path& folder) {
  GaussianCloud cloud;
  cloud.sh_degree = 0;
  const auto add = [&](const Vec3f& x, const Vec3f& size) {
    const size_t i = cloud.size();
    cloud.resize(i + 1);
    cloud.position[i] = x;
    cloud.log_scale[i] = size.array().log();
    cloud.rotation[i] = Vec4f(1, 0, 0, 0);
    cloud.opacity_logit[i] = 4;
  };
  for (int leaf = 0; leaf < 2; ++leaf)
    for (int i = 0; i < 240; ++i)
      for (int j = 0; j < 2; ++j)
        add(Vec3f(0.005f + 0.01f * i, -0.005f + 0.01f * j, kHeight + kGap * leaf), Vec3f(0.005f, 0.005f, 0.0005f));
  for (int i = 0; i < 15; ++i)
    for (int j = 0; j < 15; ++j)
      for (int k = 0; k < 15; ++k)
        if (i % 14 == 0 || j % 14 == 0 || k % 14 == 0)
          add(Vec3f(-0.29f + 0.02f * i, -0.14f + 0.02f * j, 0.86f + 0.02f * k), Vec3f::Constant(0.014f));
  fs::create_directories(folder);
  write_ply(folder / "splats.ply", cloud);
  write_text(folder / "scene.json", R"({"splats": "splats.ply", "up": [0, 0, 1], "metres_per_unit": 1,
    "pinned": [{"box": [-0.4, -0.2, 0.8, -0.02, 0.2, 1.2]}],
    "material": {"young": 1e6, "poisson": 0.3, "density": 500}})");
}

/// Largest distances [2] from rest of what lies below and above the gap, beyond half of the leaves' length.
std::array<double, 2> largest(const std::vector<Vec3f>& rest, const std::vector<Vec3f>& now) {
  std::array<double, 2> most = {0, 0};
  for (size_t i = 0; i < rest.size(); ++i) {
    double& side = most[rest[i].z() > kMiddle];
    if (rest[i].x() > 1.5f) side = std::max<double>(side, (now[i] - rest[i]).norm());
  }
  return most;
}

TEST(Leaves, ThatNearlyTouchAreNotPulledAlong) {
  const TemporaryFolder folder;
  make_leaves_scene(folder / "scene");
  const std::string out = (folder / "run").string();
  write_text(folder / "pull.json", R"([{"type": "grab", "region": {"box": [2.2, -0.1, 1.03, 2.5, 0.1, 1.1]},
    "start": 0, "duration": 0.5, "path": [[0, 2.3, 0, 1.08], [0.5, 2.3, 0, 1.48]]}])");
  ASSERT_EQ(run_quietly({"segment", (folder / "scene").string(), "--out", out, "--aabb", "-0.5,-0.2,0.8,2.5,0.2,1.3"}),
            0);
  ASSERT_EQ(run_quietly({"extract", out, "--object", "object"}), 0);
  ASSERT_EQ(run_quietly({"seed", out, "--particles", "400", "--no-pin-contact"}), 0);
  ASSERT_EQ(run_quietly({"simulate", out, "--interactions", (folder / "pull.json").string(), "--duration", "0.5",
                         "--fps", "20"}),
            0);
  const RunDirectory run = RunDirectory::open(out);
  const Scene scene = load_run_scene(run);
  const MovingScene moving = load_moving_scene(moving_scene_files(run), scene);
  ASSERT_LT(kGap, moving.particles.cell_size) << "the leaves share cells";
  const std::array<double, 2> most =
      largest(moving.object.position, moving.object_at(moving.trajectory.frames.back()).position);
  EXPECT_GT(most[1], 0.3);
  EXPECT_LT(most[0], 0.05 * most[1]);

  // No driver of a coarser level lies in both, nor do links lead from one to the other away from the block.
  const ParticleFile level = with_drivers(moving.particles, scene, 300);
  ASSERT_LT(level.driving_position.size(), moving.particles.driving_position.size());
  std::vector<int> side(level.driving_position.size(), 0);  // bit 0: below, bit 1: above
  for (size_t s = 0; s < level.solid_position.size(); ++s)
    if (level.solid_driver[s] >= 0 && level.solid_position[s].x() > 0.5f)
      side[level.solid_driver[s]] |= level.solid_position[s].z() > kMiddle ? 2 : 1;
  for (const int both : side) EXPECT_NE(both, 3);
  for (const auto& [a, b] : level.driving_links) EXPECT_NE(side[a] | side[b], 3) << a << ", " << b;

  // Nor is the lower leaf taken along where the motion is that of the coarser level.
  const std::array<double, 2> carried = largest(level.driving_position, motion_of(moving, level).back().position);
  EXPECT_GT(carried[1], 0.3);
  EXPECT_LT(carried[0], 0.05 * carried[1]);
}

// Two sheets of one layer of samples, one sample apart: the upper one moves, stretched, and the lower one stays.
TEST(Leaves, OfACoarserLevelAreCarriedByTheirOwnDriversAlone) {
  constexpr float kLift = 0.3f;
  MovingScene moving;
  moving.particles = two_sheets();
  const std::vector<Vec3f>& rest = moving.particles.driving_position;
  const Mat3f stretch = Vec3f(1.5f, 1, 1).asDiagonal();
  TrajectoryFile::Frame frame;
  TrajectoryFile::Memory memory;
  for (size_t i = 0; const int sheet : sheets_of_drivers(moving.particles)) {
    const bool upper = sheet == 2;
    frame.position.push_back(rest[i++] + Vec3f(0, 0, upper ? kLift : 0));
    frame.F.push_back(upper ? stretch : Mat3f::Identity());
    memory.F.push_back(frame.F.back());
    memory.F_viscous.push_back(frame.F.back());
    memory.history.push_back(upper ? 1.0f : 0.0f);
  }
  moving.trajectory.frames = {frame};
  moving.trajectory.memory = memory;

  const ParticleFile level = with_drivers(moving.particles, Scene(), 60);
  ASSERT_LT(level.driving_position.size(), rest.size());
  const DriverFrame carried = motion_of(moving, level)[0];
  const TrajectoryFile::Memory remembered = *memory_of(moving, level);
  const std::vector<int> sheet = sheets_of_drivers(level);
  for (size_t i = 0; i < sheet.size(); ++i) {
    ASSERT_NE(sheet[i], 3) << i;
    const bool upper = sheet[i] == 2;
    const Mat3f F = upper ? stretch : Mat3f::Identity();
    EXPECT_LT((carried.position[i] - level.driving_position[i] - Vec3f(0, 0, upper ? kLift : 0)).norm(), 1e-5f) << i;
    EXPECT_LT((carried.F[i] - F).norm(), 1e-5f) << i;
    EXPECT_LT((remembered.F[i] - F).norm(), 1e-5f) << i;
    EXPECT_LT((remembered.F_viscous[i] - F).norm(), 1e-5f) << i;
    EXPECT_NEAR(remembered.history[i], upper ? 1 : 0, 1e-5f) << i;
  }
}

}  // namespace
}  // namespace pliant

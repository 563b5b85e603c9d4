// The numbers of an object's size: the volume is that of the solid that is written, and no height is zero.

#include "app/seed/fill_stage.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "app/run/run_directory.h"
#include "gaussians/base/random.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/splats/ply.h"
#include "tests/app/run_pliant.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

namespace fs = std::filesystem;

constexpr float kThickness = 0.004f;  // standard deviation of the Gaussians

/// Gaussians of one size at one height along x from 0 to .6, none of them in a gap in the middle.
void make_level_rod(const fs::path& folder, float gap) {
  GaussianCloud cloud;
  cloud.resize(1000);
  for (size_t i = 0; i < cloud.size(); ++i) {
    const float x = static_cast<float>(Random(1, i).uniform(0, 0.6 - gap));
    cloud.position[i] = Vec3f(x > 0.3f ? x + gap : x, 0, 0);
    cloud.log_scale[i].setConstant(std::log(kThickness));
    cloud.rotation[i] = Vec4f(1, 0, 0, 0);
    cloud.opacity_logit[i] = 4;
  }
  fs::create_directories(folder);
  write_ply(folder / "splats.ply", cloud);
  write_text(folder / "scene.json", R"({"splats": "splats.ply", "up": [0, 0, 1], "metres_per_unit": 1})");
}

}  // namespace

TEST(FillStage, OfALevelRodWithAGapHasTheVolumeOfItsSamplesAndAHeight) {
  const TemporaryFolder folder;
  const std::string out = (folder / "run").string();
  make_level_rod(folder / "scene", 0.026f);
  ASSERT_EQ(run_quietly({"segment", (folder / "scene").string(), "--out", out, "--aabb", "-1,-1,-1,1,1,1"}), 0);
  ASSERT_EQ(run_quietly({"extract", out, "--object", "object"}), 0);
  ASSERT_EQ(run_quietly({"seed", out, "--particles", "400"}), 0);
  const RunDirectory run = RunDirectory::open(out);
  const nlohmann::json extracted = run.summary("extract", ""), seeded = run.summary("seed", "");
  // Its Gaussians' centres have none.
  EXPECT_NEAR(extracted["height"].get<double>(), 4 * kThickness, 1e-6);
  const SolidFile solid = read_solid(run / (extracted["folder"].get<std::string>() + "/solid.h5"));
  const double volume = solid.samples.total_volume();
  EXPECT_NEAR(solid.volume, volume, 1e-9 * volume);
  EXPECT_NEAR(seeded["volume"].get<double>(), volume, 1e-9 * volume);
  EXPECT_LE(seeded["simulated_volume"].get<double>(), volume * (1 + 1e-6));
  EXPECT_EQ(seeded["pieces"].size(), 1u);
}

}  // namespace pliant

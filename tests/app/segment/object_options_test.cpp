// What single options of extract, repair and seed change in the result, on small made scenes.

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>

#include "app/run/attach_scene.h"
#include "app/segment/extract_stage.h"
#include "app/segment/repair_stage.h"
#include "app/store/material.h"
#include "app/store/particles.h"
#include "gaussians/io/cameras/cameras.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/images/image_io.h"
#include "gaussians/io/splats/ply.h"
#include "tests/app/run_pliant.h"
#include "tests/segmentation/repair/contact_shadow.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// A folder with a scene; `object` is the one that its scene file names, `ids` are those of the masks, empty = all.
void write_made_scene(const fs::path& folder, const MadeScene& scene, const std::string& object = "",
                      const std::set<uint32_t>& ids = {}) {
  fs::create_directories(folder / "masks");
  write_ply(folder / "splats.ply", scene.cloud);
  write_cameras(folder / "transforms.json", scene.cameras);
  for (const Camera& camera : scene.cameras) {
    IdImage mask = cast_ids(scene, camera);
    for (uint32_t& id : mask.data)
      if (!ids.empty() && !ids.count(id)) id = 0;
    write_ids(folder / "masks" / (camera.name + ".png"), mask);
  }
  json settings = {{"splats", "splats.ply"}, {"cameras", "transforms.json"}, {"masks", "masks"}, {"up", {0, 0, 1}}};
  if (!object.empty()) settings["object"] = object;
  write_text(folder / "scene.json", settings.dump());
}

/// A run directory in which object 300 of the scene has been extracted.
void extract_made_scene(const fs::path& folder, const fs::path& run, const MadeScene& scene) {
  write_made_scene(folder, scene);
  ASSERT_EQ(run_quietly({"segment", folder.string(), "--out", run.string(), "--iterations", "20"}), 0);
  ASSERT_EQ(run_quietly({"extract", run.string(), "--object", "300"}), 0);
}

json summary(const fs::path& run, const std::string& stage) {
  return json::parse(read_text(run / "run.json")).at("stages").at(stage).at("summary");
}

fs::path object_file(const fs::path& run, const std::string& file) {
  return run / summary(run, "extract").at("folder").get<std::string>() / file;
}

TEST(ExtractOptions, HullTakesWhatLiesBetweenThePartsOfTheObject) {
  // Two balls are one object; a smaller one stands between them, within their convex hull.
  const TemporaryFolder out;
  const MadeScene::Ball between = {Vec3f(0, 0, 0.08f), 0.1f, 70000, Vec3f(0.1f, 0.3f, 0.8f)};
  const MadeScene scene = made_scene({{Vec3f(-0.42f, 0, 0.15f), 0.3f, 300, Vec3f(0.8f, 0.1f, 0.1f)},
                                      {Vec3f(0.42f, 0, 0.15f), 0.3f, 300, Vec3f(0.8f, 0.1f, 0.1f)},
                                      between});
  extract_made_scene(out / "scene", out / "run", scene);
  const auto between_taken = [&] {
    size_t taken = 0;
    for (const Vec3f& x : read_ply(object_file(out / "run", "object.ply")).position)
      taken += (x - between.centre).norm() < between.radius;
    return taken;
  };
  const size_t standing =
      static_cast<size_t>(std::count_if(scene.cloud.position.begin(), scene.cloud.position.end(), [&](const Vec3f& x) {
        return (x - between.centre).norm() < between.radius && x.z() > 0.06f;
      }));
  ASSERT_GT(standing, 20u);
  EXPECT_EQ(between_taken(), 0u);
  EXPECT_EQ(summary(out / "run", "extract")["rules"]["hull"]["moved"], 0);
  ASSERT_EQ(run_quietly({"extract", (out / "run").string(), "--object", "300", "--hull"}), 0);
  EXPECT_GE(between_taken(), standing);
  EXPECT_EQ(summary(out / "run", "extract")["rules"]["hull"]["moved"], between_taken());
}

// The scene file names an object of its masks, which a selection does not have.
TEST(ExtractOptions, ASelectionIsCutWhicheverObjectTheSceneFileNames) {
  const TemporaryFolder out;
  write_made_scene(out / "scene", made_scene(two_balls()), "flower");
  const std::string scene = (out / "scene").string();
  ASSERT_EQ(run_quietly({"segment", scene, "--out", (out / "ball").string(), "--sphere", "-0.35,0.1,0.15,0.32"}), 0);
  ASSERT_EQ(run_quietly({"extract", (out / "ball").string()}), 0);
  EXPECT_TRUE(fs::exists(out / "ball/objects/1_object/object.ply"));

  // Where masks define the objects, the wrong name is the scene file's.
  ASSERT_EQ(run_quietly({"segment", scene, "--out", (out / "masks").string(), "--iterations", "0"}), 0);
  testing::internal::CaptureStderr();
  EXPECT_EQ(run_quietly({"extract", (out / "masks").string()}), 2);
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_NE(said.find("scene.json: object: flower"), std::string::npos) << said;
  EXPECT_EQ(said.find("--object"), std::string::npos) << said;
}

TEST(ExtractOptions, WhatTheSceneFileNamesIsNotSoughtByNumberAmongOtherMasks) {
  const TemporaryFolder out;
  write_made_scene(out / "scene", made_scene(two_balls()), "flower");
  fs::copy(out / "scene/masks", out / "others");
  fs::remove(out / "others/view0.png");
  const auto found_after = [&](const std::string& labels, const std::string& object) {
    json settings = json::parse(read_text(out / "scene/scene.json"));
    settings["object"] = settings["support"] = object;
    write_text(out / "scene/scene.json", settings.dump());
    write_text(out / "others/labels.json", labels);
    EXPECT_EQ(run_quietly({"segment", (out / "scene").string(), "--out", (out / "run").string(), "--masks",
                           (out / "others").string(), "--iterations", "0"}),
              0);
    const RunDirectory run = RunDirectory::open(out / "run");
    return inputs_of(run, load_run_scene(run), ExtractStage()).found;
  };
  for (const char* object : {"flower", "object_70000", "70000"}) {
    const json found = found_after("{}", object);
    EXPECT_TRUE(found.contains("chosen")) << object;
    EXPECT_FALSE(found.contains("support")) << object;
  }
  const json found = found_after(R"({"70000": "flower"})", "flower");
  EXPECT_EQ(found["id"], 70000);
  EXPECT_EQ(found["support"], 70000);
  EXPECT_FALSE(found.contains("chosen"));
}

TEST(ExtractOptions, IdsInTheSceneFileAreThoseOfItsMasksAsSegmentReadThem) {
  const TemporaryFolder out;
  write_made_scene(out / "scene", made_scene(two_balls()));
  const auto segment = [&](const std::string& associate, const std::string& object, const std::string& support) {
    json settings = json::parse(read_text(out / "scene/scene.json"));
    settings.update({{"object", object}, {"support", support}});
    write_text(out / "scene/scene.json", settings.dump());
    EXPECT_EQ(run_quietly({"segment", (out / "scene").string(), "--out", (out / "run").string(), "--associate",
                           associate, "--iterations", "0"}),
              0);
  };
  const auto found = [&] {
    const RunDirectory run = RunDirectory::open(out / "run");
    return inputs_of(run, load_run_scene(run), ExtractStage()).found;
  };
  segment("gaga", "1", "2");  // it numbers its groups anew, from 1 on
  EXPECT_TRUE(found().contains("chosen"));
  EXPECT_FALSE(found().contains("support"));
  segment("always", "300", "3");
  write_text(out / "scene/masks/notes.txt", "came later");
  EXPECT_EQ(found()["id"], 300);
  EXPECT_EQ(found()["support"], 3);
  EXPECT_FALSE(found().contains("chosen"));
}

TEST(ExtractOptions, TheBackgroundIsCutOnlyWhenItIsAskedFor) {
  const TemporaryFolder out;
  write_made_scene(out / "scene", made_scene(two_balls()), "", {300});
  const std::string run = (out / "run").string();
  ASSERT_EQ(run_quietly(
                {"segment", (out / "scene").string(), "--out", run, "--mask-zero", "background", "--iterations", "0"}),
            0);
  ASSERT_EQ(run_quietly({"extract", run}), 0);
  EXPECT_EQ(summary(out / "run", "extract")["name"], "object_300");
  ASSERT_EQ(run_quietly({"extract", run, "--object", "background"}), 0);
  EXPECT_EQ(summary(out / "run", "extract")["name"], "background");
}

TEST(ExtractOptions, WhereEveryObjectWasDroppedThereIsNothingToCut) {
  const TemporaryFolder out;
  write_made_scene(out / "scene", made_scene(two_balls()), "", {300});
  const std::string run = (out / "run").string();
  ASSERT_EQ(run_quietly({"segment", (out / "scene").string(), "--out", run, "--iterations", "0"}), 0);
  ASSERT_EQ(run_quietly({"segment", "edit", run, "--drop", "300"}), 0);
  testing::internal::CaptureStderr();
  EXPECT_EQ(run_quietly({"extract", run}), 2);
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_NE(said.find("the scene has no objects"), std::string::npos) << said;
}

/// A run on two balls, the first (object 300) with a contact shadow, that every test works on a copy of.
class OneBall : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder = fs::temp_directory_path() / ("pliant_one_ball_" + std::to_string(getpid()));
    fs::remove_all(folder);
    MadeScene scene = made_scene(two_balls(), 8, 200, 150);
    shade_table(scene.cloud, [](const Vec3f& x) { return Vec3f::Constant(soft_gain(x)).eval(); });
    extract_made_scene(folder / "scene", folder / "run", scene);
  }
  static void TearDownTestSuite() { fs::remove_all(folder); }

  static fs::path copy_of_run(const TemporaryFolder& out) {
    fs::copy(folder / "run", out / "run", fs::copy_options::recursive);
    return out / "run";
  }

  static fs::path folder;
};
fs::path OneBall::folder;

TEST_F(OneBall, ShadowKeepLeavesTheColoursOfTheSupport) {
  const TemporaryFolder out;
  const fs::path run = copy_of_run(out);
  const GaussianCloud before = read_ply(run / "background.ply");
  const auto brightened = [&] {  // Gaussians of the table that are brighter now
    const GaussianCloud after = read_ply(run / "background_repaired.ply");
    std::map<std::array<float, 3>, float> red;
    for (size_t p = 0; p < after.size(); ++p)
      red[{after.position[p].x(), after.position[p].y(), after.position[p].z()}] = after.sh_of(p)[0];
    size_t count = 0;
    for (size_t p = 0; p < before.size(); ++p) {
      const auto found = red.find({before.position[p].x(), before.position[p].y(), before.position[p].z()});
      count += found != red.end() && found->second > before.sh_of(p)[0] + 0.01f;
    }
    return count;
  };
  ASSERT_EQ(run_quietly({"repair", run.string()}), 0);
  EXPECT_GT(brightened(), 50u);
  EXPECT_GT(summary(run, "repair")["shadow_gaussians"].get<size_t>(), 50u);
  ASSERT_EQ(run_quietly({"repair", run.string(), "--shadow", "keep"}), 0);
  EXPECT_EQ(brightened(), 0u);
  EXPECT_EQ(summary(run, "repair")["shadow_gaussians"], 0);
  EXPECT_NE(summary(run, "repair")["shadow"].get<std::string>().find("kept"), std::string::npos);
}

TEST_F(OneBall, RepairStopsAtTheFirstChanceWhenItIsAskedTo) {
  const TemporaryFolder out;
  RunDirectory run = RunDirectory::open(copy_of_run(out));
  const Scene scene = load_run_scene(run);
  Progress progress(true);
  int asked = 0;
  const Context context{progress, [&] { return ++asked > 0; }};
  expect_error(Failure::kInterrupted, {"repair", "run the same command again"},
               [&] { run_repair(context, run, scene, {}); });
  EXPECT_EQ(asked, 1);
  EXPECT_FALSE(fs::exists(run / "background_repaired.ply"));
}

TEST_F(OneBall, RepairWarnsWhenNoCameraShowsTheObject) {
  const TemporaryFolder out;
  RunDirectory run = RunDirectory::open(copy_of_run(out));
  Scene scene = load_run_scene(run);
  for (Camera& camera : scene.cameras)  // the back to the scene
    camera.cam_from_world = Eigen::AngleAxisd(M_PI, Vec3d::UnitY()) * camera.cam_from_world;
  Progress progress(true);
  const Context context{progress, [] { return false; }};
  testing::internal::CaptureStderr();
  run_repair(context, run, scene, {});
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_NE(said.find("no camera shows the object"), std::string::npos) << said;
}

constexpr float kSoftAbove = 0.25f;  // a third of the ball

/// Driving particles above and below kSoftAbove, where the ball's surface is far.
std::pair<size_t, size_t> above_and_below(const ParticleFile& file) {
  std::pair<size_t, size_t> count;
  for (const Vec3f& x : file.driving_position)
    if ((x - two_balls()[0].centre).norm() < 0.2f && std::abs(x.z() - kSoftAbove) > 0.02f)
      ++(x.z() > kSoftAbove ? count.first : count.second);
  return count;
}

TEST_F(OneBall, PgasPlacesTheWantedNumberOfParticlesDenserWhereTheFileSaysSoft) {
  const TemporaryFolder out;
  const fs::path run = copy_of_run(out);
  const auto seed = [&](std::vector<std::string> options) {
    options.insert(options.begin(), {"seed", run.string(), "--particles", "800"});
    return run_quietly(options);
  };
  EXPECT_EQ(seed({"--sampling", "voronoi"}), 2);
  EXPECT_FALSE(fs::exists(object_file(run, "particles.h5")));
  ASSERT_EQ(seed({}), 0);
  EXPECT_EQ(summary(run, "seed")["placed_by"], "kmeans");
  const ParticleFile kmeans = read_particles(object_file(run, "particles.h5"));

  ASSERT_EQ(seed({"--sampling", "pgas"}), 0);
  EXPECT_EQ(summary(run, "seed")["placed_by"], "pgas");
  const ParticleFile pgas = read_particles(object_file(run, "particles.h5"));
  EXPECT_NEAR(pgas.driving_position.size(), 800, 16);
  EXPECT_NE(pgas.driving_position, kmeans.driving_position);
  EXPECT_EQ(pgas.solid_position, kmeans.solid_position);
  double volume = 0, expected = 0;
  for (const float v : pgas.driving_volume) volume += v;
  for (size_t i = 0; i < pgas.solid_volume.size(); ++i)
    expected += pgas.solid_driver[i] >= 0 ? pgas.solid_volume[i] : 0;
  EXPECT_NEAR(volume / expected, 1, 1e-5);
  const auto [above, below] = above_and_below(pgas);

  // E four times smaller at the top, given at the samples.
  MaterialFile material;
  for (const Vec3f& x : pgas.solid_position) material.young.push_back(x.z() > kSoftAbove ? 2.5e4f : 1e5f);
  material.poisson.assign(material.young.size(), 0.3f);
  material.density.assign(material.young.size(), 900.0f);
  material.position = pgas.solid_position;
  material.volume = pgas.solid_volume;
  write_material(out / "material.h5", material, "{}");
  const std::string file = (out / "material.h5").string();
  EXPECT_EQ(seed({"--material", file}), 2);  // K-means has no use for it
  ASSERT_EQ(seed({"--sampling", "pgas", "--material", file}), 0);
  const ParticleFile soft = read_particles(object_file(run, "particles.h5"));
  EXPECT_NEAR(soft.driving_position.size(), 800, 16);
  EXPECT_GT(soft.cell_size, 1.15 * pgas.cell_size);
  const auto [soft_above, soft_below] = above_and_below(soft);
  EXPECT_GT(static_cast<double>(soft_above) / soft_below, 2.5 * above / below);
}

}  // namespace
}  // namespace pliant

// A hand-made run of an object that turns and travels, exported as numbered splat files: they hold what `render` draws.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "app/commands/program.h"
#include "app/run/attach_scene.h"
#include "app/simulate/moving_scene.h"
#include "gaussians/base/random.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/splats/ply.h"
#include "gaussians/render/render.h"
#include "tests/app/finished_stage.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr int kFrames = 7;

GaussianCloud cloud_at(const Vec3f& centre, int count, uint64_t seed) {
  GaussianCloud cloud;
  cloud.sh_degree = 2;
  cloud.resize(count);
  for (int i = 0; i < count; ++i) {
    Random random(seed, i);
    for (int k = 0; k < 3; ++k) {
      cloud.position[i][k] = centre[k] + static_cast<float>(random.uniform(-0.25, 0.25));
      cloud.log_scale[i][k] = static_cast<float>(random.uniform(-4, -2.5));
    }
    for (int k = 0; k < 4; ++k) cloud.rotation[i][k] = static_cast<float>(random.normal());
    cloud.opacity_logit[i] = static_cast<float>(random.uniform(0, 3));
    for (int k = 0; k < cloud.sh_count() * 3; ++k) cloud.sh_of(i)[k] = static_cast<float>(0.3 * random.normal());
  }
  return cloud;
}

class ExportTest : public testing::Test {
 protected:
  static Eigen::Isometry3d motion(int frame) {
    Eigen::Isometry3d m = Eigen::Isometry3d::Identity();
    m.linear() = Eigen::AngleAxisd(0.2 * frame, Eigen::Vector3d(0.3, -0.5, 0.8).normalized()).toRotationMatrix();
    m.translation() = Eigen::Vector3d(0.03, 0.01, 0.02) * frame;
    return m;
  }

  ExportTest() : object(cloud_at(Vec3f::Zero(), 300, 1)), background(cloud_at(Vec3f(0, 0.6f, 0), 200, 2)) {
    GaussianCloud whole = background;
    whole.append(object);
    write_ply(folder / "scene.ply", whole);
    write_ply(folder / "run/objects/1_ball/object.ply", object);
    write_ply(folder / "run/background.ply", background);
    ParticleFile particles;
    for (float x = -0.3f; x < 0.31f; x += 0.1f)
      for (float y = -0.3f; y < 0.31f; y += 0.1f)
        for (float z = -0.3f; z < 0.31f; z += 0.1f) particles.driving_position.push_back({x, y, z});
    particles.driving_volume.assign(particles.driving_position.size(), 1e-3f);
    particles.solid_position = particles.driving_position;
    particles.solid_volume = particles.driving_volume;
    for (size_t i = 0; i < particles.driving_position.size(); ++i)
      particles.solid_driver.push_back(static_cast<int>(i));
    particles.cell_size = 0.2;
    write_particles(folder / "run/objects/1_ball/particles.h5", particles, "{}");
    trajectory.object = "ball";
    trajectory.fps = 30;
    trajectory.cell_size = 0.2;
    for (int f = 0; f < kFrames; ++f) {
      TrajectoryFile::Frame frame;
      frame.time = f / 30.0;
      frame.step = 10 * f;
      for (const Vec3f& x : particles.driving_position)
        frame.position.push_back((motion(f) * x.cast<double>()).cast<float>());
      frame.velocity.assign(frame.position.size(), Vec3f::Zero());
      frame.F.assign(frame.position.size(), motion(f).linear().cast<float>());
      trajectory.frames.push_back(frame);
    }
    write_trajectory(folder / "run/objects/1_ball/trajectory.h5", trajectory, "{}");
    const json space = {{"scale", 1}, {"offset", {0, 0, 0}}, {"rotation", {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}};
    const json manifest = {{"scene", {{"source", (folder / "scene.ply").string()}, {"orbit_views", 4}}},
                           {"stages",
                            {{"extract", finished_stage({{"folder", "objects/1_ball"}})},
                             {"simulate", finished_stage({{"space", space}})}}}};
    write_text(folder / "run/run.json", manifest.dump());
  }

  int run(std::vector<std::string> options) const {
    options.insert(options.begin(), {"pliant", "export", (folder / "run").string(), "--quiet"});
    std::vector<const char*> argv;
    for (const std::string& option : options) argv.push_back(option.c_str());
    return run_program(static_cast<int>(argv.size()), argv.data());
  }
  std::string out() const { return (folder / "ply").string(); }
  GaussianCloud frame(int k) const { return read_ply(folder / ("ply/frame_000" + std::to_string(k) + ".ply")); }

  TemporaryFolder folder;
  GaussianCloud object, background;
  TrajectoryFile trajectory;
  const Camera camera = look_at({0.9, -1.2, 0.6}, {0, 0.2, 0}, {0, 0, 1}, 120, 90, 110);
};

TEST_F(ExportTest, FramesHoldTheBackgroundAsItIsAndTheObjectTurnedAndMoved) {
  ASSERT_EQ(run({"--ply-sequence", out()}), 0);
  for (int f = 0; f < kFrames; ++f) {
    const GaussianCloud cloud = frame(f);
    ASSERT_EQ(cloud.size(), background.size() + object.size());
    EXPECT_EQ(cloud.sh_degree, 2);
    for (size_t i = 0; i < background.size(); ++i) ASSERT_EQ(cloud.position[i], background.position[i]);
    for (size_t i = 0; i < object.size(); ++i) {
      const Vec3f expected = (motion(f) * object.position[i].cast<double>()).cast<float>();
      ASSERT_LT((cloud.position[background.size() + i] - expected).norm(), 1e-5f);
    }
  }
  // Frame 0 is the scene at rest, for the eye as well.
  GaussianCloud rest = background;
  rest.append(object);
  const ImageF a = render(frame(0), camera).color, b = render(rest, camera).color;
  for (size_t i = 0; i < a.data.size(); ++i) ASSERT_NEAR(a.data[i], b.data[i], 2e-3f);
  // A camera that travels with the object sees later frames of it as it was at rest: colours turned with it.
  ASSERT_EQ(run({"--ply-sequence", (folder / "alone").string(), "--object-only"}), 0);
  const GaussianCloud alone = read_ply(folder / "alone/frame_0005.ply");
  ASSERT_EQ(alone.size(), object.size());
  Camera follows = camera;
  follows.cam_from_world = camera.cam_from_world * motion(5).inverse();
  const ImageF c = render(alone, follows).color, d = render(object, camera).color;
  int different = 0;
  for (size_t i = 0; i < c.data.size(); ++i) different += std::abs(c.data[i] - d.data[i]) > 2e-3f;
  EXPECT_LE(different, 5) << "only pixels at a threshold may differ";
}

TEST_F(ExportTest, APictureOfAnExportedFrameIsThatOfTheFrameThatRenderDraws) {
  ASSERT_EQ(run({"--ply-sequence", out(), "--every", "3"}), 0);
  EXPECT_FALSE(fs::exists(folder / "ply/frame_0003.ply"));
  const RunDirectory directory = RunDirectory::open(folder / "run");
  const MovingScene moving = load_moving_scene(moving_scene_files(directory), load_run_scene(directory));
  EXPECT_EQ(moving.moving(), object.size());
  for (const int k : {0, 1, 2}) {
    const ImageF exported = render(frame(k), camera).color;
    EXPECT_EQ(exported.data, render(moving.all_at(moving.trajectory.frames[3 * k]), camera).color.data) << k;
  }
  const json record = json::parse(read_text(folder / "ply/sequence.json"));
  EXPECT_EQ(record["fps"], 10);
  EXPECT_EQ(record["frames"].size(), 3u);
  EXPECT_NEAR(record["frames"][2]["time"].get<double>(), 0.2, 1e-12);
}

TEST_F(ExportTest, ARepeatedCommandWritesOnlyWhatIsMissing) {
  ASSERT_EQ(run({"--ply-sequence", out()}), 0);
  const std::string hash = sha256_of_file(folder / "ply/frame_0004.ply");
  fs::remove(folder / "ply/frame_0004.ply");
  folder.file("ply/.frame_0004.tmp77.ply", "half");
  const auto before = fs::last_write_time(folder / "ply/frame_0003.ply");
  ASSERT_EQ(run({"--ply-sequence", out()}), 0);
  EXPECT_EQ(sha256_of_file(folder / "ply/frame_0004.ply"), hash);
  EXPECT_EQ(fs::last_write_time(folder / "ply/frame_0003.ply"), before);
  EXPECT_FALSE(fs::exists(folder / "ply/.frame_0004.tmp77.ply"));
}

TEST_F(ExportTest, FramesOfAZUpSceneSaySo) {
  GaussianCloud whole = background;
  whole.append(object);
  write_ply(folder / "scene.ply", whole, false, true);
  ASSERT_EQ(run({"--ply-sequence", out(), "--every", "6"}), 0);
  ReadReport report;
  read_ply(folder / "ply/frame_0001.ply", &report);
  EXPECT_TRUE(report.z_is_up);
}

TEST_F(ExportTest, FramesThatSayOtherwiseHowTheyAreDrawnAreNotKept) {
  GaussianCloud whole = background;
  whole.append(object);
  const auto marks = [&] {
    ReadReport report;
    read_ply(folder / "ply/frame_0001.ply", &report);
    return std::pair(report.antialiased, report.z_is_up);
  };
  const std::vector<std::string> words = {"--ply-sequence", out(), "--every", "6"};
  ASSERT_EQ(run(words), 0);
  for (const auto& [antialiased, z_is_up] : {std::pair(true, false), {true, true}, {false, true}}) {
    const auto before = marks();
    write_ply(folder / "scene.ply", whole, antialiased, z_is_up);
    EXPECT_EQ(run(words), 2);
    EXPECT_EQ(marks(), before);
    ASSERT_EQ(run({"--ply-sequence", out(), "--every", "6", "--overwrite"}), 0);
    EXPECT_EQ(marks(), std::pair(antialiased, z_is_up));
    EXPECT_EQ(run(words), 0);
  }
}

TEST_F(ExportTest, OutputOfPhysGaussianThatIsReplacedLeavesNoFramesOfALongerMotion) {
  folder.file("pg/mine.txt", "keep");
  folder.file("pg/simulation_ply/sim_0000000007.ply", "of a longer motion");
  const std::string pg = (folder / "pg").string();
  EXPECT_EQ(run({"--physgaussian-output", pg}), 2);
  ASSERT_EQ(run({"--physgaussian-output", pg, "--overwrite"}), 0);
  EXPECT_TRUE(fs::exists(folder / "pg/simulation_ply/sim_0000000006.ply"));
  EXPECT_FALSE(fs::exists(folder / "pg/simulation_ply/sim_0000000007.ply"));
  EXPECT_EQ(read_text(folder / "pg/mine.txt"), "keep");
}

TEST_F(ExportTest, OutputOfPhysGaussianIsThatOfTheParticlesThatAreThere) {
  const fs::path file = folder / "run/run.json", particles = folder / "run/objects/1_ball/particles.h5";
  json record = json::parse(read_text(file));
  const auto export_with = [&](const json& hash) {
    record["stages"]["simulate"]["inputs"]["particles"] = hash;
    write_text(file, record.dump());
    return run({"--physgaussian-output", (folder / "pg").string()});
  };
  EXPECT_EQ(export_with("of other particles"), 2);
  EXPECT_FALSE(fs::exists(folder / "pg"));
  EXPECT_EQ(export_with(hash_of_input(particles)), 0);
}

// As they were left by versions that did not record it.
TEST_F(ExportTest, TheMaterialOfARunThatDoesNotSayWhatWasSimulatedIsRefused) {
  const fs::path file = folder / "run/run.json", material = folder / "material.ply";
  json record = json::parse(read_text(file));
  json& summary = record["stages"]["simulate"]["summary"];
  const auto export_with = [&](const json& session) {
    summary["session"] = session;
    write_text(file, record.dump());
    return run({"--material", material.string(), "--overwrite"});
  };
  ASSERT_FALSE(summary.contains("session"));
  EXPECT_EQ(run({"--material", material.string()}), 2);
  EXPECT_EQ(export_with({{"law", "metal"}}), 2);
  EXPECT_FALSE(fs::exists(material));
  EXPECT_EQ(export_with({{"uniform", {{"young", 1e5}, {"poisson", 0.3}, {"density", 500}}}}), 0);
  EXPECT_TRUE(fs::exists(material));
}

TEST_F(ExportTest, WhatWasRecordedIsExportedWhereItIsAskedFor) {
  EXPECT_EQ(run({"--ply-sequence", out(), "--recorded"}), 2) << "nothing has been recorded";
  const fs::path ball = folder / "run/objects/1_ball";
  fs::copy_file(ball / "particles.h5", ball / "recording_particles.h5");
  TrajectoryFile recorded = trajectory;
  recorded.frames.resize(3);
  const auto record = [&](const std::string& object) {
    write_trajectory(ball / "recording.h5", recorded, json({{"object", object}}).dump());
  };
  record("of then");
  EXPECT_EQ(run({"--ply-sequence", out(), "--recorded"}), 2) << "of another object";
  record(hash_of_input(ball / "object.ply"));
  const std::string pg = (folder / "pg").string();
  ASSERT_EQ(run({"--physgaussian-output", pg, "--recorded"}), 0);
  EXPECT_TRUE(fs::exists(folder / "pg/simulation_ply/sim_0000000002.ply"));
  EXPECT_FALSE(fs::exists(folder / "pg/simulation_ply/sim_0000000003.ply"));
  ASSERT_EQ(run({"--ply-sequence", out(), "--recorded"}), 0);
  EXPECT_TRUE(fs::exists(folder / "ply/frame_0002.ply"));
  EXPECT_FALSE(fs::exists(folder / "ply/frame_0003.ply"));
  EXPECT_EQ(json::parse(read_text(folder / "ply/sequence.json"))["recorded"], true);
  EXPECT_EQ(run({"--ply-sequence", out()}), 2) << "the simulated motion is another sequence";
  EXPECT_EQ(run({"--material", (folder / "material.ply").string(), "--recorded"}), 2);
}

TEST_F(ExportTest, AnotherSequenceOrOtherFilesAreNotMixedIn) {
  ASSERT_EQ(run({"--ply-sequence", out()}), 0);
  EXPECT_EQ(run({"--ply-sequence", out(), "--every", "2"}), 2);
  EXPECT_EQ(run({"--ply-sequence", out(), "--object-only"}), 2);
  EXPECT_TRUE(fs::exists(folder / "ply/frame_0006.ply"));
  EXPECT_EQ(run({"--ply-sequence", out(), "--every", "2", "--overwrite"}), 0);
  EXPECT_TRUE(fs::exists(folder / "ply/frame_0003.ply"));
  EXPECT_FALSE(fs::exists(folder / "ply/frame_0004.ply"));
  folder.file("ply/mine.txt", "keep");
  EXPECT_EQ(run({"--ply-sequence", out(), "--overwrite"}), 2);
  EXPECT_EQ(read_text(folder / "ply/mine.txt"), "keep");
  EXPECT_TRUE(fs::exists(folder / "ply/frame_0003.ply")) << "refused before anything was removed";
  folder.file("other/mine.txt", "keep");
  EXPECT_EQ(run({"--ply-sequence", (folder / "other").string()}), 2);
  EXPECT_EQ(run({"--ply-sequence", (folder / "other/mine.txt").string()}), 2);
  EXPECT_EQ(run({}), 2);
  EXPECT_EQ(run({"--ply-sequence", out(), "--every", "0"}), 2);
}

}  // namespace
}  // namespace pliant

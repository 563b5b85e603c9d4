// From a video to what the flower is made of, on a small demo scene whose truth is taken away before.

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "app/store/material.h"
#include "app/store/velocity.h"
#include "gaussians/io/files/files.h"
#include "tests/app/run_pliant.h"
#include "tests/app/small_demo.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

TEST(FitCommand, AVideoTellsStiffnessAndDampingAndSimulateUsesThem) {
  const fs::path folder = fs::temp_directory_path() / ("pliant_fit_" + std::to_string(getpid()));
  fs::remove_all(folder);
  make_demo(small_demo(folder / "scene"));
  const double truth = json::parse(read_text(folder / "scene/truth/flower.json"))["solids"]["stem"]["young"];
  fs::remove_all(folder / "scene/truth");
  const std::string scene = (folder / "scene").string(), out = (folder / "run").string();
  const std::vector<std::string> run = {"run",
                                        scene,
                                        "--out",
                                        out,
                                        "--seed.particles",
                                        "600",
                                        "--duration",
                                        "1",
                                        "--simulate.fps",
                                        "12",
                                        "--segment.iterations",
                                        "60",
                                        "--fit.end",
                                        "1.1",
                                        "--render.no-orbit"};
  ASSERT_EQ(run_quietly(run), 0);

  json manifest = json::parse(read_text(folder / "run/run.json"));
  const json fit = manifest["stages"]["fit"]["summary"];
  EXPECT_NEAR(std::log10(fit["young_pa"].get<double>() / truth), 0,
              0.2);  // leaves and blossom are softer than the stem
  EXPECT_GT(fit["damping_time_s"].get<double>(), 0.5);
  EXPECT_LT(fit["rms_px"].get<double>(), 0.4 * fit["rms_still_px"].get<double>());
  EXPECT_GE(fit["first_frame"].get<int>(), 6);  // a force pushes until 0.375 s, frame 9
  EXPECT_EQ(fit["frames_later"].size(), 2u);    // the first and the last
  for (const char* file : {"fit/results.json", "fit/side_by_side.mp4"})
    EXPECT_TRUE(fs::exists(folder / "run" / file)) << file;

  // Every solid sample has the fitted value, and the motion of the video is what is simulated.
  const fs::path object = folder / "run/objects" / fs::directory_iterator(folder / "run/objects")->path().filename();
  const MaterialFile material = read_material(object / "material.h5");
  EXPECT_NEAR(material.young.front() / fit["young_pa"].get<double>(), 1, 1e-5);
  EXPECT_EQ(material.source.substr(0, 11), "homogeneous");
  EXPECT_NEAR(read_velocity(object / "velocity.h5").damping_time, fit["damping_time_s"].get<double>(), 1e-9);
  EXPECT_EQ(json::parse(read_text(folder / "run/interactions.json")).size(), 0u);
  EXPECT_GT(manifest["stages"]["simulate"]["summary"]["motion"]["tip_peak"].get<double>(), 0.03);

  // Nothing changes on repetition; the fit is left out where the user says what it is made of.
  const std::string record = read_text(folder / "run/run.json");
  ASSERT_EQ(run_quietly(run), 0);
  EXPECT_EQ(read_text(folder / "run/run.json"), record);
  ASSERT_EQ(run_quietly({"simulate", out, "--young", "30000", "--duration", "0.2"}), 0);
  manifest = json::parse(read_text(folder / "run/run.json"));
  EXPECT_EQ(manifest["stages"]["simulate"]["options"]["young"], 30000);
  EXPECT_NEAR(read_material(object / "material.h5").young.front(), material.young.front(),
              1e-3);  // the fit's file stays

  // Wrong cameras and files end with the right code: another camera of the scene did not take this video.
  EXPECT_EQ(run_quietly({"fit", out, "--video-camera", "view_001", "--overwrite"}), 1);
  EXPECT_EQ(run_quietly({"fit", out, "--video-camera", "vieww_001", "--overwrite"}), 2);
  EXPECT_EQ(run_quietly({"fit", out, "--video", (folder / "nothing.mp4").string(), "--video-camera", "view_001",
                         "--overwrite"}),
            1);
  fs::remove_all(folder);
}

TEST(FitCommand, WithoutTheVideoTheMaterialIsTheSceneFilesAndTheCommandLines) {
  const TemporaryFolder folder;
  DemoOptions demo;
  demo.training = 0;
  demo.out = folder / "scene";
  demo.gaussians = 6000;
  demo.photos = 6;
  demo.width = 160;
  demo.height = 120;
  demo.video_particles = 1000;
  demo.video_seconds = 0.3;
  make_demo(demo);
  const json settings = json::parse(read_text(folder / "scene/scene.json"));
  ASSERT_TRUE(settings.contains("video"));
  ASSERT_EQ(run_quietly({"run", (folder / "scene").string(), "--out", (folder / "run").string(), "--no-video",
                         "--density", "450", "--poisson", "0.2", "--seed.particles", "300", "--duration", "0.2",
                         "--simulate.fps", "10", "--segment.iterations", "40", "--render.no-orbit"}),
            0);
  const json stages = json::parse(read_text(folder / "run/run.json"))["stages"];
  EXPECT_FALSE(stages.contains("fit"));
  EXPECT_FALSE(fs::exists(folder / "run/fit"));
  const json material = stages["simulate"]["found"]["material"];
  EXPECT_EQ(material["young"], settings["material"]["young"]);
  EXPECT_EQ(material["density"], 450);
  EXPECT_EQ(material["poisson"], 0.2);
  EXPECT_TRUE(fs::exists(folder / "run/clip.mp4"));
}

}  // namespace
}  // namespace pliant

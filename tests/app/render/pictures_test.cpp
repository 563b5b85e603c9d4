// `render` of a scene: images and videos from its cameras, and what they replace.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "gaussians/base/camera.h"
#include "gaussians/io/cameras/transforms.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/images/codecs.h"
#include "gaussians/io/splats/ply.h"
#include "tests/app/run_pliant.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

namespace fs = std::filesystem;

/// A scene of one bright Gaussian in the middle.
fs::path spot_scene(const TemporaryFolder& folder) {
  GaussianCloud cloud;
  cloud.resize(1);
  cloud.log_scale[0] = Vec3f::Constant(std::log(0.05f));
  cloud.opacity_logit[0] = 5;
  std::fill_n(cloud.sh_of(0), 3, 1.5f);
  write_ply(folder / "a.ply", cloud);
  return folder / "a.ply";
}

TEST(ScenePictures, WhatCannotBeWrittenIsAUsageError) {
  const TemporaryFolder folder;
  const std::string scene = spot_scene(folder).string();
  const auto render = [&](const std::string& out, std::vector<std::string> words = {}) {
    words.insert(words.begin(), {"render", scene, "--orbit-views", "4", "--cameras", "orbit", "--size", "32x24",
                                 "--out", (folder / out).string()});
    return run_quietly(words);
  };
  folder.file("taken", "a file");
  fs::create_directory(folder / "folder.mp4");
  for (const char* out : {"a.webm", "a.MOV", "a.gif", "a.png", "taken", "taken/below", "taken/a.mp4", "folder.mp4"})
    EXPECT_EQ(render(out), 2) << out;
  for (const char* background : {"2,0,0", "0,-0.1,0", "0,0,nan"})
    EXPECT_EQ(render("images", {std::string("--background=") + background}), 2) << background;
  EXPECT_FALSE(fs::exists(folder / "images"));
  EXPECT_FALSE(fs::exists(folder / "a.webm"));
  EXPECT_EQ(render("clip.MP4"), 0);
  EXPECT_TRUE(fs::is_regular_file(folder / "clip.MP4"));
  EXPECT_EQ(render("images.v2", {"--background", "1,0.5,0"}), 0);
  EXPECT_TRUE(fs::is_directory(folder / "images.v2"));
  // A camera of one column.
  Camera narrow = look_at({2, 0, 0}, {0, 0, 0}, {0, 0, 1}, 1, 48, 60);
  narrow.name = "narrow";
  write_transforms(folder / "t.json", {narrow});
  const std::vector<std::string> words = {"render", scene, "--cameras", (folder / "t.json").string(), "--out"};
  for (const auto& [out, code] : {std::pair("narrow.mp4", 2), std::pair("narrow", 0)}) {
    std::vector<std::string> all = words;
    all.push_back((folder / out).string());
    EXPECT_EQ(run_quietly(all), code) << out;
  }
  EXPECT_FALSE(fs::exists(folder / "narrow.mp4"));
}

TEST(ScenePictures, OfAnEarlierCallAreReplacedAndOtherFilesStay) {
  const TemporaryFolder folder;
  spot_scene(folder);
  folder.file("images/mine.png", "");
  const auto render = [&](const std::string& views, std::vector<std::string> more) {
    std::vector<std::string> words = {"render",        (folder / "a.ply").string(),
                                      "--out",         (folder / "images").string(),
                                      "--cameras",     "orbit",
                                      "--orbit-views", views,
                                      "--size",        "32x24"};
    words.insert(words.end(), more.begin(), more.end());
    EXPECT_EQ(run_quietly(words), 0) << views;
    std::set<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder / "images")) names.insert(entry.path().stem());
    return names;
  };
  const std::set<std::string> others = {"mine", "pictures"};
  std::set<std::string> first = others, second = others;
  for (int k = 0; k < 5; ++k) {
    first.insert({fmt::format("orbit_{:03}", k), fmt::format("orbit_{:03}_depth", k)});
    if (k < 4) second.insert(fmt::format("orbit_{:03}", k));
  }
  EXPECT_EQ(render("5", {"--depth"}), first);
  EXPECT_EQ(render("4", {}), second);
  // A record leads nowhere else.
  folder.file("outside.png", "");
  folder.file("images/pictures.json", R"({"pictures": ["../outside.png", "/outside.png", 3,
    "orbit_000.png", "orbit_001.png", "orbit_002.png", "orbit_003.png"]})");
  EXPECT_EQ(render("4", {}), second);
  EXPECT_TRUE(fs::exists(folder / "outside.png"));
}

TEST(ScenePictures, WhatRenderDidNotWriteIsNotReplaced) {
  const TemporaryFolder folder;
  spot_scene(folder);
  const auto render = [&](const std::string& out) {
    return run_quietly({"render", (folder / "a.ply").string(), "--out", (folder / out).string(), "--cameras", "orbit",
                        "--orbit-views", "4", "--size", "32x24"});
  };
  folder.file("photos/orbit_001.png", "a photo");
  EXPECT_EQ(render("photos"), 2);
  EXPECT_EQ(read_text(folder / "photos/orbit_001.png"), "a photo");
  EXPECT_FALSE(fs::exists(folder / "photos/orbit_000.png")) << "refused before anything is written";
  EXPECT_FALSE(fs::exists(folder / "photos/pictures.json"));
  EXPECT_EQ(render("images"), 0);
  // As an interrupted call leaves it.
  fs::remove(folder / "images/orbit_001.png");
  EXPECT_EQ(render("images"), 0);
  EXPECT_TRUE(fs::exists(folder / "images/orbit_001.png"));
}

TEST(SceneVideo, OfTheSceneIsNotReplaced) {
  const TemporaryFolder folder;
  spot_scene(folder);
  Camera camera = look_at({2, 0, 0}, {0, 0, 0}, {0, 0, 1}, 32, 24, 30);
  camera.name = "view";
  write_transforms(folder / "t.json", {camera});
  folder.file("swing.mp4", "a video");
  folder.file("scene.json", R"({"splats": "a.ply", "cameras": "t.json",
    "video": {"file": "swing.mp4", "camera": "view", "fps": 30}})");
  const auto render = [&](const std::string& out) {
    return run_quietly({"render", folder.path().string(), "--out", (folder / out).string()});
  };
  EXPECT_EQ(render("swing.mp4"), 2);
  EXPECT_EQ(read_text(folder / "swing.mp4"), "a video");
  EXPECT_EQ(render("other.mp4"), 0);
  EXPECT_EQ(render("other.mp4"), 0) << "again";
}

TEST(SceneVideo, IsAsLongWithOtherFramesPerSecond) {
  const TemporaryFolder folder;
  const std::string scene = spot_scene(folder).string();
  const auto render = [&](const std::string& out, std::vector<std::string> more) {
    std::vector<std::string> words = {"render", scene,    "--cameras", "orbit", "--orbit-views",
                                      "16",     "--size", "32x24",     "--out", (folder / out).string()};
    words.insert(words.end(), more.begin(), more.end());
    return run_quietly(words);
  };
  for (const auto& [fps, frames] : {std::pair("10", 6), {"30", 16}, {"60", 31}}) {
    ASSERT_EQ(render("a.mp4", {"--clip-fps", fps}), 0) << fps;
    const auto video = codecs::open_video((folder / "a.mp4").string());
    EXPECT_NEAR(video->get(cv::CAP_PROP_FPS), std::stod(fps), 0.01);
    cv::Mat frame;
    int count = 0;
    while (video->read(frame)) ++count;
    EXPECT_EQ(count, frames) << fps;
  }
  EXPECT_EQ(render("images", {"--clip-fps", "10"}), 2);
}

TEST(ScenePictures, MayBeThatOfOneCamera) {
  const TemporaryFolder folder;
  const std::string scene = spot_scene(folder).string(), out = (folder / "images").string();
  const auto render = [&](const std::string& camera, const std::string& to) {
    return run_quietly({"render", scene, "--cameras", "orbit", "--orbit-views", "4", "--size", "32x24", "--camera",
                        camera, "--out", to});
  };
  EXPECT_EQ(render("orbit_002", out), 0);
  EXPECT_TRUE(fs::exists(folder / "images/orbit_002.png"));
  EXPECT_FALSE(fs::exists(folder / "images/orbit_001.png"));
  EXPECT_EQ(render("orbit_009", out), 2);
  EXPECT_EQ(render("orbit_002", (folder / "a.mp4").string()), 2);
}

TEST(SceneVideo, CamerasOfOtherSizesAreFittedIntoItsFrames) {
  const TemporaryFolder folder;
  spot_scene(folder);
  const Camera large = look_at({2, 0, 0}, {0, 0, 0}, {0, 0, 1}, 64, 48, 60);
  for (const bool large_first : {true, false}) {
    std::vector<Camera> cameras = {large, large.scaled(0.5)};
    if (!large_first) std::swap(cameras[0], cameras[1]);
    for (int k = 0; k < 2; ++k) cameras[k].name = "view" + std::to_string(k);
    write_transforms(folder / "t.json", cameras);
    ASSERT_EQ(run_quietly({"render", (folder / "a.ply").string(), "--cameras", (folder / "t.json").string(), "--out",
                           (folder / "a.mp4").string()}),
              0);
    const auto video = codecs::open_video((folder / "a.mp4").string());
    cv::Mat frame;
    for (int k = 0; k < 2; ++k) {
      ASSERT_TRUE(video->read(frame)) << k;
      ASSERT_EQ(frame.cols, cameras[0].width);
      double brightest = 0;
      cv::Point at;
      cv::minMaxLoc(frame.reshape(1).colRange(0, 3 * frame.cols), nullptr, &brightest, nullptr, &at);
      EXPECT_GT(brightest, 100);
      EXPECT_NEAR(at.x / 3, frame.cols / 2, 2);
      EXPECT_NEAR(at.y, frame.rows / 2, 2);
    }
    EXPECT_FALSE(video->read(frame));
  }
}

TEST(ScenePictures, WhatIsDoubtfulAboutTheSceneIsSaid) {
  const TemporaryFolder folder;
  const fs::path scene = spot_scene(folder);
  std::string bytes = read_text(scene);
  bytes.insert(bytes.find("element"), "comment Generated by Nerfstudio\n");
  write_text(scene, bytes);
  Camera camera = look_at({2, 0, 0}, {0, 0, 0}, {0, 0, 1}, 32, 24, 30);
  camera.name = "a";
  write_transforms(folder / "transforms.json", {camera});
  testing::internal::CaptureStderr();
  const int code = run_pliant({"render", scene.string(), "--out", (folder / "images").string()});
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_EQ(code, 0) << said;
  EXPECT_NE(said.find("was written by nerfstudio"), std::string::npos) << said;
}

}  // namespace
}  // namespace pliant

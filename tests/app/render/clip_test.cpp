// `render` of a run: frames without what a codec loses, any size, camera paths, layers, turntables, animated images.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "app/simulate/clip_camera.h"
#include "app/store/trajectory.h"
#include "gaussians/base/camera.h"
#include "gaussians/base/orbit.h"
#include "gaussians/io/cameras/transforms.h"
#include "gaussians/io/files/json_file.h"
#include "gaussians/io/images/codecs.h"
#include "gaussians/io/images/image_io.h"
#include "gaussians/io/splats/ply.h"
#include "tests/app/beam_scene.h"
#include "tests/app/run_pliant.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

namespace fs = std::filesystem;
using namespace fixture;
using nlohmann::json;

/// A beam that swings for 0.2 s at 20 frames per second.
class Clip : public ::testing::Test {
 protected:
  void SetUp() override {
    make_beam_scene(folder_ / "scene");
    const std::string scene = (folder_ / "scene").string(), run = (folder_ / "run").string();
    for (const std::vector<std::string>& words : std::vector<std::vector<std::string>>{
             {"segment", scene, "--out", run, "--aabb", "-0.1,-0.1,0.9,0.9,0.3,1.3", "--orbit-views", "6"},
             {"extract", run, "--object", "object"},
             {"repair", run},
             {"seed", run, "--particles", "300", "--no-pin-contact"},
             {"simulate", run, "--young", "50000", "--fps", "20", "--duration", "0.2"}})
      ASSERT_EQ(run_quietly(words), 0) << words[0];
  }
  fs::path run() const { return folder_ / "run"; }
  int render(std::vector<std::string> words) const {
    words.insert(words.begin(), {"render", run().string()});
    return run_quietly(words);
  }
  std::unique_ptr<cv::VideoCapture> clip(const char* name) const { return codecs::open_video((run() / name).string()); }
  static int count_files(const fs::path& path) {
    return static_cast<int>(std::distance(fs::directory_iterator(path), fs::directory_iterator()));
  }

  const TemporaryFolder folder_;
};

TEST(ClipCamera, ShowsASingleGaussian) {
  constexpr double kSize = 0.1;
  GaussianCloud cloud;
  cloud.resize(1);
  cloud.log_scale[0] = Vec3f::Constant(std::log(kSize));
  Scene scene;
  scene.up = Vec3d::UnitZ();
  scene.cameras = orbit_cameras({}, cloud, scene.up);
  scene.cameras_are_orbit = true;
  const Camera camera = clip_camera(scene, "", robust_bounds(cloud));
  const double seen = camera.fy * kSize / camera.centre().norm();
  EXPECT_GT(seen, 0.03 * camera.height);
  EXPECT_LT(seen, 0.5 * camera.height);
  Box point;
  point.add(Vec3f::Zero());
  EXPECT_TRUE(std::isfinite(clip_camera(scene, "", point).fx));
}

TEST_F(Clip, FramesAreThoseOfTheClip) {
  ASSERT_EQ(render({"--no-orbit"}), 0);
  EXPECT_FALSE(fs::exists(run() / "clip"));
  // A killed run left some.
  fs::create_directories(run() / "clip.partial");
  write_text(run() / "clip.partial/000099.png", "rubbish");
  ASSERT_EQ(render({"--no-orbit", "--frames"}), 0);
  EXPECT_FALSE(fs::exists(run() / "clip.partial"));

  const auto video = clip("clip.mp4");
  cv::Mat decoded;
  int frames = 0;
  double square = 0;
  for (; video->read(decoded); ++frames) {
    const ImageF frame = read_image(run() / "clip" / fmt::format("{:06d}.png", frames));
    ASSERT_EQ(frame.width, decoded.cols);
    ASSERT_EQ(frame.height, decoded.rows);
    double sum = 0;
    for (int y = 0; y < frame.height; ++y)
      for (int x = 0; x < frame.width; ++x)
        for (int c = 0; c < 3; ++c) sum += std::pow(frame(x, y, c) - decoded.at<cv::Vec3b>(y, x)[2 - c] / 255.0, 2);
    square = std::max(square, sum / (3.0 * frame.width * frame.height));
  }
  EXPECT_EQ(frames, 5);
  EXPECT_EQ(count_files(run() / "clip"), frames);
  EXPECT_GT(-10 * std::log10(square), 30);
}

TEST_F(Clip, IsBeforeTheBackgroundOfItsScene) {
  json scene = read_json(folder_ / "scene/scene.json");
  scene["background"] = {1, 0.5, 0};
  write_json(folder_ / "scene/scene.json", scene);
  ASSERT_EQ(render({"--no-orbit", "--frames", "--size", "96x64"}), 0);
  const ImageF frame = read_image(run() / "clip/000003.png");
  int empty = 0;
  for (int y = 0; y < frame.height; ++y)
    for (int x = 0; x < frame.width; ++x)
      empty += std::abs(frame(x, y, 0) - 1) + std::abs(frame(x, y, 1) - 0.5) + frame(x, y, 2) < 0.02;
  EXPECT_GT(empty, frame.width * frame.height / 20);
}

TEST_F(Clip, SizeAndFrameRateAreThoseAskedFor) {
  ASSERT_EQ(render({"--size", "320x140", "--clip-fps", "50", "--turntable", "--gif", "--webp"}), 0);
  for (const char* name : {"clip.mp4", "clip_orbit.mp4"}) {
    const auto video = clip(name);
    EXPECT_EQ(video->get(cv::CAP_PROP_FRAME_WIDTH), 320) << name;
    EXPECT_EQ(video->get(cv::CAP_PROP_FRAME_HEIGHT), 140) << name;
    EXPECT_NEAR(video->get(cv::CAP_PROP_FPS), 50, 1e-6) << name;
    EXPECT_EQ(video->get(cv::CAP_PROP_FRAME_COUNT), 11) << name;  // 0 to 0.2 s
  }
  EXPECT_GT(fs::file_size(run() / "clip.gif"), 1000u);
  EXPECT_GT(fs::file_size(run() / "clip.webp"), 300u);
  EXPECT_EQ(read_image(run() / "clip_frames.png").width, 4 * 320);
  for (const char* size : {"320", "320x", "0x140", "320x140x3", "99999x10", "wide"})
    EXPECT_EQ(render({"--size", size}), 2) << size;
  EXPECT_EQ(render({"--turntable", "--no-orbit"}), 2);
}

TEST_F(Clip, TheMomentsOfALargeClipAreReduced) {
  ASSERT_EQ(render({"--size", "1000x200", "--no-orbit"}), 0);
  const ImageF sheet = read_image(run() / "clip_frames.png");
  EXPECT_EQ(sheet.width, 4 * 640);
  EXPECT_EQ(sheet.height, 2 * 128);
}

TEST_F(Clip, ACameraPathMovesTheCameraAndOutlastsTheMotion) {
  // From twice the distance to the beam's middle, seen level along y, in 0.3 s; OpenGL axes.
  const auto pose = [](double y) { return json{1, 0, 0, 0.4, 0, 0, -1, y, 0, 1, 0, 1.08, 0, 0, 0, 1}; };
  const json path = {{"render_width", 160},
                     {"render_height", 120},
                     {"fps", 10},
                     {"camera_path",
                      {{{"camera_to_world", pose(-4)}, {"fov", 40}},
                       {{"camera_to_world", pose(-3.33)}, {"fov", 40}},
                       {{"camera_to_world", pose(-2.67)}, {"fov", 40}},
                       {{"camera_to_world", pose(-2)}, {"fov", 40}}}}};
  const std::string file = folder_.file("camera_path.json", path.dump()).string();
  ASSERT_EQ(render({"--no-orbit", "--cameras", file, "--clip-fps", "20", "--object-layer"}), 0);
  const json layer = read_json(run() / "clip_object/layer.json");
  EXPECT_EQ(layer["fps"], 20);
  ASSERT_EQ(layer["frames"].size(), 7u);
  EXPECT_EQ(count_files(run() / "clip_object/color"), 7);
  EXPECT_EQ(clip("clip_object.webm")->get(cv::CAP_PROP_FRAME_WIDTH), 160);
  const auto covered = [&](int k) {
    const cv::Mat color = codecs::imread((run() / fmt::format("clip_object/color/{:06d}.png", k)).string(), -1);
    EXPECT_EQ(color.channels(), 4);
    cv::Mat alpha;
    cv::extractChannel(color, alpha, 3);
    return cv::countNonZero(alpha > 127);
  };
  // Half as far away it covers four times as much.
  EXPECT_NEAR(covered(6), 4.0 * covered(0), 0.25 * 4 * covered(0));
  EXPECT_EQ(render({"--cameras", file, "--camera", "0"}), 2);
  EXPECT_EQ(render({"--cameras", (folder_ / "absent.json").string()}), 1);
}

TEST_F(Clip, TheLayersDepthIsTheDistanceInMetres) {
  ASSERT_EQ(render({"--no-orbit", "--object-layer", "--size", "200x150"}), 0);
  const json layer = read_json(run() / "clip_object/layer.json");
  const TrajectoryFile motion = read_trajectory(run() / "objects/1_object/trajectory.h5");
  for (const size_t k : {0u, 4u}) {
    const json& shot = layer["frames"][k];
    Eigen::Matrix<double, 4, 4, Eigen::RowMajor> cam_from_world;
    for (int i = 0; i < 16; ++i) cam_from_world.data()[i] = shot["cam_from_world"][i];
    double nearest = 1e9, farthest = 0;  // of the driving particles along the axis, metres
    for (const Vec3f& x : motion.frames[k].position) {
      const double depth = kBeamUnit * (cam_from_world * x.cast<double>().homogeneous()).z();
      nearest = std::min(nearest, depth);
      farthest = std::max(farthest, depth);
    }
    const cv::Mat depth = codecs::imread((run() / fmt::format("clip_object/depth/{:06d}.png", k)).string(), -1);
    const cv::Mat color = codecs::imread((run() / fmt::format("clip_object/color/{:06d}.png", k)).string(), -1);
    ASSERT_EQ(depth.type(), CV_16UC1);
    ASSERT_EQ(depth.cols, 200);
    int solid = 0;
    for (int y = 0; y < depth.rows; ++y)
      for (int x = 0; x < depth.cols; ++x) {
        const int alpha = color.at<cv::Vec4b>(y, x)[3];
        if (alpha == 0) {
          EXPECT_EQ(depth.at<uint16_t>(y, x), 0);
        }
        if (alpha < 250) continue;
        ++solid;
        const double metres = depth.at<uint16_t>(y, x) * layer["metres_per_depth_step"].get<double>();
        EXPECT_GT(metres, nearest - 0.03);
        EXPECT_LT(metres, farthest + 0.03);
      }
    EXPECT_GT(solid, 300);
  }
}

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
  folder.file("images/pictures.json", R"({"pictures": ["../outside.png", "/outside.png", 3, "orbit_002.png"]})");
  EXPECT_EQ(render("4", {}), second);
  EXPECT_TRUE(fs::exists(folder / "outside.png"));
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

}  // namespace
}  // namespace pliant

// `render` of a run: frames without what a codec loses, any size, camera paths, layers, turntables, animated images.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "app/render/object_layer.h"
#include "app/simulate/clip_camera.h"
#include "app/store/trajectory.h"
#include "gaussians/base/camera.h"
#include "gaussians/base/orbit.h"
#include "gaussians/io/files/json_file.h"
#include "gaussians/io/images/codecs.h"
#include "gaussians/io/images/image_io.h"
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

TEST_F(Clip, AllItsFilesAreOfOneEvenSize) {
  ASSERT_EQ(render({"--no-orbit", "--frames", "--object-layer", "--size", "97x65"}), 0);
  const json layer = read_json(run() / "clip_object/layer.json");
  EXPECT_EQ(layer["width"], 96);
  EXPECT_EQ(layer["height"], 64);
  for (const char* name : {"clip.mp4", "clip_object.webm"}) {
    EXPECT_EQ(clip(name)->get(cv::CAP_PROP_FRAME_WIDTH), 96) << name;
    EXPECT_EQ(clip(name)->get(cv::CAP_PROP_FRAME_HEIGHT), 64) << name;
  }
  for (const char* name : {"clip/000000.png", "clip_object/color/000000.png"}) {
    const cv::Mat picture = codecs::imread((run() / name).string(), -1);
    EXPECT_EQ(picture.cols, 96) << name;
    EXPECT_EQ(picture.rows, 64) << name;
  }
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

TEST_F(Clip, TheCamerasOfImagesOfASceneAreNoPathOfAClip) {
  for (const char* word : {"orbit", "scene"}) {
    ::testing::internal::CaptureStderr();
    EXPECT_EQ(render({"--cameras", word}), 2);
    const std::string said = ::testing::internal::GetCapturedStderr();
    for (const char* part : {"--cameras", word, "--turntable"}) EXPECT_NE(said.find(part), std::string::npos) << said;
  }
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

// A ball that rolls away, farther than it is large.
TEST(ObjectLayer, TheDepthReachesAsFarAsTheObjectGoes) {
  constexpr double kMetresPerUnit = 0.5;
  const TemporaryFolder folder;
  GaussianCloud ball;
  ball.resize(1);
  ball.log_scale[0] = Vec3f::Constant(std::log(0.05f));
  ball.opacity_logit[0] = 5;
  Box box;
  box.add(Vec3f::Constant(-0.1f));
  box.add(Vec3f::Constant(0.1f));
  TrajectoryFile motion;
  motion.fps = 10;
  for (const int k : {0, 1}) {
    const Vec3f place(0, 5.0f * static_cast<float>(k), 0);
    motion.frames.push_back({k / motion.fps, k, {place}, {Vec3f(0, 0, 0)}, {Mat3f(Mat3f::Identity())}});
  }
  const Camera camera = look_at({0, -2, 0}, {0, 0, 0}, {0, 0, 1}, 64, 48, 60);
  const Shot shot{motion.fps, {0, 1 / motion.fps}, {camera, camera}};
  ObjectLayer layer(folder / "layer", folder / "layer.webm", shot, farthest_depth(shot, motion, box), kMetresPerUnit);
  for (size_t k = 0; k < 2; ++k) {
    ball.position = motion.frames[k].position;
    layer.write(k, ball, {});
  }
  layer.close();
  const double step = read_json(folder / "layer/layer.json")["metres_per_depth_step"];
  for (const int k : {0, 1}) {
    const cv::Mat depth = codecs::imread((folder / fmt::format("layer/depth/{:06d}.png", k)).string(), -1);
    double farthest = 0;
    cv::minMaxLoc(depth, nullptr, &farthest);
    EXPECT_NEAR(farthest * step, kMetresPerUnit * (2 + 5 * k), 0.01) << k;
  }
}

}  // namespace
}  // namespace pliant

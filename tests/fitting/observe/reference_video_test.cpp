// Reference videos: the wanted instants at the wanted size, and files that are no video are said to be none.

#include "fitting/observe/reference_video.h"

#include <cmath>
#include <cstdlib>

#include "gaussians/base/lens.h"
#include "gaussians/io/images/image_io.h"
#include "gaussians/io/images/video.h"
#include "gaussians/reconstruct/undistort.h"
#include "gaussians/render/image_loss.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

Camera video_camera_of(int width, int height) {
  Camera camera;
  camera.name = "view_a";
  camera.width = width;
  camera.height = height;
  return camera;
}

/// Grey that tells the instant: 0.1 at 0 s, rising 0.3 a second.
float grey_at(double time) { return static_cast<float>(0.1 + 0.3 * time); }

std::filesystem::path video_of(const TemporaryFolder& folder, int frames, double fps, int width = 64, int height = 48) {
  VideoWriter video(folder / "clip.mp4", fps, width, height);
  for (int f = 0; f < frames; ++f) video.write(ImageF(width, height, 3, grey_at(f / fps)));
  video.close();
  return folder / "clip.mp4";
}

double mean(const ImageF& picture) {
  double sum = 0;
  for (const float v : picture.data) sum += v;
  return sum / static_cast<double>(picture.data.size());
}

TEST(ReferenceVideo, FramesOfAFileAreTakenAsTheyAre) {
  const TemporaryFolder folder;
  const ReferenceVideo video = load_reference_video({}, video_of(folder, 48, 24), video_camera_of(64, 48));
  ASSERT_EQ(video.frames.size(), 48u);
  EXPECT_DOUBLE_EQ(video.fps, 24);
  EXPECT_EQ(video.blended, 0);
  EXPECT_TRUE(video.warnings.empty());
  for (int f = 0; f < 48; ++f) EXPECT_NEAR(mean(video.frames[f]), grey_at(f / 24.0), 0.006) << f;
}

TEST(ReferenceVideo, FaithfulCodingKeepsColourAsFineAsLight) {
  const TemporaryFolder folder;
  ImageF stripes(64, 48, 3, 0.2f);
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 64; ++x) stripes(x, y, (x + y) % 3 == 0 ? 0 : 1) = 0.7f;
  const auto psnr = [&](VideoCoding coding) {
    VideoWriter video(folder / "clip.mp4", 24, 64, 48, coding);
    for (int f = 0; f < 8; ++f) video.write(stripes);
    video.close();
    const ReferenceVideo read = load_reference_video({}, folder / "clip.mp4", video_camera_of(64, 48));
    return psnr_of_mse(mse_loss(read.frames[4], stripes));
  };
  EXPECT_LT(psnr(VideoCoding::kForBrowsers), 25);
  EXPECT_GT(psnr(VideoCoding::kFaithful), 36);
}

TEST(ReferenceVideo, LinearResamplingKeepsInstantsAndNearestStaysWithinHalfAFrame) {
  const TemporaryFolder folder;
  const auto file = video_of(folder, 31, 10);
  VideoOptions options;
  options.fps = 24;
  const ReferenceVideo linear = load_reference_video(options, file, video_camera_of(64, 48));
  ASSERT_EQ(linear.frames.size(), 73u);
  EXPECT_GT(linear.blended, 40);
  EXPECT_EQ(linear.warnings.size(), 1u);
  for (int f = 0; f < 73; ++f) EXPECT_NEAR(mean(linear.frames[f]), grey_at(f / 24.0), 0.006) << f;
  options.resampling = Resampling::kNearest;
  const ReferenceVideo nearest = load_reference_video(options, file, video_camera_of(64, 48));
  EXPECT_EQ(nearest.blended, 0);
  for (int f = 0; f < 73; ++f) EXPECT_NEAR(mean(nearest.frames[f]), grey_at(f / 24.0), 0.006 + 0.3 * 0.05) << f;
}

TEST(ReferenceVideo, TrimmingStartsAtAWholeFrameAndEndsInTime) {
  const TemporaryFolder folder;
  VideoOptions options;
  options.first = 0.52;
  options.last = 1.5;
  const ReferenceVideo video = load_reference_video(options, video_of(folder, 48, 24), video_camera_of(64, 48));
  EXPECT_NEAR(video.start, 12 / 24.0, 1e-6);
  ASSERT_EQ(video.frames.size(), 25u);
  EXPECT_EQ(video.blended, 0);
  for (size_t f = 0; f < 25; ++f) EXPECT_NEAR(mean(video.frames[f]), grey_at((12.0 + f) / 24), 0.006);
  options.first = 1.9;
  options.last = 9;
  EXPECT_EQ(load_reference_video(options, folder / "clip.mp4", video_camera_of(64, 48)).warnings.size(), 1u);
}

TEST(ReferenceVideo, AnExactStartLiesBetweenTwoFrames) {
  const TemporaryFolder folder;
  VideoOptions options;
  options.first = 0.52;
  options.exact_start = true;
  const ReferenceVideo video = load_reference_video(options, video_of(folder, 48, 24), video_camera_of(64, 48));
  EXPECT_EQ(video.start, 0.52);
  ASSERT_EQ(video.frames.size(), 35u);  // the last frame is at 47 / 24 s
  EXPECT_EQ(video.blended, 35);
  for (size_t f = 0; f < 35; ++f) EXPECT_NEAR(mean(video.frames[f]), grey_at(0.52 + f / 24.0), 0.006) << f;
}

TEST(ReferenceVideo, TheLensOfItsCameraIsRemovedAsFromItsPhoto) {
  const TemporaryFolder folder;
  Camera lens = video_camera_of(160, 120);
  lens.fx = lens.fy = 140;
  lens.cx = 82;
  lens.cy = 59;
  lens.distortion = {0.3, 0, 0, 0, 0, 0};
  const Camera pinhole = make_undistortion(lens).pinhole;
  ASSERT_LT(pinhole.width, 159);
  const auto pattern = [](const Eigen::Vector2d& x) {
    return static_cast<float>(0.5 + 0.4 * std::sin(9 * x.x()) * std::cos(7 * x.y()));
  };
  const auto picture_by = [&](const Camera& camera) {
    ImageF picture(camera.width, camera.height, 3);
    for (int y = 0; y < camera.height; ++y)
      for (int x = 0; x < camera.width; ++x)
        std::fill_n(picture.at(x, y), 3, pattern(unproject(camera, {x + 0.5, y + 0.5}).value()));
    return picture;
  };
  const ImageF expected = picture_by(pinhole);
  const auto error = [&](const ReferenceVideo& video) { return std::sqrt(mse_loss(video.frames[1], expected)); };
  VideoOptions options;
  options.declared_fps = 12;
  for (const char* name : {"filmed", "rendered"}) std::filesystem::create_directory(folder / name);
  for (int f = 0; f < 2; ++f) {
    write_image(folder / ("filmed/" + std::to_string(f) + ".png"), picture_by(lens.scaled(2)));
    write_image(folder / ("rendered/" + std::to_string(f) + ".png"), expected);
  }
  EXPECT_GT(error(load_reference_video(options, folder / "filmed", pinhole)), 0.02);
  options.lens = lens;
  const ReferenceVideo filmed = load_reference_video(options, folder / "filmed", pinhole);
  EXPECT_LT(error(filmed), 0.005);
  EXPECT_TRUE(filmed.lens);
  EXPECT_EQ(filmed.camera.width, pinhole.width);
  // What the scene's own camera drew has no lens.
  const ReferenceVideo rendered = load_reference_video(options, folder / "rendered", pinhole);
  EXPECT_LT(error(rendered), 0.005);
  EXPECT_FALSE(rendered.lens);
}

TEST(ReferenceVideo, AFolderIsReadInTheOrderOfItsNumbers) {
  const TemporaryFolder folder;
  for (const int f : {7, 8, 9, 10, 11, 12})
    write_image(folder / ("frame_" + std::to_string(f) + ".png"), ImageF(40, 30, 3, 0.02f * f));
  VideoOptions options;
  options.declared_fps = 12;
  const ReferenceVideo video = load_reference_video(options, folder.path(), video_camera_of(40, 30));
  ASSERT_EQ(video.frames.size(), 6u);
  EXPECT_DOUBLE_EQ(video.fps, 12);
  for (size_t f = 1; f < 6; ++f) EXPECT_GT(mean(video.frames[f]), mean(video.frames[f - 1]));
  options.declared_fps = 0;
  expect_error(Failure::kInput, {folder.path().string(), "fps", "no frame rate"},
               [&] { load_reference_video(options, folder.path(), video_camera_of(40, 30)); });
}

TEST(ReferenceVideo, MissingNumbersOfAFolderLeaveTheOthersInTheirPlace) {
  const TemporaryFolder folder;
  for (const int f : {1, 2, 3, 4, 7, 8, 9, 10})
    write_image(folder / ("f_" + std::to_string(f) + ".png"), ImageF(40, 30, 3, grey_at((f - 1) / 12.0)));
  VideoOptions options;
  options.declared_fps = 12;
  const ReferenceVideo video = load_reference_video(options, folder.path(), video_camera_of(40, 30));
  ASSERT_EQ(video.frames.size(), 10u);
  for (int f = 0; f < 10; ++f) EXPECT_NEAR(mean(video.frames[f]), grey_at(f / 12.0), 0.006) << f;
  EXPECT_EQ(video.blended, 2);
  ASSERT_EQ(video.warnings.size(), 2u);
  EXPECT_NE(video.warnings[0].find("5 to 6"), std::string::npos) << video.warnings[0];
  // Masks of its frames have their instants, whatever they are called.
  std::filesystem::create_directory(folder / "masks");
  for (int f = 0; f < 8; ++f)
    write_image(folder / ("masks/" + std::to_string(f) + ".png"), ImageF(40, 30, 3, 0.1f * f));
  options.instants = video.instants;
  options.resampling = Resampling::kNearest;
  const ReferenceVideo masks = load_reference_video(options, folder / "masks", video_camera_of(40, 30));
  ASSERT_EQ(masks.frames.size(), 10u);
  EXPECT_TRUE(masks.warnings.empty());
  EXPECT_NEAR(mean(masks.frames[9]), 0.7, 0.006);
  EXPECT_NEAR(mean(masks.frames[6]), 0.4, 0.006);
}

TEST(ReferenceVideo, OnlyAMissingFrameIsABlend) {
  const TemporaryFolder folder;
  const std::string from = video_of(folder, 72, 24).string(), to = (folder / "dropped.mp4").string();
  ASSERT_EQ(std::system(("ffmpeg -v error -i " + from + " -vf \"select=not(eq(n\\,40))\" -vsync vfr " + to).c_str()),
            0);
  const ReferenceVideo video = load_reference_video({}, to, video_camera_of(64, 48));
  EXPECT_DOUBLE_EQ(video.fps, 24);
  ASSERT_EQ(video.frames.size(), 72u);
  EXPECT_EQ(video.blended, 1);
  for (int f = 0; f < 72; ++f) EXPECT_NEAR(mean(video.frames[f]), grey_at(f / 24.0), 0.008) << f;
  ASSERT_EQ(video.warnings.size(), 2u);
  EXPECT_NE(video.warnings[1].find("1 of 72 frames are blends of two, since the video has no frame"), std::string::npos)
      << video.warnings[1];
}

TEST(ReferenceVideo, RoundedTimeStampsMakeNoBlends) {
  const TemporaryFolder folder;
  struct Case {
    double fps;
    const char* file;
  };
  for (const Case& c : {Case{120, "clip.mkv"}, Case{24, "clip.gif"}}) {
    const std::string from = video_of(folder, 72, c.fps).string(), to = (folder / c.file).string();
    ASSERT_EQ(std::system(("ffmpeg -v error -i " + from + " " + to).c_str()), 0);
    const ReferenceVideo video = load_reference_video({}, to, video_camera_of(64, 48));
    EXPECT_NEAR(video.fps, c.fps, 0.01 * c.fps);
    EXPECT_EQ(video.frames.size(), 72u) << c.file;
    EXPECT_EQ(video.blended, 0) << c.file;
    EXPECT_TRUE(video.warnings.empty()) << c.file << ": " << video.warnings[0];
  }
}

TEST(ReferenceVideo, FramesAreScaledToTheCameraWhosePixelsKeepTheirPlace) {
  const TemporaryFolder folder;
  for (int f = 0; f < 2; ++f) {
    ImageF ramp(80, 60, 3);
    for (int y = 0; y < 60; ++y)
      for (int x = 0; x < 80; ++x) {
        ramp(x, y, 0) = (x + 0.5f) / 80;
        ramp(x, y, 1) = (y + 0.5f) / 60;
      }
    write_image(folder / (std::to_string(f) + ".png"), ramp);
  }
  VideoOptions options;
  options.declared_fps = 24;
  for (const int width : {40, 120}) {
    const ReferenceVideo video = load_reference_video(options, folder.path(), video_camera_of(width, width * 3 / 4));
    const ImageF& picture = video.frames[1];
    ASSERT_EQ(picture.width, width);
    for (int x = 3; x < width - 3; ++x) {
      EXPECT_NEAR(picture(x, 10, 0), (x + 0.5) / width, 0.004);
      EXPECT_NEAR(picture(10, x / 2, 1), (x / 2 + 0.5) / picture.height, 0.004);
    }
  }
}

TEST(ReferenceVideo, ARateThatDisagreesIsSaidAndFollowedOnlyWhenTrusted) {
  const TemporaryFolder folder;
  const auto file = video_of(folder, 24, 24);
  VideoOptions options;
  options.declared_fps = 48;
  const ReferenceVideo video = load_reference_video(options, file, video_camera_of(64, 48));
  EXPECT_DOUBLE_EQ(video.fps, 24);
  ASSERT_EQ(video.warnings.size(), 1u);
  for (const char* word : {"24", "48", "4 times"})
    EXPECT_NE(video.warnings[0].find(word), std::string::npos) << video.warnings[0];
  options.trust_declared = true;
  const ReferenceVideo slow = load_reference_video(options, file, video_camera_of(64, 48));
  EXPECT_DOUBLE_EQ(slow.fps, 48);
  EXPECT_EQ(slow.frames.size(), 24u);
  EXPECT_EQ(slow.blended, 0);
}

TEST(ReferenceVideo, WhatIsNoUsableVideoIsNamed) {
  const TemporaryFolder folder;
  const auto load = [&](const std::filesystem::path& file, const VideoOptions& options = {}) {
    return load_reference_video(options, file, video_camera_of(64, 48));
  };
  expect_error(Failure::kInput, {"absent.mp4", "does not exist"}, [&] { load(folder / "absent.mp4"); });
  expect_error(Failure::kInput, {"text.mp4", "not a video"},
               [&] { load(folder.file("text.mp4", "this is no video")); });
  expect_error(Failure::kInput, {"empty.mp4", "not a video"}, [&] { load(folder.file("empty.mp4", "")); });
  VideoOptions rate;
  rate.declared_fps = 24;
  std::filesystem::create_directory(folder / "none");
  expect_error(Failure::kInput, {"none", "no images"}, [&] { load(folder / "none", rate); });
  std::filesystem::create_directory(folder / "one");
  write_image(folder / "one/0.png", ImageF(64, 48, 3));
  expect_error(Failure::kInput, {"one", "single frame"}, [&] { load(folder / "one", rate); });
  write_image(folder / "one/1.png", ImageF(32, 48, 3));
  expect_error(Failure::kInput, {"1.png", "32 x 48", "64 x 48"}, [&] { load(folder / "one", rate); });
  rate.declared_fps = 1e6;
  expect_error(Failure::kUsage, {"fps", "1000000"}, [&] { load(folder / "one", rate); });

  const auto file = video_of(folder, 12, 24);
  expect_error(Failure::kInput, {"64 x 48", "view_a", "64 x 64"},
               [&] { load_reference_video({}, file, video_camera_of(64, 64)); });
  VideoOptions late;
  late.first = 5;
  expect_error(Failure::kInput, {"clip.mp4", "0 frames", "from 5 s"}, [&] { load(file, late); });
  late.last = 4;
  expect_error(Failure::kUsage, {"last"}, [&] { load(file, late); });
  VideoOptions small;
  small.most_bytes = 1e5;
  expect_error(Failure::kInput, {"memory", "64 x 48"}, [&] { load(file, small); });
  std::filesystem::resize_file(file, std::filesystem::file_size(file) / 2);
  EXPECT_TRUE([&] {
    try {
      return !load(file).warnings.empty();
    } catch (const Error&) {
      return true;
    }
  }());
}

}  // namespace
}  // namespace pliant

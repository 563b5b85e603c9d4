// Videos: equal frames give equal files, whole or absent, and a failed encoder is an error.

#include "gaussians/io/images/video.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "gaussians/io/files/files.h"
#include "gaussians/io/images/codecs.h"
#include "gaussians/io/images/image_io.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

ImageF frame(int f) {
  ImageF picture(64, 48, 3);
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 64; ++x)
      for (int c = 0; c < 3; ++c) picture(x, y, c) = 0.5f + 0.5f * std::sin(0.3f * (x + f) + 0.2f * y * (c + 1));
  return picture;
}

int run_ffmpeg(const std::string& words) { return std::system(("ffmpeg -v error " + words).c_str()); }

TEST(Video, EqualFramesGiveEqualFilesAndNothingAppearsBeforeTheEnd) {
  const TemporaryFolder folder;
  for (const char* name : {"a.mp4", "b.mp4"}) {
    VideoWriter video(folder.path() / name, 24, 64, 48);
    for (int f = 0; f < 20; ++f) video.write(frame(f));
    EXPECT_FALSE(std::filesystem::exists(folder.path() / name));
    video.close();
  }
  EXPECT_EQ(sha256_of_file(folder.path() / "a.mp4"), sha256_of_file(folder.path() / "b.mp4"));
  EXPECT_GT(std::filesystem::file_size(folder.path() / "a.mp4"), 1000u);
}

TEST(Video, AnAbandonedVideoLeavesNothingBehind) {
  const TemporaryFolder folder;
  { VideoWriter(folder.path() / "a.mp4", 24, 64, 48).write(frame(0)); }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(Video, AnimatedImagesAreMadeOfAVideoOrNot) {
  const TemporaryFolder folder;
  VideoWriter video(folder / "a.mp4", 24, 64, 48);
  for (int f = 0; f < 12; ++f) video.write(frame(f));
  video.close();
  for (const char* name : {"a.gif", "a.webp"}) {
    convert_video(folder / "a.mp4", folder / name);
    const std::string bytes = read_text(folder / name);
    EXPECT_NE(bytes.find(name == std::string("a.gif") ? "NETSCAPE2.0" : "ANMF"), std::string::npos) << name;
  }
  std::filesystem::create_directories(folder / "frames");
  ASSERT_EQ(
      run_ffmpeg("-i " + (folder / "a.gif").string() + " -vsync passthrough " + (folder / "frames/%d.png").string()),
      0);
  EXPECT_TRUE(std::filesystem::exists(folder / "frames/12.png"));
  EXPECT_FALSE(std::filesystem::exists(folder / "frames/13.png"));
  EXPECT_EQ(read_image(folder / "frames/1.png").width, 64);
  EXPECT_THROW(convert_video(folder / "absent.mp4", folder / "b.gif"), Error);
  EXPECT_FALSE(std::filesystem::exists(folder / "b.gif"));
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), std::filesystem::directory_iterator()),
            4);
}

TEST(Video, AlphaIsKept) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder / "a.webm";
  VideoWriter video(file, 24, 64, 48, VideoCoding::kWithAlpha);
  ImageF picture(64, 48, 4);
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 64; ++x) {
      picture(x, y, 0) = 1;
      picture(x, y, 3) = x < 32 ? 0.0f : 1.0f;
    }
  for (int f = 0; f < 3; ++f) video.write(picture);
  video.close();
  // The decoder of ffmpeg that knows the second layer is libvpx's.
  const std::string png = (folder / "frame.png").string();
  ASSERT_EQ(run_ffmpeg("-c:v libvpx-vp9 -i " + file.string() + " -frames:v 1 " + png), 0);
  const cv::Mat decoded = codecs::imread(png, cv::IMREAD_UNCHANGED);
  ASSERT_EQ(decoded.channels(), 4);
  EXPECT_LT(decoded.at<cv::Vec4b>(24, 10)[3], 8);
  EXPECT_GT(decoded.at<cv::Vec4b>(24, 54)[3], 247);
  EXPECT_GT(decoded.at<cv::Vec4b>(24, 54)[2], 240);
}

TEST(Video, PlayersShowTheColorsThatWereWrittenAlsoInHd) {
  const TemporaryFolder folder;
  const float color[] = {200 / 255.f, 80 / 255.f, 40 / 255.f, 1};
  struct Case {
    const char *file, *decoder;
    VideoCoding coding;
  };
  for (const Case& c : {Case{"a.mp4", "", VideoCoding::kForBrowsers}, Case{"b.mp4", "", VideoCoding::kFaithful},
                        Case{"c.webm", "-c:v libvpx-vp9", VideoCoding::kWithAlpha}}) {
    SCOPED_TRACE(c.file);
    const std::string file = (folder / c.file).string(), png = (folder / "frame.png").string(),
                      tags = (folder / "tags.txt").string();
    ImageF picture(1280, 720, c.coding == VideoCoding::kWithAlpha ? 4 : 3);
    for (size_t i = 0; i < picture.data.size(); ++i) picture.data[i] = color[i % picture.channels];
    VideoWriter video(file, 24, 1280, 720, c.coding);
    video.write(picture);
    video.close();
    // Its tags are what players follow, among them ffmpeg where it is told nothing else.
    ASSERT_EQ(std::system(("ffprobe -v error -select_streams v:0 -show_entries stream=color_space,color_range,"
                           "color_transfer,color_primaries -of default=noprint_wrappers=1 " +
                           file + " > " + tags)
                              .c_str()),
              0);
    const std::string said = read_text(tags);
    for (const char* tag :
         {"color_space=smpte170m", "color_range=tv", "color_transfer=iec61966-2-1", "color_primaries=bt709"})
      EXPECT_NE(said.find(tag), std::string::npos) << tag << " in " << said;
    ASSERT_EQ(run_ffmpeg(std::string("-y ") + c.decoder + " -i " + file + " -frames:v 1 -pix_fmt rgb24 " + png), 0);
    const ImageF shown = read_image(png);
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(shown(640, 360, k), color[k], 2.5f / 255);
  }
}

TEST(Video, AFrameNeedsTwoPixelsEitherWay) {
  const TemporaryFolder folder;
  for (const auto& [width, height] : {std::pair(1, 48), std::pair(64, 1)})
    expect_error(Failure::kUsage, {"a.mp4", std::to_string(width) + " x " + std::to_string(height), "2 x 2"},
                 [&] { VideoWriter(folder / "a.mp4", 24, width, height); });
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(WriteImage, ColoursAndAlphaStayInTheirChannelsAndDepthKeeps16Bits) {
  const TemporaryFolder folder;
  ImageF color(3, 2, 4), depth(3, 2, 1);
  for (size_t i = 0; i < color.data.size(); ++i) color.data[i] = static_cast<float>(i) / 255;
  for (size_t i = 0; i < depth.data.size(); ++i) depth.data[i] = static_cast<float>(i + 257) / 65535;
  write_image(folder / "color.png", color);
  write_grey_16(folder / "depth.png", depth);
  const cv::Mat read = codecs::imread((folder / "color.png").string(), cv::IMREAD_UNCHANGED);
  const cv::Mat deep = codecs::imread((folder / "depth.png").string(), cv::IMREAD_UNCHANGED);
  ASSERT_EQ(read.type(), CV_8UC4);
  ASSERT_EQ(deep.type(), CV_16UC1);
  for (int y = 0; y < 2; ++y)
    for (int x = 0; x < 3; ++x) {
      const int first = 4 * (3 * y + x);
      EXPECT_EQ(read.at<cv::Vec4b>(y, x), cv::Vec4b(first + 2, first + 1, first, first + 3));
      EXPECT_EQ(deep.at<uint16_t>(y, x), 3 * y + x + 257);
    }
}

TEST(Video, AFolderThatDoesNotExistIsAnError) {
  const TemporaryFolder folder;
  EXPECT_THROW(
      {
        VideoWriter video(folder.path() / "absent" / "a.mp4", 24, 64, 48);
        for (int f = 0; f < 20; ++f) video.write(frame(f));
        video.close();
      },
      Error);
}

}  // namespace
}  // namespace pliant

// Frames of video files: the colors that the file means, whatever matrix and range it is coded in.

#include "fitting/observe/frame_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "gaussians/io/images/image_io.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

constexpr std::array<std::array<int, 3>, 4> kPatches = {{{200, 80, 40}, {40, 120, 200}, {128, 128, 128}, {20, 25, 40}}};

/// Patches side by side, encoded with a matrix and range, with the words that tell ffmpeg to tag them.
std::filesystem::path coded_video(const TemporaryFolder& folder, const std::string& name, const std::string& size,
                                  const std::string& coding, const std::string& tags) {
  ImageF picture(64, 36, 3);
  for (int y = 0; y < 36; ++y)
    for (int x = 0; x < 64; ++x)
      for (int c = 0; c < 3; ++c) picture(x, y, c) = static_cast<float>(kPatches[x / 16][c]) / 255;
  const std::string png = (folder / "patches.png").string();
  write_image(png, picture);
  const std::string encoder = name.find(".webm") != std::string::npos
                                  ? "-c:v libvpx-vp9 -deadline realtime -cpu-used 8 -crf 2 -b:v 0"
                                  : "-c:v libx264 -preset ultrafast -crf 1";
  EXPECT_EQ(std::system(fmt::format("ffmpeg -v error -y -loop 1 -framerate 10 -i {} -frames:v 2 "
                                    "-vf scale={}:flags=neighbor:{},format=yuv420p {} {} {}",
                                    png, size, coding, tags, encoder, (folder / name).string())
                            .c_str()),
            0);
  return folder / name;
}

/// Largest difference from the patches, of 255 levels.
double color_error(FrameSource& source) {
  const ImageF picture = source.next()->picture;
  double largest = 0;
  for (int k = 0; k < 4; ++k)
    for (int c = 0; c < 3; ++c)
      largest = std::max(
          largest, std::abs(255.0 * picture((2 * k + 1) * picture.width / 8, picture.height / 2, c) - kPatches[k][c]));
  return largest;
}

TEST(FrameSource, ColorsAreThoseThatTheTagsOfTheFileMean) {
  constexpr double kTwoLevels = 2.01;
  const TemporaryFolder folder;
  struct Case {
    const char *file, *coding, *tags;
  };
  for (const char* size : {"64:36", "1280:720"})
    for (const Case& c :
         {Case{"bt709.mp4", "out_color_matrix=bt709:out_range=tv", "-colorspace bt709 -color_range tv"},
          Case{"bt601.mp4", "out_color_matrix=bt601:out_range=tv", "-colorspace smpte170m"},
          Case{"full.mp4", "out_color_matrix=bt709:out_range=pc", "-colorspace bt709 -color_range pc"},
          Case{"full.webm", "out_color_matrix=bt709:out_range=pc", "-colorspace bt709 -color_range pc"}}) {
      const auto source = open_frames(coded_video(folder, c.file, size, c.coding, c.tags), 0);
      EXPECT_LE(color_error(*source), kTwoLevels) << c.file << " " << size;
      EXPECT_EQ(source->doubt(), "");
    }
}

TEST(FrameSource, WithoutTagsHdIsBt709WhichIsSaid) {
  const TemporaryFolder folder;
  const auto small = open_frames(coded_video(folder, "small.mp4", "64:36", "out_color_matrix=bt601", ""), 0);
  EXPECT_LE(color_error(*small), 2.01);
  EXPECT_EQ(small->doubt(), "");
  const auto large = open_frames(coded_video(folder, "large.mp4", "1280:720", "out_color_matrix=bt709", ""), 0);
  EXPECT_LE(color_error(*large), 2.01);
  EXPECT_NE(large->doubt().find("large.mp4 does not say how its colors are coded"), std::string::npos);
}

TEST(FrameSource, HdrIsSaid) {
  const TemporaryFolder folder;
  struct Case {
    const char *file, *transfer;
    bool hdr;
  };
  for (const char* matrix : {"bt2020nc", "smpte170m"})  // the latter needs no correction
    for (const Case& c :
         {Case{"hlg.mp4", "arib-std-b67", true}, Case{"pq.mp4", "smpte2084", true}, Case{"sdr.mp4", "bt709", false}}) {
      const std::string tags =
          fmt::format("-colorspace {} -color_primaries bt2020 -color_trc {} -color_range tv", matrix, c.transfer);
      const auto source = open_frames(coded_video(folder, c.file, "64:36", "out_range=tv", tags), 0);
      EXPECT_EQ(source->doubt().find(std::string(c.file) + " is in HDR") != std::string::npos, c.hdr) << c.file;
      EXPECT_EQ(source->doubt().empty(), !c.hdr) << c.file;
    }
}

}  // namespace
}  // namespace pliant

// Videos: equal frames give equal files, whole or absent, and a failed encoder is an error.

#include "gaussians/io/images/video.h"

#include <gtest/gtest.h>

#include <cmath>

#include "gaussians/io/files/files.h"
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

// `render --frames`: what the clip shows, without what a codec loses.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/videoio.hpp>

#include "gaussians/io/images/image_io.h"
#include "tests/app/beam_scene.h"
#include "tests/app/run_pliant.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

namespace fs = std::filesystem;
using namespace testing;

TEST(RenderFrames, AreThoseOfTheClip) {
  const TemporaryFolder folder;
  make_beam_scene(folder / "scene");
  const fs::path out = folder / "run";
  const std::string run = out.string();
  ASSERT_EQ(run_quietly({"segment", (folder / "scene").string(), "--out", run, "--aabb", "-0.1,-0.1,0.9,0.9,0.3,1.3"}),
            0);
  for (const std::vector<std::string>& words :
       std::vector<std::vector<std::string>>{{"extract", run, "--object", "object"},
                                             {"repair", run},
                                             {"seed", run, "--particles", "300", "--no-pin-contact"},
                                             {"simulate", run, "--young", "50000", "--fps", "20", "--duration", "0.2"},
                                             {"render", run, "--no-orbit"}})
    ASSERT_EQ(run_quietly(words), 0) << words[0];
  EXPECT_FALSE(fs::exists(out / "clip"));
  // A killed run left some.
  fs::create_directories(out / "clip.partial");
  write_text(out / "clip.partial/000099.png", "rubbish");
  ASSERT_EQ(run_quietly({"render", run, "--no-orbit", "--frames"}), 0);
  EXPECT_FALSE(fs::exists(out / "clip.partial"));

  cv::VideoCapture clip((out / "clip.mp4").string());
  cv::Mat decoded;
  int frames = 0;
  double square = 0;
  for (; clip.read(decoded); ++frames) {
    const ImageF frame = read_image(out / "clip" / fmt::format("{:06d}.png", frames));
    ASSERT_EQ(frame.width, decoded.cols);
    ASSERT_EQ(frame.height, decoded.rows);
    double sum = 0;
    for (int y = 0; y < frame.height; ++y)
      for (int x = 0; x < frame.width; ++x)
        for (int c = 0; c < 3; ++c) sum += std::pow(frame(x, y, c) - decoded.at<cv::Vec3b>(y, x)[2 - c] / 255.0, 2);
    square = std::max(square, sum / (3.0 * frame.width * frame.height));
  }
  EXPECT_EQ(frames, 5);
  EXPECT_EQ(std::distance(fs::directory_iterator(out / "clip"), fs::directory_iterator()), frames);
  EXPECT_GT(-10 * std::log10(square), 30);
}

}  // namespace
}  // namespace pliant

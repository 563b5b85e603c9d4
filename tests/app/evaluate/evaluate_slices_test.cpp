#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "app/evaluate/evaluate.h"
#include "gaussians/base/error.h"
#include "gaussians/io/images/image_io.h"
#include "gaussians/io/images/video.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr int kWidth = 64, kHeight = 48, kFrames = 20, kTop = 20, kBottom = 26;  // px; rows of the bar

/// A white bar that swings along its row.
ImageF bar_at(double x) {
  ImageF picture(kWidth, kHeight, 3);
  for (int row = kTop; row < kBottom; ++row)
    for (int column = 0; column < kWidth; ++column)
      for (int c = 0; c < 3; ++c) picture(column, row, c) = std::abs(column - x) < 4 ? 1.0f : 0.0f;
  return picture;
}

class Slices : public ::testing::Test {
 protected:
  fs::path swing(const std::string& name, double amplitude, double periods) {
    fs::create_directories(folder / name);
    for (int f = 0; f < kFrames; ++f) {
      const std::string file = std::to_string(1000 + f) + ".png";
      write_image(folder / name / file, bar_at(32 + amplitude * std::sin(2 * M_PI * periods * f / kFrames)));
    }
    return folder / name;
  }
  json evaluate(const std::vector<fs::path>& clips, SliceScore score = {}) {
    score.fps = 10;
    return evaluate_slices(reference, clips, score, folder / "slices.png");
  }
  TemporaryFolder folder;
  fs::path reference = swing("truth", 12, 2);
};

TEST_F(Slices, TheSameMotionHasNoDifferenceAndOthersMoreTheFartherTheyAre) {
  const json out = evaluate({reference, swing("smaller", 9, 2), swing("slower", 12, 1), swing("still", 0, 1)});
  EXPECT_TRUE(out["row"] >= kTop && out["row"] < kBottom) << out["row"];
  EXPECT_EQ(out["frames"], kFrames);
  ASSERT_EQ(out["clips"].size(), 4u);
  EXPECT_EQ(out["clips"][0]["row_rmse"], 0);
  EXPECT_EQ(out["clips"][0]["column_rmse"], 0);
  const auto row = [&](int clip) { return out["clips"][clip]["row_rmse"].get<double>(); };
  EXPECT_GT(row(1), 0.05);
  EXPECT_GT(row(2), row(1));
  EXPECT_GT(row(3), row(1));
}

TEST_F(Slices, ThePictureShowsTheChosenLinesOverTime) {
  SliceScore score;
  score.row = kTop + 2;
  score.column = 32;
  evaluate({swing("still", 0, 1)}, score);
  const ImageF picture = read_image(folder / "slices.png");
  // Two clips, a gap between them; time of the row runs down, each frame 8 px high, below a line of words.
  ASSERT_EQ(picture.width, 2 * 260 + 8);
  for (int f = 0; f < kFrames; ++f) {
    const int y = 22 + 8 * f + 4;
    const double x = 32 + 12 * std::sin(2 * M_PI * 2 * f / kFrames);
    EXPECT_GT(picture(static_cast<int>(std::lround(x)), y, 0), 0.9f) << f;
    EXPECT_GT(picture(260 + 8 + 32, y, 0), 0.9f) << f;
    EXPECT_LT(picture(260 + 8 + 10, y, 0), 0.1f) << f;
  }
}

TEST_F(Slices, ClipsBeginAtTheInstantOfTheReferencesFirstFrame) {
  // From 0.34 s on the reference begins at 0.3 s; the clip's nearest frames are at 0.32 and 0.36 s.
  const auto ramp = [&](const std::string& name, int fps) {
    VideoWriter writer(folder / name, fps, kWidth, kHeight);
    for (int f = 0; f < fps; ++f)
      writer.write(ImageF(kWidth, kHeight, 3, 0.1f + 0.8f * static_cast<float>(f) / static_cast<float>(fps)));
    writer.close();
    return folder / name;
  };
  SliceScore score;
  score.from = 0.34;
  const json out = evaluate_slices(ramp("10.mp4", 10), {ramp("25.mp4", 25)}, score, folder / "slices.png");
  EXPECT_LT(out["row_rmse"].get<double>(), 0.01);  // 0.02 s are 0.016
}

TEST_F(Slices, LargeFramesAreComparedAtASmallerSizeWhichIsSaid) {
  for (int f = 0; f < 3; ++f)
    write_image(folder / "large" / (std::to_string(f) + ".png"), ImageF(1600, 400, 3, 0.1f * static_cast<float>(f)));
  reference = folder / "large";
  const json out = evaluate({reference});
  EXPECT_EQ(out["width"], 1280);
  EXPECT_EQ(out["height"], 320);
  ASSERT_EQ(out["warnings"].size(), 1u);
  EXPECT_NE(out["warnings"][0].get<std::string>().find("1600 x 400"), std::string::npos);
  EXPECT_EQ(out["row_rmse"], 0);
}

TEST_F(Slices, AClipOfAnotherSizeIsScaledWithAWarning) {
  for (int f = 0; f < kFrames; ++f)
    write_image(folder / "small" / (std::to_string(1000 + f) + ".png"), ImageF(kWidth / 2, kHeight / 2, 3, 0.5f));
  const json out = evaluate({reference, folder / "small"});
  ASSERT_EQ(out["warnings"].size(), 1u) << out["warnings"];
  EXPECT_NE(out["warnings"][0].get<std::string>().find("small is 32 x 24 and is compared at 64 x 48"),
            std::string::npos);
}

TEST_F(Slices, WhatTheReaderDoubtsIsSaid) {
  const fs::path gap = swing("gap", 12, 2);
  fs::remove(gap / "1007.png");
  const json out = evaluate({gap});
  ASSERT_FALSE(out["warnings"].empty());
  EXPECT_NE(out["warnings"].dump().find("blend"), std::string::npos) << out["warnings"];
  EXPECT_TRUE(evaluate({reference})["warnings"].empty());
}

TEST_F(Slices, LinesOutsideAndFilesThatAreNoClipsAreRefused) {
  SliceScore score;
  score.row = kHeight;
  expect_error(Failure::kUsage, {"--row", "48"}, [&] { evaluate({reference}, score); });
  EXPECT_THROW(evaluate({folder / "nothing.mp4"}), Error);
  VideoWriter writer(folder / "film.mp4", 30, kWidth, kHeight);
  for (int f = 0; f < 8; ++f) writer.write(bar_at(20 + f));
  writer.close();
  reference = folder / "film.mp4";
  expect_error(Failure::kUsage, {"--fps", "videos"}, [&] { evaluate({reference}); });
  score = {};
  score.from = 5;
  expect_error(Failure::kInput, {"film.mp4", "--from, --until"},
               [&] { evaluate_slices(reference, {reference}, score, folder / "slices.png"); });
  EXPECT_THROW(evaluate({folder.file("words.mp4", "no video")}), Error);
}

}  // namespace
}  // namespace pliant

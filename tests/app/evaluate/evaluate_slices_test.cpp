#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "app/evaluate/evaluate.h"
#include "gaussians/base/error.h"
#include "gaussians/io/images/image_io.h"
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

TEST_F(Slices, LinesOutsideAndFilesThatAreNoClipsAreRefused) {
  SliceScore score;
  score.row = kHeight;
  expect_error(Failure::kUsage, {"--row", "48"}, [&] { evaluate({reference}, score); });
  EXPECT_THROW(evaluate({folder / "nothing.mp4"}), Error);
  EXPECT_THROW(evaluate({folder.file("words.mp4", "no video")}), Error);
}

}  // namespace
}  // namespace pliant

// Predictions broken in one way each: the metric that is made for it moves, in the right direction, and the others that
// it does not concern stay.

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "app/evaluate/evaluate.h"
#include "app/store/trajectory.h"
#include "gaussians/base/random.h"
#include "gaussians/io/images/image_io.h"
#include "tests/temporary_folder.h"

namespace fs = std::filesystem;
using nlohmann::json;

namespace pliant {
namespace {

/// A textured wall that swings sideways, `late` frames later than it should, or not at all.
fs::path write_film(const fs::path& folder, int late, bool frozen = false, int levels = 255) {
  for (int f = 0; f < 36; ++f) {
    const double t = std::max(0, f - late) / 30.0;
    const double shift = frozen ? 0 : 4 * std::exp(-0.5 * t) * std::sin(2 * M_PI * 1.6 * t);
    ImageF picture(96, 72, 3);
    for (int y = 0; y < picture.height; ++y)
      for (int x = 0; x < picture.width; ++x) {
        double sum = 0;
        for (int k = 0; k < 6; ++k) {
          Random random(31, k);
          const double angle = 2 * M_PI * random.uniform(), length = 9 + 18 * random.uniform();
          sum += std::sin(2 * M_PI * ((x - shift) * std::cos(angle) + y * std::sin(angle)) / length + k);
        }
        for (int c = 0; c < 3; ++c)
          picture(x, y, c) = static_cast<float>(std::round((0.5 + 0.07 * sum) * levels) / levels);
      }
    write_image(folder / (std::to_string(f) + ".png"), picture);
  }
  return folder;
}

class BrokenFilm : public testing::Test {
 protected:
  void SetUp() override {
    score_.fps = 30;
    score_.free_from = 0.15;
    part_.fps = 30;
    truth_ = write_film(folder_ / "truth", 0);
  }
  json motion_of(const fs::path& film) const { return evaluate_motion(film, truth_, score_); }
  double slice_of(const fs::path& film) const {
    return evaluate_slices(truth_, {film}, {part_, {}, {}}, folder_ / "slices.png")["row_rmse"];
  }

  TemporaryFolder folder_;
  MotionScore score_;
  ClipPart part_;
  fs::path truth_;
};

TEST_F(BrokenFilm, FrozenFramesHaveNoFrequencyAndAllTheErrorOfAmplitudeAndFlow) {
  const json found = motion_of(write_film(folder_ / "frozen", 0, true));
  EXPECT_TRUE(found["prediction"]["frequency_hz"].is_null());
  EXPECT_TRUE(found["frequency_error"].is_null());
  EXPECT_NEAR(found["amplitude_error"].get<double>(), 1, 0.05);
  EXPECT_NEAR(found["flow_error"].get<double>(), 1, 0.1);
  EXPECT_EQ(found["delay_s"], 0);
  EXPECT_GT(slice_of(folder_ / "frozen"), 0.02);
}

TEST_F(BrokenFilm, ShiftedFramesLeaveTheFrequencyAndMoveFlowAndSlices) {
  const json right = motion_of(truth_), found = motion_of(write_film(folder_ / "late", 3));
  EXPECT_EQ(right["flow_error"], 0);
  EXPECT_EQ(right["delay_s"], 0);
  EXPECT_GT(found["flow_error"].get<double>(), 0.4);
  EXPECT_NEAR(found["delay_s"].get<double>(), 0.1, 1e-9);
  EXPECT_LT(found["flow_error_without_delay"].get<double>(), 0.05);
  EXPECT_LT(found["frequency_error"].get<double>(), 0.06);
  EXPECT_EQ(slice_of(truth_), 0);
  EXPECT_GT(slice_of(folder_ / "late"), 0.02);
}

TEST_F(BrokenFilm, FewerLevelsLowerPsnrByTheirNoiseAndLeaveTheMotion) {
  // Rounding to steps of 1 / 31 has the variance step^2 / 12.
  const fs::path coarse = write_film(folder_ / "coarse", 0, false, 31);
  const json images = evaluate_images(coarse, truth_), same = evaluate_images(truth_, truth_);
  EXPECT_NEAR(images["psnr"].get<double>(), 10 * std::log10(12 * 31.0 * 31), 0.3);
  EXPECT_LT(images["ssim"].get<double>(), same["ssim"].get<double>());
  EXPECT_LT(motion_of(coarse)["frequency_error"].get<double>(), 0.03);
}

TEST(BrokenPrediction, EightBitsOfAPictureWithSixteenAreFiftyNineDecibels) {
  const TemporaryFolder folder;
  ImageF smooth(64, 48, 1), rounded;
  for (int y = 0; y < smooth.height; ++y)
    for (int x = 0; x < smooth.width; ++x) smooth(x, y) = static_cast<float>(Random(3, x, y).uniform());
  rounded = smooth;
  for (float& v : rounded.data) v = std::round(v * 255) / 255;
  write_grey_16(folder / "deep.png", smooth);
  write_grey_16(folder / "rounded.png", rounded);
  const json found = evaluate_images(folder / "rounded.png", folder / "deep.png");
  EXPECT_NEAR(found["psnr"].get<double>(), 10 * std::log10(12 * 255.0 * 255), 0.3);
  EXPECT_FALSE(found["identical"].get<bool>());
}

TEST(BrokenPrediction, SwappedLabelsScoreNothingByIdAndEverythingByOverlap) {
  const TemporaryFolder folder;
  IdImage truth(40, 30, 1, 1), swapped(40, 30, 1, 2);
  for (int y = 5; y < 20; ++y)
    for (int x = 8; x < 25; ++x) {
      truth(x, y) = 2;
      swapped(x, y) = 1;
    }
  write_ids(folder / "truth/a.png", truth);
  write_ids(folder / "swapped/a.png", swapped);
  SegmentationScore by_id, by_overlap;
  by_id.match = "id";
  by_overlap.match = "overlap";
  const json wrong = evaluate_segmentation(folder / "swapped", folder / "truth", by_id),
             right = evaluate_segmentation(folder / "swapped", folder / "truth", by_overlap);
  for (const char* metric : {"miou", "boundary_miou", "accuracy"}) {
    EXPECT_EQ(wrong[metric], 0) << metric;
    EXPECT_EQ(right[metric], 1) << metric;
  }
}

TEST(BrokenPrediction, PicturesOfTheWrongSizeAreRefusedWhereTheyHaveNoScore) {
  const TemporaryFolder folder;
  write_image(folder / "truth/a.png", ImageF(40, 30, 3, 0.5f));
  write_image(folder / "small/a.png", ImageF(20, 15, 3, 0.5f));
  expect_error(Failure::kInput, {"a.png", "20 x 15", "40 x 30"},
               [&] { evaluate_images(folder / "small", folder / "truth"); });
  write_ids(folder / "ids/a.png", IdImage(40, 30, 1, 1));
  write_ids(folder / "small_ids/a.png", IdImage(20, 15, 1, 1));
  expect_error(Failure::kInput, {"a.png", "20 x 15"},
               [&] { evaluate_segmentation(folder / "small_ids", folder / "ids"); });
}

}  // namespace
}  // namespace pliant

// The protocols of LERF-Mask and NVOS where the released scripts and strict scores differ, and what they refuse.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "app/evaluate/binary_masks.h"
#include "app/evaluate/evaluate.h"
#include "gaussians/io/images/image_io.h"
#include "tests/temporary_folder.h"

namespace fs = std::filesystem;
using nlohmann::json;

namespace pliant {
namespace {

/// A white box in a black picture of 50 x 40.
void write_box(const fs::path& file, int left, int right, int width = 50, int height = 40) {
  ImageF mask(width, height, 3);
  for (int y = 0; y < height / 2; ++y)
    for (int x = left; x < right; ++x)
      for (int c = 0; c < 3; ++c) mask(x, y, c) = 1;
  write_image(file, mask);
}

TEST(BinaryMasks, LumaAbove128IsTheObject) {
  const TemporaryFolder folder;
  ImageF picture(4, 1, 3, 0.0f);
  for (int c = 0; c < 3; ++c) {
    picture(0, 0, c) = 128 / 255.0f;
    picture(1, 0, c) = 129 / 255.0f;
  }
  picture(2, 0, 1) = 1;  // green alone has a luma of 150
  picture(3, 0, 0) = 1;  // red 76
  write_image(folder / "m.png", picture);
  EXPECT_EQ(read_mask(folder / "m.png").data, (std::vector<uint8_t>{0, 1, 1, 0}));
}

TEST(BinaryMasks, ValuesOfZeroAndOneAreRefusedInsteadOfTakenAsEmpty) {
  const TemporaryFolder folder;
  IdImage ids(8, 8, 1);
  write_ids(folder / "empty.png", ids);
  EXPECT_EQ(read_mask(folder / "empty.png").data, std::vector<uint8_t>(64, 0));
  ids(3, 4) = 1;
  write_ids(folder / "ids.png", ids);
  expect_error(Failure::kInput, {"ids.png", "0 and 1", "255"}, [&] { read_mask(folder / "ids.png"); });
  write_grey_16(folder / "deep.png", ImageF(8, 8, 1, 1 / 65535.0f));
  expect_error(Failure::kInput, {"deep.png", "0 and 1"}, [&] { read_mask(folder / "deep.png"); });
}

TEST(BinaryMasks, TheContourOfAMaskIncludesThePicturesBorder) {
  // A mask that fills the picture: its band is a frame of 2 px, of itself and of an empty one.
  const ImageU8 full(20, 10, 1, 1), empty(20, 10, 1);
  EXPECT_EQ(boundary_overlap(full, full, 2).either, 20 * 10 - 16 * 6);
  EXPECT_EQ(boundary_overlap(full, full, 2).iou(), 1);
  EXPECT_EQ(boundary_overlap(full, empty, 2).iou(), 0);
  EXPECT_EQ(boundary_band(300, 400), 10);
}

TEST(BinaryMasks, ResizingTakesTheNearestPixel) {
  ImageU8 mask(3, 1, 1);
  mask.data = {1, 0, 1};
  EXPECT_EQ(resized_nearest(mask, 6, 1).data, (std::vector<uint8_t>{1, 1, 0, 0, 1, 1}));
  EXPECT_EQ(resized_nearest(resized_nearest(mask, 6, 2), 3, 1).data, mask.data);
}

TEST(EvaluateLerfMask, PromptsCountAlikeHoweverManyViewsShowThem) {
  const TemporaryFolder folder;
  for (const char* view : {"0", "1", "2"}) write_box(folder / "truth" / view / "green apple.png", 10, 20);
  write_box(folder / "truth/0/cup.png", 30, 40);
  for (const char* view : {"0", "1", "2"}) write_box(folder / "ours" / view / "green apple.png", 10, 20);
  write_box(folder / "ours/0/cup.png", 35, 45);
  const json found = evaluate_lerf_mask(folder / "ours", folder / "truth");
  EXPECT_NEAR(found["miou"].get<double>(), 0.5 * (1 + 1 / 3.0), 1e-12);
  EXPECT_EQ(found["per_prompt"]["green apple"]["views"], 3);
  EXPECT_EQ(found["masks"], 4);
}

TEST(EvaluateLerfMask, WhereNothingIsSeenStrictScoresAgreementAndTheScriptHasNoValue) {
  const TemporaryFolder folder;
  write_box(folder / "truth/0/cup.png", 0, 0);
  write_box(folder / "ours/0/cup.png", 0, 0);
  const json found = evaluate_lerf_mask(folder / "ours", folder / "truth");
  EXPECT_EQ(found["miou"], 1);
  EXPECT_TRUE(found["paper_compatible"]["miou"].is_null());
}

TEST(EvaluateLerfMask, MissingAndWronglySizedMasksAreListedAndScoreNothing) {
  const TemporaryFolder folder;
  for (const char* prompt : {"a", "b", "c"}) write_box(folder / "truth/0" / (std::string(prompt) + ".png"), 10, 20);
  write_box(folder / "ours/0/a.png", 10, 20);
  write_box(folder / "ours/0/b.png", 20, 40, 100, 80);
  const json found = evaluate_lerf_mask(folder / "ours", folder / "truth");
  EXPECT_EQ(found["missing"], json::array({"0/c"}));
  EXPECT_EQ(found["wrong_size"], json::array({"0/b"}));
  EXPECT_NEAR(found["miou"].get<double>(), 1 / 3.0, 1e-12);
  EXPECT_EQ(found["paper_compatible"]["miou"], 1);
}

TEST(EvaluateLerfMask, FoldersWithoutPicturesBesideTheViewsAreNoViews) {
  const TemporaryFolder folder;
  for (const char* side : {"truth", "ours"}) {
    write_box(folder / side / "0/cup.png", 10, 20);
    folder.file(std::string(side) + "/logs/training.txt", "");
    fs::create_directories(folder / side / "empty");
  }
  const json found = evaluate_lerf_mask(folder / "ours", folder / "truth");
  EXPECT_EQ(found["masks"], 1);
  EXPECT_EQ(found["miou"], 1);
}

TEST(EvaluateLerfMask, FoldersWithoutMasksAreRefused) {
  const TemporaryFolder folder;
  write_box(folder / "truth/0/cup.png", 10, 20);
  fs::create_directories(folder / "empty");
  expect_error(Failure::kInput, {"none", "is not a folder"},
               [&] { evaluate_lerf_mask(folder / "none", folder / "truth"); });
  expect_error(Failure::kInput, {"empty", "VIEW/PROMPT.png"},
               [&] { evaluate_lerf_mask(folder / "truth", folder / "empty"); });
  write_box(folder / "other/1/cup.png", 10, 20);
  expect_error(Failure::kInput, {"other", "0/cup", "missing"},
               [&] { evaluate_lerf_mask(folder / "other", folder / "truth"); });
}

TEST(EvaluateNvos, MasksHaveOneOfThreeNamesAndMissingScenesScoreNothing) {
  const TemporaryFolder folder;
  write_box(folder / "nvos/masks/fern/IMG_4027_mask.png", 10, 20);
  write_box(folder / "nvos/masks/flower/IMG_2962_mask.png", 10, 20);
  write_box(folder / "nvos/masks/horns_left/DJI_20200223_163024_597_mask.png", 10, 20);
  write_box(folder / "nvos/masks/orchids/IMG_4480_mask.png", 10, 20);
  write_box(folder / "ours/fern/IMG_4027.png", 10, 20);
  write_box(folder / "ours/flower/IMG_2962_mask.jpg", 10, 20);
  write_box(folder / "ours/horns_left.png", 20, 40, 100, 80);
  const json found = evaluate_nvos(folder / "ours", folder / "nvos");
  EXPECT_EQ(found["scenes"], 4);
  EXPECT_EQ(found["missing"], json::array({"orchids"}));
  EXPECT_TRUE(found["per_scene"]["horns_left"]["resized"].get<bool>());
  EXPECT_EQ(found["per_scene"]["horns_left"]["iou"], 1);
  EXPECT_NEAR(found["miou"].get<double>(), 0.75, 1e-12);
  EXPECT_EQ(found["per_scene"]["fern"]["reference_image"], "IMG_4038");
  expect_error(Failure::kInput, {"none", "is not a folder"}, [&] { evaluate_nvos(folder / "none", folder / "nvos"); });
  fs::create_directories(folder / "empty");
  expect_error(Failure::kInput, {"empty", "no mask", "SCENE.png"},
               [&] { evaluate_nvos(folder / "empty", folder / "nvos"); });
  expect_error(Failure::kInput, {"other", "IMG_4027_mask.png"},
               [&] { evaluate_nvos(folder / "ours", folder / "other"); });
}

}  // namespace
}  // namespace pliant

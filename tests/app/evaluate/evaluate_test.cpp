// Metrics with known answers, what they refuse, and conditions on them.

#include "app/evaluate/evaluate.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "app/store/material.h"
#include "app/store/particles.h"
#include "app/store/segmentation.h"
#include "gaussians/base/random.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/images/image_io.h"
#include "gaussians/io/images/photo.h"
#include "tests/gaussians/photo_files.h"
#include "tests/temporary_folder.h"

using nlohmann::json;

namespace pliant {
namespace {

ImageF noise(int width, int height, uint64_t seed) {
  ImageF image(width, height, 3);
  Random random(seed);
  for (float& value : image.data) value = static_cast<float>(random.below(200) + 20) / 255.0f;
  return image;
}

TEST(EvaluateImages, AnOffsetOfTenLevelsIs28Point13Decibels) {
  const TemporaryFolder folder;
  ImageF a = noise(40, 30, 1), b = a;
  for (float& value : b.data) value += 10.0f / 255;
  write_image(folder / "truth/v.png", a);
  write_image(folder / "pred/v.png", b);
  const json out = evaluate_images(folder / "pred", folder / "truth");
  EXPECT_NEAR(out["psnr"].get<double>(), 20 * std::log10(25.5), 1e-4);
  EXPECT_NEAR(out["psnr"].get<double>(), 28.13, 0.005);
  EXPECT_EQ(out["psnr_std"], 0);
  EXPECT_EQ(out["identical"], false);
}

TEST(EvaluateImages, IdenticalPicturesHaveThePsnrOfTheirCapAndSsimOne) {
  const TemporaryFolder folder;
  write_image(folder / "truth/v.png", noise(40, 30, 1));
  write_image(folder / "pred/v.png", noise(40, 30, 1));
  const json out = evaluate_images(folder / "pred", folder / "truth");
  EXPECT_EQ(out["psnr"], kPsnrOfIdentical);
  EXPECT_EQ(out["identical"], true);
  EXPECT_NEAR(out["ssim"].get<double>(), 1, 1e-12);
  EXPECT_TRUE(assert_metrics(out, {"psnr>=60", "ssim >= 0.999"}).empty());
}

TEST(EvaluateImages, NoPictureScoresHigherThanAnIdenticalOne) {
  const TemporaryFolder folder;
  const ImageF a = noise(30, 20, 1);
  ImageF worse = a, large(400, 400, 3, 0.5f), nearly = large;
  worse.data[7] += 20.0f / 255;
  nearly.data[7] += 1.0f / 255;  // 105 dB
  for (const char* name : {"truth/a.png", "truth/b.png", "one_worse/a.png"}) write_image(folder / name, a);
  for (const char* name : {"both_worse/a.png", "both_worse/b.png", "one_worse/b.png"})
    write_image(folder / name, worse);
  const json one = evaluate_images(folder / "one_worse", folder / "truth"),
             both = evaluate_images(folder / "both_worse", folder / "truth");
  EXPECT_EQ(one["per_image"]["a"]["psnr"], kPsnrOfIdentical);
  EXPECT_EQ(one["identical_pictures"], 1);
  EXPECT_NEAR(one["psnr"].get<double>(), 0.5 * (both["psnr"].get<double>() + kPsnrOfIdentical), 1e-9);
  write_image(folder / "large.png", large);
  write_image(folder / "nearly.png", nearly);
  const json close = evaluate_images(folder / "nearly.png", folder / "large.png");
  EXPECT_FALSE(close["identical"].get<bool>());
  EXPECT_EQ(close["psnr"], kPsnrOfIdentical);
}

TEST(EvaluateImages, SsimOfTwoConstantPicturesIsTheLuminanceTerm) {
  const TemporaryFolder folder;
  write_image(folder / "truth/v.png", ImageF(20, 20, 3, 0.2f));
  write_image(folder / "pred/v.png", ImageF(20, 20, 3, 0.6f));
  const json out = evaluate_images(folder / "pred", folder / "truth");
  const double c1 = 1e-4, x = 51.0 / 255, y = 153.0 / 255;
  EXPECT_NEAR(out["ssim"].get<double>(), (2 * x * y + c1) / (x * x + y * y + c1), 1e-6);
}

TEST(EvaluateImages, SsimOfANegativeIsNegativeAndLossOfContrastLowersIt) {
  const TemporaryFolder folder;
  const ImageF a = noise(60, 50, 2);
  ImageF negative = a, half = a;
  for (size_t i = 0; i < a.data.size(); ++i) {
    negative.data[i] = 239.0f / 255 - a.data[i];
    half.data[i] = 0.5f * a.data[i] + 0.23f;
  }
  write_image(folder / "truth.png", a);
  write_image(folder / "negative.png", negative);
  write_image(folder / "half.png", half);
  EXPECT_LT(evaluate_images(folder / "negative.png", folder / "truth.png")["ssim"].get<double>(), -0.5);
  const double ssim_of_half = evaluate_images(folder / "half.png", folder / "truth.png")["ssim"];
  EXPECT_LT(ssim_of_half, 0.9);
  EXPECT_GT(ssim_of_half, 0.5);
}

TEST(EvaluateImages, WhatTransparencyHidesDoesNotCount) {
  const TemporaryFolder folder;
  const ImageF visible = noise(40, 30, 3);
  const auto write = [&](const std::string& name, float hidden) {
    ImageF picture(40, 30, 4, hidden);
    for (int y = 0; y < 30; ++y)
      for (int x = 0; x < 40; ++x) {
        picture(x, y, 3) = x < 20 ? 1 : 0;
        for (int c = 0; c < 3 && x < 20; ++c) picture(x, y, c) = visible(x, y, c);
      }
    write_image(folder / name, picture);
  };
  write("a.png", 0);
  write("b.png", 1);
  const json out = evaluate_images(folder / "a.png", folder / "b.png");
  EXPECT_TRUE(out["identical"].get<bool>());
  EXPECT_EQ(out["protocol"]["transparency"], "over black");
  // Half transparent is half as bright.
  write_image(folder / "half.png", ImageF(20, 20, 4, 128 / 255.0f));
  write_image(folder / "black.png", ImageF(20, 20, 3, 0.0f));
  EXPECT_NEAR(evaluate_images(folder / "half.png", folder / "black.png")["mse"].get<double>(), std::pow(128 / 255.0, 4),
              1e-6);
}

TEST(EvaluateImages, PhotosAreTurnedWhereOnlyThatGivesTheSizeOfTheRender) {
  const TemporaryFolder folder;
  const auto value = [](int x, int y, int c) { return 40 + 4 * x + 2 * y + 10 * c; };
  const std::string jpeg = encoded(".jpg", picture_of(30, 20, value), 100);
  for (const int orientation : {5, 6, 7, 8}) {
    folder.file("photos/v.jpg", with_orientation(jpeg, orientation, true));
    const Photo photo = read_photo(folder / "photos/v.jpg");
    ASSERT_EQ(photo.orientation, orientation);
    const ImageF stored = read_image(folder / "photos/v.jpg");
    // Upright renders and renders of the stored pixels are both those of the photo, on either side.
    for (const ImageF& render : {stored, oriented(stored, orientation)}) {
      write_image(folder / "renders/v.png", render);
      EXPECT_TRUE(evaluate_images(folder / "renders", folder / "photos")["identical"].get<bool>()) << orientation;
      EXPECT_TRUE(evaluate_images(folder / "photos", folder / "renders")["identical"].get<bool>()) << orientation;
    }
  }
  // Without a tag nothing says how to turn it.
  folder.file("photos/v.jpg", jpeg);
  expect_error(Failure::kInput, {"20 x 30", "30 x 20"},
               [&] { evaluate_images(folder / "renders", folder / "photos"); });
}

TEST(EvaluateImages, MissingExtraSmallAndDifferentlySizedPicturesAreErrors) {
  const TemporaryFolder folder;
  write_image(folder / "truth/a.png", noise(20, 20, 1));
  write_image(folder / "truth/b.png", noise(20, 20, 2));
  write_image(folder / "pred/a.png", noise(20, 20, 1));
  expect_error(Failure::kInput, {"pred", "b", "lacks"}, [&] { evaluate_images(folder / "pred", folder / "truth"); });
  expect_error(Failure::kInput, {"pred", "b", "lacks"}, [&] { evaluate_images(folder / "truth", folder / "pred"); });
  write_image(folder / "pred/b.png", noise(21, 20, 2));
  expect_error(Failure::kInput, {"b.png", "21 x 20", "20 x 20"},
               [&] { evaluate_images(folder / "pred", folder / "truth"); });
  folder.file("pred/b.png", "no picture");
  expect_error(Failure::kInput, {"b.png", "decoded"}, [&] { evaluate_images(folder / "pred", folder / "truth"); });
  write_image(folder / "pred/b.jpg", noise(20, 20, 2));
  expect_error(Failure::kInput, {"b", "name of two images"},
               [&] { evaluate_images(folder / "pred", folder / "truth"); });
  expect_error(Failure::kInput, {"none"}, [&] { evaluate_images(folder / "none", folder / "truth"); });
  std::filesystem::create_directories(folder / "empty");
  expect_error(Failure::kInput, {"contains no images"}, [&] { evaluate_images(folder / "empty", folder / "truth"); });
  write_image(folder / "s/a.png", noise(8, 8, 1));
  expect_error(Failure::kInput, {"11 x 11"}, [&] { evaluate_images(folder / "s", folder / "s"); });
}

IdImage square(int left, uint32_t id, uint32_t rest) {
  IdImage ids(60, 40, 1, rest);
  for (int y = 10; y < 30; ++y) {
    for (int x = left; x < left + 20; ++x) ids(x, y) = id;
  }
  return ids;
}

TEST(EvaluateSegmentation, IouOfAShiftedSquareFollowsTheFormula) {
  const TemporaryFolder folder;
  for (int shift : {0, 3, 20}) {
    write_ids(folder / "truth/v.png", square(10, 5, 9));
    write_ids(folder / "pred/v.png", square(10 + shift, 5, 9));
    const json out = evaluate_segmentation(folder / "pred", folder / "truth");
    const double in = 20.0 * (20 - shift), of = 20.0 * (20 + shift), rest = 2400 - 400;
    EXPECT_NEAR(out["per_id"]["5"]["iou"].get<double>(), in / of, 1e-12);
    const double other = (rest - 20.0 * shift) / (rest + 20.0 * shift);
    EXPECT_NEAR(out["miou"].get<double>(), 0.5 * (in / of + other), 1e-12);
    EXPECT_NEAR(out["accuracy"].get<double>(), (2400 - 40.0 * shift) / 2400, 1e-12);
    if (shift == 0) {
      EXPECT_EQ(out["boundary_miou"], 1.0);
    }
    if (shift == 3) {
      EXPECT_LT(out["boundary_miou"], out["miou"]);
    }
  }
}

TEST(EvaluateSegmentation, TheBandOfTheBoundaryScoreIsChosen) {
  const TemporaryFolder folder;
  write_ids(folder / "truth/v.png", square(10, 5, 0));
  write_ids(folder / "pred/v.png", square(11, 5, 0));
  SegmentationScore score;
  score.band = 1;  // a ring of 76 pixels, 38 of which both have; 18 of ours lie inside it
  const json out = evaluate_segmentation(folder / "pred", folder / "truth", score);
  EXPECT_NEAR(out["boundary_miou"].get<double>(), 38.0 / 94, 1e-12);
  score.band = 100;  // the whole square
  EXPECT_EQ(evaluate_segmentation(folder / "pred", folder / "truth", score)["boundary_miou"], out["miou"]);
}

TEST(EvaluateSegmentation, AnObjectSeenWhereThereIsNoneCountsAgainstItsBoundary) {
  const TemporaryFolder folder;
  for (const char* name : {"truth/a.png", "pred/a.png", "pred/b.png"}) write_ids(folder / name, square(10, 5, 9));
  write_ids(folder / "truth/b.png", square(10, 9, 9));
  SegmentationScore score;
  score.band = 1;
  const json out = evaluate_segmentation(folder / "pred", folder / "truth", score);
  EXPECT_EQ(out["per_id"]["5"]["boundary_iou"], 0.5);
  EXPECT_EQ(out["per_id"]["5"]["iou"], 0.5);
}

TEST(EvaluateSegmentation, IdsWithoutAMeaningAreMatchedByOverlap) {
  const TemporaryFolder folder;
  write_ids(folder / "truth/v.png", square(10, 5, 9));
  write_ids(folder / "pred/v.png", square(10, 9, 70));
  SegmentationScore score;
  EXPECT_LT(evaluate_segmentation(folder / "pred", folder / "truth", score)["miou"], 0.2);
  score.match = "overlap";
  const json out = evaluate_segmentation(folder / "pred", folder / "truth", score);
  EXPECT_EQ(out["miou"], 1.0);
  EXPECT_EQ(out["matched_by"], "overlap");
}

TEST(EvaluateSegmentation, PicturesWithoutAPredictionAreLeftOutOnRequest) {
  const TemporaryFolder folder;
  write_ids(folder / "truth/a.png", square(10, 5, 0));
  write_ids(folder / "pred/a.png", square(10, 5, 0));
  write_ids(folder / "truth/b.png", square(10, 5, 0));
  SegmentationScore score;
  score.common = true;
  EXPECT_EQ(evaluate_segmentation(folder / "pred", folder / "truth", score)["miou"], 1.0);
}

TEST(EvaluateSegmentation, UnlabelledPixelsOfTheTruthDoNotCount) {
  const TemporaryFolder folder;
  write_ids(folder / "truth/v.png", square(10, 5, 0));
  write_ids(folder / "pred/v.png", square(10, 5, 5));
  json out = evaluate_segmentation(folder / "pred", folder / "truth");
  EXPECT_EQ(out["miou"], 1.0);
  ASSERT_EQ(out["warnings"].size(), 1u);
  EXPECT_NE(out["warnings"][0].get<std::string>().find("one object and no background"), std::string::npos);
  // Where the background has an ID, what is painted over it counts.
  write_ids(folder / "truth/v.png", square(10, 5, 9));
  out = evaluate_segmentation(folder / "pred", folder / "truth");
  EXPECT_NEAR(out["per_id"]["5"]["iou"].get<double>(), 400.0 / 2400, 1e-12);
  EXPECT_TRUE(out["warnings"].empty());
}

TEST(EvaluateSegmentation, AMissingPictureCountsAsZero) {
  const TemporaryFolder folder;
  write_ids(folder / "truth/a.png", square(10, 5, 0));
  write_ids(folder / "pred/a.png", square(10, 5, 0));
  write_ids(folder / "truth/b.png", square(10, 5, 0));
  const json out = evaluate_segmentation(folder / "pred", folder / "truth");
  EXPECT_EQ(out["miou"], 0.5);
  EXPECT_EQ(out["per_view"]["b"], 0.0);
  EXPECT_EQ(out["missing"], json({"b"}));
}

TEST(EvaluateSegmentation, NamesMatchIdsWhenBothSidesHaveThem) {
  const TemporaryFolder folder;
  write_ids(folder / "truth/masks/v.png", square(10, 5, 9));
  write_ids(folder / "pred/v.png", square(10, 1, 2));
  EXPECT_EQ(evaluate_segmentation(folder / "pred", folder / "truth/masks")["miou"], 0.0);
  folder.file("truth/labels.json", R"({"5": "mug", "9": "table"})");
  folder.file("pred/labels.json", R"({"1": "mug", "2": "table"})");
  const json out = evaluate_segmentation(folder / "pred", folder / "truth/masks/");
  EXPECT_EQ(out["miou"], 1.0);
  EXPECT_EQ(out["per_id"]["5"]["name"], "mug");
  folder.file("pred/labels.json", R"({"1": "mug", "2": 3})");
  expect_error(Failure::kInput, {"labels.json", "2"},
               [&] { evaluate_segmentation(folder / "pred", folder / "truth/masks"); });
}

TEST(EvaluateSegmentation, AFolderAgreesWithItselfWhateverItsNames) {
  const TemporaryFolder folder;
  write_ids(folder / "truth/v.png", square(10, 5, 9));
  write_ids(folder / "pred/v.png", square(10, 5, 9));
  for (const char* names : {R"({"5": "chair", "9": "chair"})", R"({"5": "chair"})", R"({"1": "wall", "5": "chair"})"}) {
    for (const char* side : {"truth", "pred"}) folder.file(std::string(side) + "/labels.json", names);
    const json out = evaluate_segmentation(folder / "pred", folder / "truth");
    EXPECT_EQ(out["miou"], 1.0) << names;
    EXPECT_EQ(out["matched_by"], "name") << names;
  }
  // A name that tells no single id moves none, and an id that has another name stands for nothing.
  folder.file("truth/labels.json", R"({"5": "chair", "9": "table"})");
  folder.file("pred/labels.json", R"({"5": "table", "9": "table", "1": "chair"})");
  const json out = evaluate_segmentation(folder / "pred", folder / "truth");
  EXPECT_EQ(out["per_id"]["9"]["iou"], 1.0);
  EXPECT_EQ(out["per_id"]["5"]["iou"], 0.0);
}

TEST(EvaluateSegmentation, LabelsOfGaussiansAreComparedById) {
  const TemporaryFolder folder;
  write_labels(folder / "truth.h5", {{1, 1, 1, 1, 2, 2, 0, 0}, {{1, "a"}, {2, "b"}}}, "{}");
  write_labels(folder / "pred.h5", {{1, 1, 1, 2, 2, 2, 7, 0}, {}}, "{}");
  const json out = evaluate_segmentation(folder / "pred.h5", folder / "truth.h5");
  EXPECT_NEAR(out["miou"].get<double>(), 0.5 * (3.0 / 4 + 2.0 / 3), 1e-12);
  EXPECT_NEAR(out["accuracy"].get<double>(), 5.0 / 6, 1e-12);
  write_labels(folder / "short.h5", {{1, 1}, {}}, "{}");
  expect_error(Failure::kInput, {"short.h5", "2 Gaussians", "8"},
               [&] { evaluate_segmentation(folder / "short.h5", folder / "truth.h5"); });
}

TEST(EvaluateSegmentation, UselessInputIsRefused) {
  const TemporaryFolder folder;
  write_ids(folder / "truth/a.png", square(10, 5, 9));
  write_ids(folder / "pred/other.png", square(10, 5, 9));
  expect_error(Failure::kInput, {"pred", "no image with a name"},
               [&] { evaluate_segmentation(folder / "pred", folder / "truth"); });
  write_ids(folder / "pred/a.png", IdImage(10, 10, 1, 5));
  expect_error(Failure::kInput, {"a.png", "10 x 10"},
               [&] { evaluate_segmentation(folder / "pred", folder / "truth"); });
  write_ids(folder / "zero/a.png", IdImage(60, 40, 1, 0));
  expect_error(Failure::kInput, {"zero", "labels no object"},
               [&] { evaluate_segmentation(folder / "zero", folder / "zero"); });
}

TEST(EvaluateSegmentation, PhotosAreRefusedAsMasks) {
  const TemporaryFolder folder;
  write_ids(folder / "truth/a.png", square(10, 5, 9));
  write_image(folder / "photos/a.png", noise(60, 40, 4));
  expect_error(Failure::kInput, {"photos", "255 IDs", "--match overlap"},
               [&] { evaluate_segmentation(folder / "photos", folder / "truth"); });
  // Many IDs are no photo when they are those of the truth.
  IdImage many(60, 40, 1);
  for (size_t i = 0; i < many.data.size(); ++i) many.data[i] = static_cast<uint32_t>(1 + i / 4);
  write_ids(folder / "many/a.png", many);
  EXPECT_EQ(evaluate_segmentation(folder / "many", folder / "many")["miou"], 1);
}

TEST(EvaluateMaterial, AFactorOfTenIsOneDecadeAndVolumesWeigh) {
  const TemporaryFolder folder;
  MaterialFile truth = {
      {1e5f, 1e6f, 1e5f, 1e5f}, {0.3f, 0.3f, 0.3f, 0.3f}, {1000, 1000, 1000, 1000}, "truth", {}, {7, 1, 1, 1}};
  for (int i = 0; i < 4; ++i) truth.position.push_back(Vec3f(i, 0, 0));
  write_material(folder / "truth.h5", truth, "{}");
  // Two predicted samples stand for the four true ones: rows 0, 1 and rows 2, 3.
  const MaterialFile pred = {{1e6f, 1e5f}, {0.4f, 0.3f}, {1100, 1000}, "guess", {{0.4f, 0.1f, 0}, {2.6f, 0.1f, 0}},
                             {1, 1}};
  write_material(folder / "pred.h5", pred, "{}");
  const json out = evaluate_material(folder / "pred.h5", folder / "truth.h5");
  EXPECT_NEAR(out["log10_young_error"].get<double>(), 0.25, 1e-6);
  EXPECT_NEAR(out["log10_young_error_median"].get<double>(), 0, 1e-6);
  EXPECT_NEAR(out["log10_young_error_max"].get<double>(), 1, 1e-6);
  EXPECT_NEAR(out["log10_young_error_volume_weighted"].get<double>(), 0.7, 1e-6);
  EXPECT_NEAR(out["log10_young_bias"].get<double>(), 0.25, 1e-6);
  EXPECT_NEAR(out["poisson_error"].get<double>(), 0.05, 1e-6);
  EXPECT_NEAR(out["density_relative_error"].get<double>(), 0.05, 1e-6);
  write_material(folder / "bare.h5", {{1}, {0.3f}, {1}, "x", {}, {}}, "{}");
  expect_error(Failure::kInput, {"bare.h5", "position", "no particles.h5 of as many samples"},
               [&] { evaluate_material(folder / "bare.h5", folder / "truth.h5"); });
  // Two samples beside one value.
  ParticleFile particles;
  particles.solid_position = pred.position;
  particles.solid_volume = pred.volume;
  particles.solid_driver = {0, 0};
  particles.driving_position = {Vec3f(1, 0, 0)};
  particles.driving_volume = {2};
  write_particles(folder / "particles.h5", particles, "{}");
  expect_error(Failure::kInput, {"bare.h5", "position", "no particles.h5 of as many samples"},
               [&] { evaluate_material(folder / "bare.h5", folder / "truth.h5"); });
}

TEST(AssertMetrics, ReportsWhatDoesNotHoldAndRefusesWhatItCannotRead) {
  const json metrics = {{"psnr", 28.5},
                        {"ssim", nullptr},
                        {"identical", false},
                        {"tip", {{"peak", 0.2}}},
                        {"per_image", {{"a.b", {{"psnr", 5}}}}}};
  EXPECT_TRUE(
      assert_metrics(metrics, {"psnr>=28.5", "psnr > 28", "psnr<29", "psnr <= 28.5", "psnr==28.5", "tip.peak>=0.1"})
          .empty());
  const auto failures = assert_metrics(metrics, {"psnr>=30", "tip.peak<0.1", "ssim>=0", "per_image.a.b.psnr>=6"});
  ASSERT_EQ(failures.size(), 4u);
  EXPECT_EQ(failures[0], "psnr is 28.5 but psnr>=30 was required");
  EXPECT_NE(failures[2].find("undefined"), std::string::npos);
  expect_error(Failure::kUsage, {"psmr", "'psnr'"}, [&] { assert_metrics(metrics, {"psmr>=3"}); });
  for (const char* bad :
       {"psnr", "psnr>=", "psnr>=high", "psnr=>3", "psnr=3", ">=3", "psnr>=nan", "tip>=1", "identical>=1"}) {
    expect_error(Failure::kUsage, {"--assert"}, [&] { assert_metrics(metrics, {bad}); });
  }
}

}  // namespace
}  // namespace pliant

#include "segmentation/models/yolox.h"

#include <gtest/gtest.h>

#include "gaussians/io/files/files.h"
#include "segmentation/models/boxes.h"
#include "segmentation/models/make_models.h"
#include "segmentation/models/picture.h"
#include "tests/segmentation/models/made_yolox.h"
#include "tests/temporary_folder.h"

using namespace pliant;

namespace {

void paint(ImageF& picture, int x0, int y0, int x1, int y1, float red, float green, float blue) {
  for (int y = y0; y < y1; ++y)
    for (int x = x0; x < x1; ++x) {
      picture(x, y, 0) = red;
      picture(x, y, 1) = green;
      picture(x, y, 2) = blue;
    }
}

std::unique_ptr<Detector> made_detector(const TemporaryFolder& folder) {
  ModelChoice choice;
  choice.detector = folder.file("yolox.onnx", made_yolox());
  return make_detector(choice);
}

}  // namespace

TEST(Yolox, BoxesComeBackInPixelsOfThePictureWithScoreObjectnessTimesClass) {
  TemporaryFolder folder;
  const auto detector = made_detector(folder);
  EXPECT_EQ(detector->vocabulary(), (std::vector<std::string>{"leaf", "sky"}));
  ImageF picture(64, 48, 3);  // one pixel of the network is two of the picture
  paint(picture, 16, 32, 32, 48, 1, 0.75f, 0.5f);
  paint(picture, 48, 0, 64, 16, 0.75f, 0, 1);
  const std::vector<Detection> found = detector->detect(picture, {});
  ASSERT_EQ(found.size(), 2u);
  const ImageF small = resize_picture(picture, 32, 24);
  const auto mean = [&](int x0, int y0, int channel) {
    float sum = 0;
    for (int y = 0; y < 8; ++y)
      for (int x = 0; x < 8; ++x) sum += small(x0 + x, y0 + y, channel) / 64;
    return sum;
  };
  const Detection& leaf = found[0].label == "leaf" ? found[0] : found[1];
  const Detection& sky = found[0].label == "leaf" ? found[1] : found[0];
  EXPECT_EQ(leaf.label, "leaf");
  EXPECT_EQ(sky.label, "sky");
  EXPECT_NEAR(leaf.score, mean(8, 16, 0) * mean(8, 16, 1), 1e-4f);
  EXPECT_NEAR(sky.score, mean(24, 0, 0) * mean(24, 0, 2), 1e-4f);
  EXPECT_NEAR(leaf.x0, 16, 1e-3);
  EXPECT_NEAR(leaf.y0, 32, 1e-3);
  EXPECT_NEAR(leaf.x1, 32, 1e-3);
  EXPECT_NEAR(leaf.y1, 48, 1e-3);
  EXPECT_NEAR(sky.x0, 48, 1e-3);
  EXPECT_NEAR(sky.y0, 0, 1e-3);
  EXPECT_NEAR(sky.x1, 64, 1e-3);
  EXPECT_NEAR(sky.y1, 16, 1e-3);
}

TEST(Yolox, OnlyTheNamesAskedForAreFound) {
  TemporaryFolder folder;
  const auto detector = made_detector(folder);
  ImageF picture(32, 32, 3);
  paint(picture, 8, 8, 16, 16, 1, 1, 0);
  EXPECT_EQ(detector->detect(picture, {"leaf"}).size(), 1u);
  EXPECT_TRUE(detector->detect(picture, {"sky"}).empty());
  EXPECT_TRUE(detector->detect(picture, {"statue"}).empty());
}

TEST(Yolox, NamesOfClassesAreThoseGivenElseThoseBesideTheNetworkElseItsOwn) {
  TemporaryFolder folder;
  ModelChoice choice;
  choice.detector = folder.file("yolox.onnx", made_yolox());
  const auto names = [&] { return make_detector(choice)->vocabulary(); };
  EXPECT_EQ(names(), (std::vector<std::string>{"leaf", "sky"}));
  folder.file("yolox.txt", "bolt\nnut\n");
  EXPECT_EQ(names(), (std::vector<std::string>{"bolt", "nut"}));
  choice.vocabularies = {folder.file("mine.txt", "red screw\r\nblue screw\r\n")};
  EXPECT_EQ(names(), (std::vector<std::string>{"red screw", "blue screw"}));
  choice.vocabularies = {folder.file("three.txt", "a\nb\nc\n")};
  expect_error(Failure::kUsage, {"--vocabulary", "three.txt", "3 names", "2 classes"}, names);
  choice.tagger = "ram.pt";  // the list may be its tags
  EXPECT_EQ(names(), (std::vector<std::string>{"leaf", "sky"}));
}

TEST(Yolox, TheHashOfTheFileIsKept) {
  TemporaryFolder folder;
  const auto file = folder.file("yolox.onnx", made_yolox());
  EXPECT_EQ(NeuralModule(file, {}).file().sha256, sha256_of_file(file));
}

TEST(Boxes, OverlapIsThatOfRectangles) {
  Detection a{0, 0, 2, 2, 1, ""}, b{1, 1, 3, 3, 1, ""}, c{2, 0, 4, 2, 1, ""};
  EXPECT_FLOAT_EQ(box_iou(a, b), 1.f / 7);
  EXPECT_FLOAT_EQ(box_iou(a, c), 0);
  EXPECT_FLOAT_EQ(box_iou(a, a), 1);
}

TEST(Boxes, OfOverlappingBoxesOfOneNameTheBestStays) {
  const std::vector<Detection> kept = suppress_overlaps(
      {{0, 0, 10, 10, 0.5f, "a"}, {1, 0, 10, 10, 0.9f, "a"}, {0, 0, 10, 10, 0.4f, "b"}, {20, 0, 30, 10, 0.3f, "a"}},
      0.5f);
  ASSERT_EQ(kept.size(), 3u);
  EXPECT_FLOAT_EQ(kept[0].score, 0.9f);
  EXPECT_EQ(kept[1].label, "b");
  EXPECT_FLOAT_EQ(kept[2].x0, 20);
}

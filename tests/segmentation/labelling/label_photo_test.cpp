#include "segmentation/labelling/label_photo.h"

#include <gtest/gtest.h>

#include "gaussians/base/error.h"
#include "segmentation/labelling/grab_cut_segmenter.h"
#include "segmentation/labelling/label_set.h"
#include "segmentation/labelling/mask_measures.h"
#include "tests/segmentation/made_picture.h"

using namespace pliant;

namespace {

constexpr int kPhotoWidth = 160, kPhotoHeight = 120;
const MadeDisc kRed{45, 55, 22}, kBlue{115, 62, 18, Vec3f(0.1f, 0.2f, 0.85f)};

/// Knows where the discs are; red ones are "flower", blue ones "ball".
struct MadeDetector : Detector {
  std::vector<std::string> known, asked;
  float red_score = 0.9f;

  std::vector<Detection> detect(const ImageF&, const std::vector<std::string>& names) override {
    asked = names;
    std::vector<Detection> all = {{23, 33, 67, 77, red_score, "flower"},
                                  {97, 44, 133, 80, 0.8f, "ball"},
                                  {98, 44, 134, 81, 0.6f, "cup"},
                                  {0, 0, 30, 30, 0.1f, "cup"}};
    if (!names.empty())
      std::erase_if(all, [&](const Detection& d) { return !std::count(names.begin(), names.end(), d.label); });
    return all;
  }
  std::vector<std::string> vocabulary() const override { return known; }
};

struct MadeTagger : Tagger {
  std::vector<Tag> tags;
  std::vector<Tag> tag(const ImageF&) override { return tags; }
};

/// Everything inside a box is the thing; a point stands for the disc under it.
struct MadeSegmenter : PromptableSegmenter {
  int encoded = 0;
  void encode(const ImageF&) override { ++encoded; }
  std::vector<SegmentedMask> segment(const MaskPrompt& prompt) override {
    ImageF logits(kPhotoWidth, kPhotoHeight, 1, -4.0f);
    for (int y = 0; y < kPhotoHeight; ++y)
      for (int x = 0; x < kPhotoWidth; ++x) {
        bool in = prompt.box && x + 0.5f > prompt.box->x0 && x + 0.5f < prompt.box->x1 && y + 0.5f > prompt.box->y0 &&
                  y + 0.5f < prompt.box->y1;
        for (const auto& point : prompt.points)
          for (const MadeDisc& disc : {kRed, kBlue}) in |= disc.contains(point.x, point.y) && disc.contains(x, y);
        if (in) logits(x, y) = 4;
      }
    return {{logits, 0.95f}};
  }
};

const ImageF kPicture = made_picture(kPhotoWidth, kPhotoHeight, {kRed, kBlue});

}  // namespace

TEST(LabelPhoto, TheChainGivesNamesScoresAndIds) {
  MadeDetector detector;
  MadeTagger tagger;
  MadeSegmenter segmenter;
  tagger.tags = {{"flower", 0.9f}, {"ball", 0.8f}};
  const LabelledPhoto photo = label_photo({}, {&tagger, &detector, &segmenter}, kPicture);
  EXPECT_EQ(detector.asked, (std::vector<std::string>{"flower", "ball"}));
  EXPECT_EQ(segmenter.encoded, 1);
  ASSERT_EQ(photo.things.size(), 2u);
  EXPECT_EQ(photo.things[0].name, "flower");
  EXPECT_FLOAT_EQ(photo.things[0].score, 0.9f);
  EXPECT_EQ(photo.things[1].name, "ball");
  EXPECT_EQ(photo.ids(45, 55), 1u);
  EXPECT_EQ(photo.ids(115, 62), 2u);
  EXPECT_EQ(photo.ids(80, 10), 0u);
  EXPECT_EQ(photo.things[0].pixels, 44u * 44u);
}

TEST(LabelPhoto, WithoutATaggerAClosedDetectorIsAskedForAllItKnows) {
  MadeDetector detector;
  MadeSegmenter segmenter;
  detector.known = {"ball", "cup", "flower"};
  const LabelledPhoto photo = label_photo({}, {nullptr, &detector, &segmenter}, kPicture);
  EXPECT_TRUE(detector.asked.empty());
  EXPECT_EQ(photo.things.size(), 2u);  // the second box on the ball loses to the first, the fourth has a low score
}

TEST(LabelPhoto, TagsThatAClosedDetectorDoesNotKnowAreLeftOut) {
  MadeDetector detector;
  MadeTagger tagger;
  MadeSegmenter segmenter;
  detector.known = {"ball", "cup", "flower"};
  tagger.tags = {{"sky", 0.9f}, {"Balls", 0.8f}};
  label_photo({}, {&tagger, &detector, &segmenter}, kPicture);
  EXPECT_EQ(detector.asked, std::vector<std::string>{"ball"});

  // Where none is left nothing is looked for.
  tagger.tags.pop_back();
  const LabelledPhoto photo = label_photo({}, {&tagger, &detector, &segmenter}, kPicture);
  EXPECT_EQ(detector.asked, std::vector<std::string>{"ball"});
  EXPECT_TRUE(photo.things.empty());
  EXPECT_EQ(photo.ids.data, IdImage(kPhotoWidth, kPhotoHeight, 1).data);
}

TEST(LabelPhoto, TextBecomesTheNearestNameOfAClosedDetector) {
  MadeDetector detector;
  std::vector<std::string> said;
  EXPECT_EQ(names_for(detector, {"red flower"}, said), std::vector<std::string>{"red flower"});  // open vocabulary
  EXPECT_TRUE(said.empty());
  detector.known = {"ball", "potted plant", "flower"};
  EXPECT_EQ(names_for(detector, {"Flowers"}, said), std::vector<std::string>{"flower"});
  EXPECT_TRUE(said.empty());
  EXPECT_EQ(names_for(detector, {"red flower"}, said), std::vector<std::string>{"flower"});
  EXPECT_EQ(names_for(detector, {"plant"}, said), std::vector<std::string>{"potted plant"});
  EXPECT_EQ(names_for(detector, {"flowr"}, said), std::vector<std::string>{"flower"});
  EXPECT_EQ(said.size(), 3u);
  EXPECT_THROW(names_for(detector, {"zeppelin"}, said), Error);
}

TEST(LabelPhoto, EverythingModeFindsBothDiscsAndNothingElse) {
  MadeSegmenter segmenter;
  const LabelledPhoto photo = label_photo({}, {nullptr, nullptr, &segmenter}, kPicture);
  ASSERT_EQ(photo.things.size(), 2u);
  EXPECT_NE(photo.ids(45, 55), photo.ids(115, 62));
  EXPECT_EQ(photo.ids(80, 10), 0u);
}

TEST(LabelPhoto, EverythingModeWithoutWeightsFindsADiscOnATexturedGround) {
  GrabCutSegmenter segmenter;
  LabelOptions options;
  options.everything = EverythingOptions::weight_free();
  options.everything.points_per_side = 2;
  const LabelledPhoto photo =
      label_photo(options, {nullptr, nullptr, &segmenter}, made_picture(96, 72, {{26, 20, 14}}));
  ASSERT_GT(photo.ids(26, 20), 0u);
  ImageF found(96, 72, 1, -1.0f);
  for (size_t i = 0; i < found.data.size(); ++i)
    if (photo.ids.data[i] == photo.ids(26, 20)) found.data[i] = 1;
  EXPECT_GT(mask_iou(found, disc_mask(96, 72, {26, 20, 14})), 0.85f);
}

TEST(SuppressDuplicates, KeepsTheBetterOfTwoThatOverlap) {
  const std::vector<MaskPrompt::Box> boxes = {{0, 0, 10, 10}, {1, 0, 11, 10}, {30, 0, 40, 10}};
  EXPECT_EQ(suppress_duplicates(boxes, {0.5f, 0.9f, 0.7f}, 0.7f), (std::vector<size_t>{1, 2}));
  EXPECT_EQ(suppress_duplicates(boxes, {0.5f, 0.9f, 0.7f}, 0.9f), (std::vector<size_t>{1, 2, 0}));
}

TEST(PaintMasks, ASmallThingLiesInFrontOfTheLargeOneAroundItAndElseTheBetterScoreWins) {
  const auto square = [](float x0, float y0, float x1, float y1, const char* name, float score) {
    ImageF logits(60, 40, 1, -1.0f);
    for (int y = static_cast<int>(y0); y < y1; ++y)
      for (int x = static_cast<int>(x0); x < x1; ++x) logits(x, y) = 1;
    return picture_mask(logits, name, score);
  };
  const LabelledPhoto photo = paint_masks(
      {}, 60, 40,
      {square(10, 10, 18, 18, "cup", 0.4f), square(0, 0, 40, 40, "table", 0.9f), square(30, 0, 50, 40, "chair", 0.8f)});
  ASSERT_EQ(photo.things.size(), 3u);
  EXPECT_EQ(photo.things[0].name, "table");
  EXPECT_EQ(photo.things[photo.ids(12, 12) - 1].name, "cup");
  EXPECT_EQ(photo.things[photo.ids(35, 20) - 1].name, "table");
  EXPECT_EQ(photo.things[photo.ids(45, 20) - 1].name, "chair");
  size_t pixels = 0;
  for (const LabelledThing& thing : photo.things) pixels += thing.pixels;
  EXPECT_EQ(pixels, 50u * 40u);
}

TEST(LabelSet, AThingOfANameHasOneIdInAllPhotosAndNamesFollowAnAssociation) {
  LabelledPhoto a, b;
  a.ids = b.ids = IdImage(4, 1, 1);
  a.ids.data = {1, 1, 2, 0};
  a.things = {{1, "dog", 0.9f, {}, 2}, {2, "ball", 0.5f, {}, 1}};
  b.ids.data = {1, 2, 2, 0};
  b.things = {{1, "ball", 0.9f, {}, 1}, {2, "dog", 0.5f, {}, 2}};
  const MaskSet masks = gather_labels({.rest = true}, {4, 7}, {a, b});
  EXPECT_EQ(masks.names.at(1), "rest");
  EXPECT_EQ(masks.views[0].ids.data, (std::vector<uint32_t>{2, 2, 3, 1}));
  EXPECT_EQ(masks.views[1].ids.data, (std::vector<uint32_t>{3, 2, 2, 1}));
  EXPECT_EQ(masks.views[1].camera, 7);
  MaskSet after = masks;
  for (auto& view : after.views)
    for (uint32_t& id : view.ids.data) id += 10;
  after.views[0].ids.data[0] = 99;  // a second dog
  const auto names = carried_names(masks, after);
  EXPECT_EQ(names.at(12), "dog");
  EXPECT_EQ(names.at(99), "dog 2");
  EXPECT_EQ(names.at(13), "ball");
  EXPECT_EQ(names.at(11), "rest");
}

TEST(LabelSet, NamesThatEndInANumberStayWhereNoneIsWithoutIt) {
  MaskSet masks;
  masks.names = {{1, "plant 1"}, {2, "toy 2"}, {3, "toy 3"}, {4, "toy 7"}, {5, "chair"}, {6, "chair 2"}};
  masks.views.push_back({0, IdImage(12, 1, 1)});
  masks.views[0].ids.data = {1, 2, 3, 3, 3, 4, 4, 5, 6, 6, 6, 0};
  EXPECT_EQ(carried_names(masks, masks), masks.names);
  MaskSet after = masks;
  after.names.clear();
  auto names = carried_names(masks, after);
  for (uint32_t id = 1; id <= 4; ++id) EXPECT_EQ(names.at(id), masks.names.at(id));
  EXPECT_EQ(names.at(6), "chair");  // numbered anew, from the largest on
  EXPECT_EQ(names.at(5), "chair 2");
  after.names = {{5, "chair"}};  // what is known is kept
  names = carried_names(masks, after);
  EXPECT_EQ(names.at(5), "chair");
  EXPECT_EQ(names.at(6), "chair 2");
}

TEST(LabelSet, WhatMostlyHasNoNameGetsNone) {
  MaskSet masks;
  masks.names = {{9, "flower"}};
  masks.views.push_back({0, IdImage(10, 1, 1)});
  masks.views[0].ids.data = {9, 9, 9, 9, 9, 9, 12, 12, 12, 12};
  MaskSet after = masks;
  after.names.clear();
  after.views[0].ids.data = {20, 20, 20, 20, 30, 30, 30, 30, 30, 30};  // two of six pixels were the flower's
  EXPECT_EQ(carried_names(masks, after), (std::map<uint32_t, std::string>{{20, "flower"}}));
}

TEST(LabelSet, TheRestIsTakenOutForAnAssociationAndPutBackWhereNothingElseIs) {
  MaskSet masks;
  masks.names = {{1, "rest"}, {2, "dog"}};
  masks.views.push_back({3, IdImage(4, 1, 1)});
  masks.views[0].ids.data = {1, 2, 0, 1};
  MaskSet things = masks;
  EXPECT_EQ(take_out_rest(things), 1u);
  EXPECT_EQ(things.views[0].ids.data, (std::vector<uint32_t>{0, 2, 0, 0}));
  EXPECT_EQ(things.names.count(1), 0u);
  things.views[0].ids.data[3] = 7;  // what an association may find out
  put_back_rest(masks, 1, things);
  EXPECT_EQ(things.views[0].ids.data, (std::vector<uint32_t>{1, 2, 0, 7}));
  EXPECT_EQ(things.names.at(1), "rest");
}

TEST(LabelSet, TheRestKeepsItsIdWhereAnAssociationHasGivenItToAThing) {
  MaskSet masks;
  masks.names = {{5, "rest"}};
  masks.views.push_back({3, IdImage(4, 1, 1)});
  masks.views[0].ids.data = {5, 2, 3, 5};
  MaskSet after = masks;
  after.names = {{5, "dog"}};
  after.views[0].ids.data = {0, 4, 5, 0};
  put_back_rest(masks, 5, after);
  EXPECT_EQ(after.views[0].ids.data, (std::vector<uint32_t>{5, 4, 6, 5}));
  EXPECT_EQ(after.names, (std::map<uint32_t, std::string>{{5, "rest"}, {6, "dog"}}));
}

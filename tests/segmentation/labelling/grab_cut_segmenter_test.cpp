#include "segmentation/labelling/grab_cut_segmenter.h"

#include <gtest/gtest.h>
#include <omp.h>

#include "gaussians/base/error.h"
#include "segmentation/labelling/mask_measures.h"
#include "tests/segmentation/made_picture.h"

using namespace pliant;

namespace {

constexpr int kWidth = 160, kHeight = 120;
const MadeDisc kDisc{70, 55, 24};
const MaskPrompt::Box kBox{46, 31, 94, 79};

std::vector<SegmentedMask> found(const MaskPrompt& prompt) {
  GrabCutSegmenter segmenter;
  segmenter.encode(made_picture(kWidth, kHeight, {kDisc}));
  return segmenter.segment(prompt);
}

}  // namespace

TEST(GrabCutSegmenter, ADiscOnATexturedGroundIsFoundFromItsBox) {
  const std::vector<SegmentedMask> masks = found({kBox, {}});
  ASSERT_EQ(masks.size(), 1u);
  EXPECT_GT(mask_iou(masks[0].logits, disc_mask(kWidth, kHeight, kDisc)), 0.93f);
  EXPECT_GT(masks[0].predicted_iou, 0.8f);
}

TEST(GrabCutSegmenter, ADiscIsFoundFromAPointOnIt) {
  const std::vector<SegmentedMask> masks = found({std::nullopt, {{64, 50, true}}});
  ASSERT_GE(masks.size(), 2u);
  EXPECT_GT(mask_iou(masks[0].logits, disc_mask(kWidth, kHeight, kDisc)), 0.9f);
  for (size_t k = 1; k < masks.size(); ++k) EXPECT_GE(masks[k - 1].predicted_iou, masks[k].predicted_iou);
}

TEST(GrabCutSegmenter, APointOfTheBackgroundIsLeftOut) {
  const MadeDisc other{108, 62, 12};
  GrabCutSegmenter segmenter;
  segmenter.encode(made_picture(kWidth, kHeight, {kDisc, other}));
  const MaskPrompt::Box both{46, 31, 120, 79};
  const MaskPrompt::Point away{108, 62, false};
  EXPECT_GT(segmenter.segment({both, {}})[0].logits(108, 62), 0);
  const ImageF without = segmenter.segment({both, {away}})[0].logits;
  EXPECT_LT(without(108, 62), 0);
  EXPECT_GT(without(60, 55), 0);
}

TEST(GrabCutSegmenter, LogitsAreNestedMasks) {
  const ImageF logits = found({kBox, {}})[0].logits;
  EXPECT_GE(stability(logits, 1), stability(logits, 2));
  for (int x = 0; x < kWidth; ++x) EXPECT_LT(logits(x, 2), -3);  // outside the box
  EXPECT_GT(logits(70, 55), 3);                                  // its middle
}

TEST(GrabCutSegmenter, APromptOutsideThePictureIsRefused) {
  GrabCutSegmenter segmenter;
  segmenter.encode(made_picture(kWidth, kHeight, {kDisc}));
  const std::vector<MaskPrompt> wrong = {{MaskPrompt::Box{200, 10, 240, 50}, {}},
                                         {MaskPrompt::Box{50, 50, 50, 90}, {}},
                                         {std::nullopt, {{10, -1, true}}},
                                         {std::nullopt, {{10, 10, false}}},
                                         {}};
  for (const MaskPrompt& prompt : wrong) try {
      segmenter.segment(prompt);
      ADD_FAILURE() << "a wrong prompt was taken";
    } catch (const Error& error) {
      EXPECT_EQ(error.failure, Failure::kUsage);
    }
}

TEST(GrabCutSegmenter, MasksAreEqualForAnyNumberOfThreads) {
  const int threads = omp_get_max_threads();
  omp_set_num_threads(1);
  const auto one = found({std::nullopt, {{64, 50, true}}});
  omp_set_num_threads(4);
  const auto four = found({std::nullopt, {{64, 50, true}}});
  omp_set_num_threads(threads);
  ASSERT_EQ(one.size(), four.size());
  for (size_t k = 0; k < one.size(); ++k) EXPECT_EQ(one[k].logits.data, four[k].logits.data);
}

TEST(MaskMeasures, PartsWithoutASeedAndSmallHolesTurn) {
  ImageF logits(20, 10, 1, -1);
  for (int y = 2; y < 8; ++y)
    for (int x = 2; x < 10; ++x) logits(x, y) = 1;
  logits(5, 5) = -1;
  logits(15, 5) = 1;
  std::vector<uint8_t> wanted(logits.data.size(), 0);
  wanted[3 * 20 + 3] = 1;
  tidy_parts(wanted, 0.1f, 0.1f, logits);
  EXPECT_GT(logits(5, 5), 0);
  EXPECT_LT(logits(15, 5), 0);
  EXPECT_GT(logits(2, 2), 0);
  EXPECT_LT(logits(0, 0), 0);
}

TEST(MaskMeasures, BoxesAndMasksOverlapByTheirAreas) {
  EXPECT_FLOAT_EQ(box_iou({0, 0, 2, 2}, {1, 0, 3, 2}), 1.0f / 3);
  EXPECT_FLOAT_EQ(box_iou({0, 0, 1, 1}, {2, 2, 3, 3}), 0);
  const ImageF mask = disc_mask(40, 30, {20, 15, 6});
  EXPECT_FLOAT_EQ(mask_iou(mask, mask), 1);
  const MaskPrompt::Box box = box_of_mask(mask);
  EXPECT_FLOAT_EQ(box_iou(box, {14, 9, 26, 21}), 1);
}

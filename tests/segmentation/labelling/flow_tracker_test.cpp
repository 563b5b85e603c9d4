#include "segmentation/labelling/flow_tracker.h"

#include <gtest/gtest.h>
#include <omp.h>

#include "gaussians/base/error.h"
#include "segmentation/labelling/mask_measures.h"
#include "tests/segmentation/made_picture.h"

using namespace pliant;

namespace {

constexpr int kFrameWidth = 128, kFrameHeight = 80;
constexpr uint32_t kId = 700;

MadeDisc disc_at(float x) { return {x, 42, 14}; }
ImageF picture_at(float x) { return made_picture(kFrameWidth, kFrameHeight, {disc_at(x)}); }

IdImage ids_at(float x, uint32_t id = kId) {
  IdImage ids(kFrameWidth, kFrameHeight, 1);
  for (int j = 0; j < kFrameHeight; ++j)
    for (int i = 0; i < kFrameWidth; ++i)
      if (disc_at(x).contains(i, j)) ids(i, j) = id;
  return ids;
}

float iou_of(const IdImage& ids, uint32_t id, float x) {
  ImageF mask(kFrameWidth, kFrameHeight, 1, -1.0f);
  for (size_t i = 0; i < mask.data.size(); ++i)
    if (ids.data[i] == id) mask.data[i] = 1;
  return mask_iou(mask, disc_mask(kFrameWidth, kFrameHeight, disc_at(x)));
}

}  // namespace

TEST(FlowTracker, FollowsAMovingDisc) {
  for (const float speed : {4.0f, 6.0f, 9.0f}) {
    FlowTracker tracker;
    tracker.start(picture_at(30), ids_at(30));
    for (int k = 1; k <= 8; ++k) {
      const float x = 30 + speed * static_cast<float>(k);
      const TrackedFrame frame = tracker.step(picture_at(x));
      EXPECT_TRUE(frame.lost.empty());
      EXPECT_GT(iou_of(frame.ids, kId, x), 0.85f) << speed << " px, picture " << k;
    }
  }
}

TEST(FlowTracker, SaysThatADiscIsLostWhenItLeavesAndKnowsItsIdWhenItComesBack) {
  FlowTracker tracker;
  tracker.start(picture_at(100), ids_at(100));
  float x = 100;
  TrackedFrame frame;
  while (x < 160) frame = tracker.step(picture_at(x += 6));
  EXPECT_EQ(frame.lost, std::vector<uint32_t>{kId});
  EXPECT_EQ(std::count(frame.ids.data.begin(), frame.ids.data.end(), kId), 0);
  EXPECT_EQ(tracker.step(picture_at(160)).lost, std::vector<uint32_t>{kId});
  while (x > 80) frame = tracker.step(picture_at(x -= 6));
  EXPECT_TRUE(frame.lost.empty());
  EXPECT_GT(iou_of(frame.ids, kId, x), 0.85f);
}

TEST(FlowTracker, DetectionsCorrectWhatTheyOverlapAndOthersAreFollowedUnderIdsOfTheirOwn) {
  FlowTracker tracker;
  const ImageF picture = made_picture(kFrameWidth, kFrameHeight, {disc_at(30), disc_at(90)});
  IdImage loose = ids_at(30);
  for (int i = 30; i < 50; ++i)
    for (int j = 40; j < 44; ++j) loose(i, j) = kId;
  tracker.start(picture, loose);
  IdImage detections = ids_at(30, 4);
  const IdImage other = ids_at(90, kId);  // an id that is taken
  for (size_t i = 0; i < other.data.size(); ++i) detections.data[i] += other.data[i];
  const TrackedFrame frame = tracker.add(detections);
  EXPECT_FLOAT_EQ(iou_of(frame.ids, kId, 30), 1);
  EXPECT_EQ(frame.ids(30, 42), kId);
  EXPECT_NE(frame.ids(90, 42), kId);
  EXPECT_NE(frame.ids(90, 42), 0u);
  EXPECT_NE(frame.ids(90, 42), 4u);
}

TEST(FlowTracker, ALostThingIsPromptedAnewByAdd) {
  FlowTracker tracker;
  tracker.start(picture_at(30), ids_at(30));
  EXPECT_EQ(tracker.step(made_picture(kFrameWidth, kFrameHeight, {})).lost, std::vector<uint32_t>{kId});
  FlowTracker other = tracker;
  EXPECT_EQ(tracker.add(ids_at(60)).lost.size(), 0u);  // by its id
  other.step(made_picture(kFrameWidth, kFrameHeight, {disc_at(60)}));
  EXPECT_EQ(other.add(ids_at(60, 5)).ids(60, 42), kId);  // by its colours
}

TEST(FlowTracker, RefusesAPictureOfAnotherSize) {
  FlowTracker tracker;
  tracker.start(picture_at(30), ids_at(30));
  EXPECT_THROW(tracker.step(made_picture(kFrameWidth, kFrameHeight + 2, {})), Error);
}

TEST(FlowTracker, IsEqualForAnyNumberOfThreads) {
  const auto followed = [](int threads) {
    omp_set_num_threads(threads);
    FlowTracker tracker;
    tracker.start(picture_at(30), ids_at(30));
    tracker.step(picture_at(35));
    return tracker.step(picture_at(41)).ids.data;
  };
  const int threads = omp_get_max_threads();
  const auto one = followed(1), three = followed(3);
  omp_set_num_threads(threads);
  EXPECT_EQ(one, three);
}

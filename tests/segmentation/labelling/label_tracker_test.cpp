// Ids and names through a sequence in which things come and go.

#include "segmentation/labelling/label_tracker.h"

#include <gtest/gtest.h>

#include <set>

#include "segmentation/labelling/flow_tracker.h"
#include "tests/segmentation/made_picture.h"

using namespace pliant;

namespace {

constexpr int kWide = 128, kHigh = 80;

struct NamedDisc {
  std::string name;
  MadeDisc disc;
};

/// Knows the discs of the photo, in order of their scores.
struct DiscDetector : Detector {
  std::vector<NamedDisc> shown;

  std::vector<Detection> detect(const ImageF&, const std::vector<std::string>&) override {
    std::vector<Detection> found;
    float score = 1;
    for (const auto& [name, disc] : shown)
      found.push_back({disc.x - disc.radius, disc.y - disc.radius, disc.x + disc.radius, disc.y + disc.radius,
                       score -= 0.1f, name});
    return found;
  }
  std::vector<std::string> vocabulary() const override { return {"apple", "ball", "lemon"}; }
};

/// The disc that fills the box.
struct DiscSegmenter : PromptableSegmenter {
  void encode(const ImageF&) override {}
  std::vector<SegmentedMask> segment(const MaskPrompt& prompt) override {
    const MaskPrompt::Box& box = *prompt.box;
    return {{disc_mask(kWide, kHigh, {(box.x0 + box.x1) / 2, (box.y0 + box.y1) / 2, (box.x1 - box.x0) / 2}), 0.9f}};
  }
};

}  // namespace

TEST(LabelTracker, ANewThingHasNeitherTheIdNorTheNameOfALostOne) {
  const auto apple = [](float x) { return NamedDisc{"apple", {x, 42, 14}}; };
  const auto ball = [](float x) { return NamedDisc{"ball", {x, 45, 12, Vec3f(0.1f, 0.2f, 0.85f)}}; };
  const auto lemon = [](float x) { return NamedDisc{"lemon", {x, 20, 11, Vec3f(0.9f, 0.85f, 0.1f)}}; };
  DiscDetector detector;
  DiscSegmenter segmenter;
  FlowTracker tracker;
  LabelTracker labels({}, {nullptr, &detector, &segmenter}, tracker, 8);
  std::vector<IdImage> ids;
  for (const std::vector<NamedDisc>& shown : std::vector<std::vector<NamedDisc>>{
           {apple(30), ball(100)}, {apple(32), ball(99)}, {apple(34), lemon(70)}, {apple(36), lemon(71)}}) {
    detector.shown = shown;
    std::vector<MadeDisc> discs;
    for (const NamedDisc& thing : shown) discs.push_back(thing.disc);
    ids.push_back(labels.next(made_picture(kWide, kHigh, discs)));
  }
  const uint32_t red = ids[0](30, 42), blue = ids[0](100, 45), yellow = ids[2](70, 20);
  EXPECT_EQ((std::set<uint32_t>{0, red, blue, yellow}).size(), 4u);
  EXPECT_EQ(ids[2](34, 42), red);
  EXPECT_EQ(ids[3](36, 42), red);
  EXPECT_EQ(ids[3](71, 20), yellow);
  EXPECT_EQ(labels.names(), (std::map<uint32_t, std::string>{{red, "apple"}, {blue, "ball"}, {yellow, "lemon"}}));
}

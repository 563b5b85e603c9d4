// What is compared in a part of a picture is what would be compared there in the whole picture.

#include <gtest/gtest.h>

#include "fitting/objective/clip_objective.h"
#include "fitting/objective/flow_loss.h"
#include "tests/fitting/made_motion.h"

namespace pliant {
namespace {

using namespace fixture;

constexpr int kX = 24, kY = 20, kWidth = 18, kHeight = 20, kBorder = 6;  // px; the border does not count

template <class T>
Image<T> part_of(const Image<T>& from) {
  Image<T> part(kWidth, kHeight, from.channels);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) std::copy_n(from.at(kX + x, kY + y), from.channels, part.at(x, y));
  return part;
}

struct PartOfPicture : testing::Test {
  Motion<double> motion = swinging_block<double>(2);
  std::shared_ptr<DrawnObject<double>> drawn = drawn_block<double>(motion.particles, 60, 0.1);
  Camera camera = block_camera(64, 56, 0.1);
  PicturePart part = cropped(camera, kX, kY, kWidth, kHeight);
  std::vector<BasicSimulationState<double>> frames =
      rollout<double>(motion.options, motion.particles, motion.interactions, motion.start).frames;
  Image<double> weight{64, 56, 1};

  PartOfPicture() {
    for (int y = kY + kBorder; y < kY + kHeight - kBorder; ++y)
      for (int x = kX + kBorder; x < kX + kWidth - kBorder; ++x) weight(x, y) = 0.5 + 0.01 * x;
  }
  /// Relative difference of derivatives by the places of the particles.
  static double difference(const StateGradient<double>& a, const StateGradient<double>& b) {
    double size = 0, difference = 0;
    for (size_t i = 0; i < a.x.size(); ++i) {
      size += a.x[i].norm() + a.F[i].norm();
      difference += (a.x[i] - b.x[i]).norm() + (a.F[i] - b.F[i]).norm();
    }
    return difference / size;
  }
};

TEST_F(PartOfPicture, PicturesDifferAsInTheWhole) {
  SeenFrames<double> whole = film<double, false>(swinging_block<double>(2, 1e4, 0.8), *drawn, camera);
  whole.weight = {weight};
  SeenFrames<double> seen;
  seen.camera = part.camera;
  seen.frame = part.frame;
  for (const Image<double>& frame : whole.frames) seen.frames.push_back(part_of(frame));
  seen.weight = {part_of(weight)};
  const PictureLossOptions options{.photometric = {0.1, 0.9}, .weight_mse = 1};
  const auto loss = [&](const SeenFrames<double>& of, StateGradient<double>& gradient) {
    const PictureLoss<double, false> term(options, drawn, of);
    const double value = term.value(2, frames[2]);
    EXPECT_NEAR(term.value_adjoint(2, frames[2], 1, gradient), value, 1e-12);
    return value;
  };
  const auto zero = [&] { return StateGradient<double>::zero(motion.particles.size()); };
  StateGradient<double> by_whole = zero(), by_part = zero(), by_unframed = zero();
  const double a = loss(whole, by_whole), b = loss(seen, by_part);
  EXPECT_GT(a, 1e-4);
  EXPECT_NEAR(b, a, 1e-8 * a);
  EXPECT_LT(difference(by_whole, by_part), 1e-8);
  seen.frame.reset();
  EXPECT_GT(std::abs(loss(seen, by_unframed) - a), 1e-6 * a);
  EXPECT_GT(difference(by_whole, by_unframed), 1e-6);
}

TEST_F(PartOfPicture, FlowDiffersAsInTheWhole) {
  SeenFlow<double> whole, seen;
  whole.camera = camera;
  seen.camera = part.camera;
  seen.frame = part.frame;
  auto& pair = whole.pairs.emplace_back();
  pair.from = 1;
  pair.to = 2;
  pair.flow = Image<double>(64, 56, 2);
  pair.weight = weight;
  seen.pairs = whole.pairs;
  seen.pairs[0].flow = part_of(pair.flow);
  seen.pairs[0].weight = part_of(weight);
  const auto loss = [&](const SeenFlow<double>& of, std::vector<StateGradient<double>>& gradient) {
    gradient.assign(frames.size(), StateGradient<double>::zero(motion.particles.size()));
    return FlowLoss<double, false>(drawn, of, 1).value_adjoint(frames, 1, gradient);
  };
  std::vector<StateGradient<double>> by_whole, by_part, by_unframed;
  const double a = loss(whole, by_whole), b = loss(seen, by_part);
  EXPECT_GT(a, 1e-6);
  EXPECT_NEAR(b, a, 1e-8 * a);
  for (const int f : {1, 2}) EXPECT_LT(difference(by_whole[f], by_part[f]), 1e-8) << f;
  seen.frame.reset();
  EXPECT_GT(std::abs(loss(seen, by_unframed) - a), 1e-7 * a);
}

TEST_F(PartOfPicture, CuttingAClipKeepsTheFrameOfTheWhole) {
  const std::vector<ImageF> pictures(3, ImageF(64, 56, 3, 0.5f));
  ImageF counted(64, 56, 1, 0.0f);
  for (int y = 16; y < 40; ++y)
    for (int x = 20; x < 44; ++x) counted(x, y) = 1;
  const SeenFrames<float> seen = cut_to_weight(camera, pictures, {&counted, 1});
  EXPECT_EQ(seen.camera.width, 24 + 2 * kBorder);
  const SeenFlow<float> flow = flow_of_clip(seen, {0, 2, 0, 1, 100});
  for (const auto& frame : {seen.frame, flow.frame}) {
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->x, 20 - kBorder);
    EXPECT_EQ(frame->y, 16 - kBorder);
    EXPECT_EQ(frame->width, 64);
    EXPECT_EQ(frame->height, 56);
  }
}

}  // namespace
}  // namespace pliant

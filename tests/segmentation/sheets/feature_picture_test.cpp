// Colours of the semantic attribute: its principal components, the same however the attribute space is turned.

#include "segmentation/sheets/feature_picture.h"

#include <gtest/gtest.h>

#include <Eigen/QR>

#include "tests/segmentation/made_scene.h"

namespace pliant {
namespace {

constexpr int kY = kSemanticChannels;
using Square = Eigen::Matrix<float, kY, kY>;

/// Samples with standard deviations 3, 2, 1 and 0.2 along axes that are not those of the channels, skewed to one side.
std::vector<float> skewed_samples(size_t n, const Square& turn) {
  std::vector<float> samples;
  for (size_t i = 0; i < n; ++i) {
    Random random(7, i, 0);
    Eigen::Matrix<float, kY, 1> y;
    for (int k = 0; k < kY; ++k) {
      const double draw = random.normal();
      y[k] = static_cast<float>((k == 0 ? 3.0 : k == 1 ? 2.0 : k == 2 ? 1.0 : 0.2) * (draw + 0.3 * draw * draw));
    }
    y = turn * y;
    samples.insert(samples.end(), y.data(), y.data() + kY);
  }
  return samples;
}

Square a_rotation(uint64_t seed) {
  Random random(seed);
  Square m;
  for (int i = 0; i < m.size(); ++i) m.data()[i] = static_cast<float>(random.normal());
  return Eigen::HouseholderQR<Square>(m).householderQ();
}

TEST(FeaturePicture, AxesAreThoseOfLargestVarianceInOrder) {
  const std::vector<float> samples = skewed_samples(4000, Square::Identity());
  const PrincipalColors colors = PrincipalColors::of(samples);
  for (int k = 0; k < 3; ++k) EXPECT_GT(colors.axes(k, k), 0.98) << k;  // positive: the longer tail is bright
  EXPECT_LT((colors.axes.transpose() * colors.axes - Mat3d::Identity()).norm(), 1e-9);
}

TEST(FeaturePicture, ColoursDoNotChangeWhenTheAttributeSpaceIsTurnedOrMirrored) {
  const Square turn = a_rotation(3);
  Square mirror = turn;
  mirror.col(2) *= -1;
  const std::vector<float> a = skewed_samples(3000, Square::Identity()), b = skewed_samples(3000, turn),
                           c = skewed_samples(3000, mirror);
  const PrincipalColors of_a = PrincipalColors::of(a), of_b = PrincipalColors::of(b), of_c = PrincipalColors::of(c);
  for (size_t i = 0; i < a.size(); i += kY) {
    EXPECT_LT((of_a.color(a.data() + i) - of_b.color(b.data() + i)).norm(), 1e-4f);
    EXPECT_LT((of_a.color(a.data() + i) - of_c.color(c.data() + i)).norm(), 1e-4f);
  }
}

TEST(FeaturePicture, AnAttributeWithoutVarianceIsGrey) {
  const std::vector<float> samples(50 * kY, 0.7f);
  EXPECT_EQ(PrincipalColors::of(samples).color(samples.data()), Vec3f(0.5f, 0.5f, 0.5f));
}

TEST(FeaturePicture, TwoObjectsShowInTwoColoursWhereTheyAre) {
  const MadeScene scene = made_scene(two_balls(), 2);
  std::vector<float> attribute(scene.cloud.size() * kY, 0.0f);
  for (size_t p = 0; p < scene.cloud.size(); ++p)
    attribute[p * kY + (scene.truth[p] == 300 ? 3 : scene.truth[p] == 70000 ? 9 : 0)] = 2;
  const auto black = [&](int c) { return ImageF(scene.cameras[c].width, scene.cameras[c].height, 3); };
  const ImageF sheet = features_sheet(attribute, scene.cloud, scene.cameras, black, false, 1);
  const IdImage ids = cast_ids(scene, scene.cameras[0]);
  // Mean colour of every id: all three are far apart, and the empty sky is black.
  std::map<uint32_t, std::pair<Vec3f, int>> mean;
  for (int y = 0; y < ids.height; ++y)
    for (int x = 0; x < ids.width; ++x) {
      auto& [sum, count] = mean.try_emplace(ids(x, y), Vec3f::Zero(), 0).first->second;
      sum += Eigen::Map<const Vec3f>(sheet.at(8 + x, 16 + ids.height + y));
      ++count;
    }
  for (auto& [id, entry] : mean) entry.first /= static_cast<float>(entry.second);
  EXPECT_LT(mean[0].first.norm(), 0.15f);
  EXPECT_GT((mean[300].first - mean[70000].first).norm(), 0.5f);
  EXPECT_GT((mean[300].first - mean[MadeScene::kTable].first).norm(), 0.5f);
}

TEST(FeaturePicture, LargePhotosAreRenderedAtTheSizeOfTheSheet) {
  const MadeScene scene = made_scene(two_balls(), 2);
  std::vector<float> attribute(scene.cloud.size() * kY, 0.0f);
  for (size_t p = 0; p < scene.cloud.size(); ++p) attribute[p * kY + (scene.truth[p] == 300 ? 3 : 0)] = 2;
  std::vector<Camera> large, shown;
  for (const Camera& camera : scene.cameras) {
    large.push_back(camera.resized(1920, 1440));
    shown.push_back(large.back().resized(480, 360));
  }
  const auto black = [](int) { return ImageF(48, 36, 3); };
  EXPECT_EQ(features_sheet(attribute, scene.cloud, large, black).data,
            features_sheet(attribute, scene.cloud, shown, black).data);
}

}  // namespace
}  // namespace pliant

#include "fitting/distribution/local_features.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <sstream>

#include "fitting/distribution/object_corpus.h"
#include "fitting/distribution/support_paths.h"
#include "fitting/distribution/training_set.h"

namespace pliant {
namespace {

std::vector<float> features_of(const MaterialObject& o, const Vec3f& up = Vec3f::UnitZ()) {
  return local_features({o.samples, o.colour, o.part, up, {1e5, 1e6, 1e8}});
}

/// Largest difference of each feature over the samples.
std::vector<float> differences(const std::vector<float>& a, const std::vector<float>& b) {
  EXPECT_EQ(a.size(), b.size());
  std::vector<float> out(kFeatures);
  for (size_t i = 0; i < a.size(); ++i) out[i % kFeatures] = std::max(out[i % kFeatures], std::abs(a[i] - b[i]));
  return out;
}

/// An object of up to a thousand samples, so that every one is its own neighbourhood.
MaterialObject small_object(const std::string& family, uint64_t seed) {
  MaterialObject o = make_object(family, seed);
  std::vector<int> chosen;
  for (size_t i = 0; i < o.samples.size() && chosen.size() < 900; ++i) chosen.push_back(static_cast<int>(i));
  o.samples = o.samples.select(chosen);
  o.colour.resize(chosen.size());
  if (!o.part.empty()) o.part.resize(chosen.size());
  return o;
}

TEST(LocalFeatures, HaveANameEachAndAreFinite) {
  std::istringstream names{std::string(feature_names())};
  std::vector<std::string> each{std::istream_iterator<std::string>(names), {}};
  ASSERT_EQ(each.size(), static_cast<size_t>(kFeatures));
  EXPECT_EQ(each[kFirstPartFeature].substr(0, 5), "part_");
  EXPECT_EQ(each[kFirstPartFeature + kPartFeatures].substr(0, 5), "prior");
  EXPECT_EQ(each[kPriorFeature], "prior_typical");
  for (const char* family : {"flower", "cup", "cushion", "table"})
    for (const float f : features_of(make_object(family, 2))) ASSERT_TRUE(std::isfinite(f)) << family;
}

// Rounding may turn a neighbour into another one, so a few samples may differ; hardly any do.
TEST(LocalFeatures, StayWhenTheObjectIsMovedAndTurned) {
  const MaterialObject o = small_object("flower", 5);
  const std::vector<float> before = features_of(o);
  const Eigen::AngleAxisf about_up(1.1f, Vec3f::UnitZ());
  const Eigen::AngleAxisf over(0.7f, Vec3f(1, 2, 0).normalized());
  for (const Mat3f& turn : {Mat3f(about_up), Mat3f(over * about_up)}) {
    MaterialObject moved = o;
    for (Vec3f& x : moved.samples.position) x = turn * x + Vec3f(0.3f, -0.2f, 0.5f);
    const std::vector<float> after = features_of(moved, turn * Vec3f::UnitZ());
    size_t other = 0;
    for (size_t i = 0; i < before.size(); ++i) other += std::abs(before[i] - after[i]) > 2e-3f;
    EXPECT_LT(other, before.size() / 200);
  }
}

TEST(LocalFeatures, TellAnObjectThatLiesFromOneThatStands) {
  const MaterialObject o = small_object("flower", 5);
  const auto change = differences(features_of(o), features_of(o, Vec3f::UnitX()));
  EXPECT_GT(change[0], 0.3f);
}

TEST(LocalFeatures, ChangeByTheSizeInMetresInThreeNumbersOnly) {
  const MaterialObject o = small_object("bonsai", 3);
  MaterialObject large = o;
  for (Vec3f& x : large.samples.position) x *= 4;  // a power of two rounds nothing
  for (float& v : large.samples.volume) v *= 64;
  for (float& t : large.samples.thickness) t *= 4;
  const auto change = differences(features_of(o), features_of(large));
  std::istringstream names{std::string(feature_names())};
  for (const float c : change) {
    std::string name;
    names >> name;
    const bool in_metres = name == "log_size" || name == "thickness_in_metres";
    EXPECT_NEAR(c, in_metres ? std::log10(4.0f) : 0.0f, 2e-3f) << name;
  }
}

// A capture may be filled with any number of samples: what they say on average is the same.
TEST(LocalFeatures, ChangeLittleUnderDenserSampling) {
  const MaterialObject o = make_object("potted_plant", 4);
  MaterialObject dense = o;
  const size_t m = o.samples.size();
  const int copies = 4;
  dense.samples = {};
  dense.colour.clear();
  dense.part.clear();
  Random random(8);
  for (size_t i = 0; i < m; ++i)
    for (int c = 0; c < copies; ++c) {
      Vec3f x = o.samples.position[i];
      const double jitter = 0.15 * (o.samples.thickness[i] > 0 ? o.samples.thickness[i] : o.samples.spacing);
      for (float& k : x.reshaped()) k += static_cast<float>(jitter * random.normal());
      dense.samples.position.push_back(x);
      dense.samples.volume.push_back(o.samples.volume[i] / copies);
      dense.samples.thickness.push_back(o.samples.thickness[i]);
      dense.colour.push_back(o.colour[i]);
      if (!o.part.empty()) dense.part.push_back(o.part[i]);
    }
  const auto few = features_of(o), many = features_of(dense);
  // Means over the object, against how much a feature varies over objects.
  const TrainingSet set = make_training_set({24, 3, false, 1}, corpus_families(FamilyRole::kTrain));
  std::istringstream names{std::string(feature_names())};
  for (int c = 0; c < kFeatures; ++c) {
    double a = 0, b = 0, mean = 0, square = 0;
    for (size_t i = 0; i < m; ++i) a += few[i * kFeatures + c] / static_cast<double>(m);
    for (size_t i = 0; i < m * copies; ++i) b += many[i * kFeatures + c] / static_cast<double>(m * copies);
    const double rows = static_cast<double>(set.features.size() / kFeatures);
    for (size_t i = c; i < set.features.size(); i += kFeatures) {
      mean += set.features[i] / rows;
      square += set.features[i] * set.features[i] / rows;
    }
    std::string name;
    names >> name;
    EXPECT_LT(std::abs(a - b), 0.5 * std::sqrt(std::max(0.0, square - mean * mean)) + 1e-4) << name;
  }
}

TEST(LocalFeatures, PartsThatAreNotKnownAreOnePart) {
  MaterialObject o = small_object("flower", 6);
  o.part.clear();
  const auto unknown = features_of(o);
  o.part.assign(o.samples.size(), 3);
  EXPECT_EQ(unknown, features_of(o));
  for (size_t i = 0; i < o.samples.size(); ++i)
    for (int p = 0; p < kPartFeatures; ++p) ASSERT_EQ(unknown[i * kFeatures + kFirstPartFeature + p], 0.0f);
}

TEST(LocalFeatures, OneSampleIsAnObject) {
  MaterialObject o;
  o.samples.position = {{1, 2, 3}};
  o.samples.volume = {1e-6f};
  o.colour = {{0.5f, 0.5f, 0.5f}};
  for (const float f : features_of(o)) EXPECT_TRUE(std::isfinite(f));
}

// An inverted U of points half a unit high: the way along it, not the height, and the weight behind.
TEST(SupportPaths, FollowTheBodyAndCarryWhatLiesBehind) {
  std::vector<Vec3f> points;
  for (int i = 0; i <= 50; ++i) points.push_back({0, 0, 0.01f * static_cast<float>(i)});
  for (int i = 1; i <= 50; ++i) points.push_back({0.01f * static_cast<float>(i), 0, 0.5f});
  for (int i = 1; i <= 20; ++i) points.push_back({0.5f, 0, 0.5f - 0.01f * static_cast<float>(i)});
  std::vector<float> volume(points.size(), 2.0f), height;
  for (const Vec3f& x : points) height.push_back(x.z());
  const SupportPaths paths = support_paths(points, volume, height);
  // Corners are cut by the reach of the neighbours.
  EXPECT_NEAR(paths.length[40], 0.4f, 0.02f);
  EXPECT_NEAR(paths.length.back(), 1.2f, 0.06f);
  EXPECT_NEAR(paths.beyond.back(), 1.0f / 121.0f, 1e-6f);
  // All is carried by the support, and by a cross-section what lies behind it.
  const auto carried = [&](int from, int to) {
    return std::accumulate(paths.beyond.begin() + from, paths.beyond.begin() + to, 0.0f);
  };
  EXPECT_NEAR(carried(0, 2), 1.0f, 1e-4f);
  EXPECT_GT(*std::max_element(paths.beyond.begin() + 20, paths.beyond.begin() + 30), 0.65f);
}

TEST(SupportPaths, ReachPiecesThatTouchNothing) {
  const std::vector<Vec3f> points = {{0, 0, 0}, {0, 0, 0.1f}, {5, 0, 5}, {5, 0, 5.1f}};
  const SupportPaths paths = support_paths(points, std::vector<float>(4, 1.0f), std::vector<float>{0, 0.1f, 5, 5.1f});
  for (const float length : paths.length) EXPECT_TRUE(std::isfinite(length));
  EXPECT_GT(paths.length[2], 5.0f);
}

}  // namespace
}  // namespace pliant

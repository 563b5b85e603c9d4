// Samples hang together along a surface and not across the gap between two.

#include "physics/body/links.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <functional>
#include <set>

#include "gaussians/base/disjoint_sets.h"
#include "tests/physics/body/leaves.h"

namespace pliant {
namespace {

constexpr float kCell = 0.04f;

/// Two leaves, one above the other by three tenths of a cell.
struct TwoLeaves {
  GaussianCloud cloud;
  SolidSamples samples;
  int one;  // the first so many samples are those of the lower one

  explicit TwoLeaves(float length = 0.8f, float apart = 0.3f * kCell) {
    const Vec3f green(0.2f, 0.6f, 0.1f);
    fixture::add_leaf(0, length, 0, green, cloud);
    one = static_cast<int>(cloud.size());
    fixture::add_leaf(0, length, apart, green, cloud);
    samples = fixture::samples_at(cloud);
  }
  bool below(int i) const { return i < one; }

  /// A driver for the samples of either leaf in every stretch along them, of one and a half samples if not given.
  DrivingParticles straddling(float stretch = 0.015f) const {
    DrivingParticles drivers;
    drivers.cell_size = kCell;
    for (size_t i = 0; i < samples.size(); ++i) {
      const size_t d = static_cast<size_t>(samples.position[i].x() / stretch);
      while (drivers.size() <= d) {
        drivers.position.push_back(Vec3f::Zero());
        drivers.volume.push_back(0);
      }
      drivers.sample_driver.push_back(static_cast<int>(d));
      drivers.position[d] += samples.volume[i] * samples.position[i];
      drivers.volume[d] += samples.volume[i];
    }
    for (size_t d = 0; d < drivers.size(); ++d) drivers.position[d] /= drivers.volume[d];
    return drivers;
  }
};

std::function<bool(int, int)> predicate(const SampleLinks& links) {
  return [&links](int i, int k) { return links.linked(i, k); };
}

}  // namespace

TEST(Links, AreKeptByOtherDriversOfTheSameSamples) {
  const TwoLeaves leaves;
  const SampleLinks links(leaves.cloud, leaves.samples, kCell);
  DrivingParticles fine = leaves.straddling();
  separate_drivers(predicate(links), leaves.samples, fine);
  const auto fine_links = link_drivers(links, leaves.samples, 0.2f * kCell, fine);
  // A driver for every three of the fine ones along the leaves, in both leaves at first.
  DrivingParticles coarse = leaves.straddling(0.045f);
  const std::vector<int> straddling = coarse.sample_driver;
  const auto linked = [&](int i, int k) {
    const int a = fine.sample_driver[i], b = fine.sample_driver[k];
    return a == b ||
           std::binary_search(fine_links.begin(), fine_links.end(), std::array{std::min(a, b), std::max(a, b)});
  };
  const size_t before = coarse.size();
  EXPECT_EQ(separate_drivers(linked, leaves.samples, coarse), before) << "two for one";
  std::vector<int> below(coarse.size());
  for (size_t i = 0; i < leaves.samples.size(); ++i) below[coarse.sample_driver[i]] = leaves.below(static_cast<int>(i));
  DisjointSets leaf(coarse.size());
  for (const auto& [a, b] : inherited_links(fine.sample_driver, fine_links, coarse.sample_driver)) {
    EXPECT_LT(a, b);
    EXPECT_EQ(below[a], below[b]);
    leaf.join(a, b);
  }
  for (size_t a = 0; a < coarse.size(); ++a)
    for (size_t b = 0; b < a; ++b)
      EXPECT_EQ(leaf.find(static_cast<int>(a)) == leaf.find(static_cast<int>(b)), below[a] == below[b]);
}

TEST(Links, LeadAlongALeafAndNotToTheNextOne) {
  const TwoLeaves leaves;
  const SampleLinks links(leaves.cloud, leaves.samples, kCell);
  for (int i = 0; i < static_cast<int>(leaves.samples.size()); ++i)
    for (int k = 0; k < i; ++k) {
      const float distance = (leaves.samples.position[i] - leaves.samples.position[k]).norm();
      EXPECT_EQ(links.linked(i, k), leaves.below(i) == leaves.below(k) && distance <= links.reach());
    }
}

TEST(Links, InTheBulkNearnessDecides) {
  TwoLeaves leaves;
  leaves.samples.thickness.clear();
  const SampleLinks links(leaves.cloud, leaves.samples, kCell);
  EXPECT_TRUE(links.linked(0, leaves.one));
}

TEST(Links, NoDriverLiesInTwoLeaves) {
  const TwoLeaves leaves;
  const SampleLinks links(leaves.cloud, leaves.samples, kCell);
  DrivingParticles drivers = leaves.straddling();
  const size_t before = drivers.size();
  EXPECT_EQ(separate_drivers(predicate(links), leaves.samples, drivers), before);
  std::vector<std::set<bool>> in(drivers.size());
  std::vector<float> volume(drivers.size(), 0);
  for (size_t i = 0; i < leaves.samples.size(); ++i) {
    const int d = drivers.sample_driver[i];
    in[d].insert(leaves.below(static_cast<int>(i)));
    volume[d] += leaves.samples.volume[i];
  }
  for (size_t d = 0; d < drivers.size(); ++d) {
    EXPECT_EQ(in[d].size(), 1u);
    EXPECT_NEAR(drivers.volume[d], volume[d], 1e-9f);
    EXPECT_NEAR(drivers.position[d].z(), *in[d].begin() ? 0 : 0.3f * kCell, 1e-6f);
  }
}

TEST(Links, OfDriversLeaveOnePieceOneByItsShortestGapAndASmallOneByAll) {
  for (const float length : {0.8f, 0.3f}) {
    const TwoLeaves leaves(length);
    const SampleLinks links(leaves.cloud, leaves.samples, kCell);
    DrivingParticles drivers = leaves.straddling();
    separate_drivers(predicate(links), leaves.samples, drivers);
    std::vector<int> below(drivers.size());
    for (size_t i = 0; i < leaves.samples.size(); ++i)
      below[drivers.sample_driver[i]] = leaves.below(static_cast<int>(i));
    const auto across = [&](float reach) {
      int count = 0;
      for (const auto& [a, b] : link_drivers(links, leaves.samples, reach, drivers)) {
        EXPECT_LT(a, b);
        count += below[a] != below[b];
      }
      return count;
    };
    EXPECT_EQ(across(0.2f * kCell), 0);
    if (length > 0.5f)
      EXPECT_EQ(across(0.75f * kCell), 1);
    else
      EXPECT_GT(across(0.75f * kCell), static_cast<int>(drivers.size()) / 2);
  }
}

}  // namespace pliant

// A body is one body: what hangs together is found, gaps in a surface are closed, and those between surfaces are not.

#include "physics/body/pieces.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numeric>
#include <set>

#include "gaussians/base/random.h"
#include "physics/body/driving_particles.h"
#include "physics/body/interior_fill.h"
#include "tests/physics/body/leaves.h"

namespace pliant {
namespace {

using fixture::add_leaf;
using fixture::samples_at;

size_t pieces_of(const SolidSamples& samples, float reach) {
  return find_pieces(samples.position, samples.volume, reach).size();
}

const Vec3f kGreen(0.2f, 0.6f, 0.1f), kRed(0.9f, 0.1f, 0.1f);
constexpr float kStep = 0.025f;
const BridgeOptions kBridge{kStep, 0.15f, 0.05f};

}  // namespace

TEST(Pieces, AreJoinedByStepsNoLongerThanTheReachAndNumberedByWeight) {
  std::vector<Vec3f> points;
  for (int i = 0; i < 4; ++i) points.push_back(Vec3f(0.1f * i, 0, 0));
  for (int i = 0; i < 3; ++i) points.push_back(Vec3f(1 + 0.1f * i, 0, 0));
  const std::vector<float> weight = {1, 1, 1, 1, 2, 2, 2};
  const Pieces apart = find_pieces(points, weight, 0.11f);
  EXPECT_EQ(apart.piece, (std::vector<int>{1, 1, 1, 1, 0, 0, 0}));
  EXPECT_EQ(apart.weight, (std::vector<double>{6, 4}));
  EXPECT_EQ(find_pieces(points, weight, 0.09f).size(), 7u);
  EXPECT_EQ(find_pieces(points, weight, 0.71f).size(), 1u);
  EXPECT_EQ(find_pieces({}, {}, 1).size(), 0u);
}

TEST(Pieces, AreThoseThatAllPairsOfPointsGive) {
  std::vector<Vec3f> points;
  for (int i = 0; i < 400; ++i) {
    Random random(7, i);
    points.push_back(Vec3f(random.uniform(-1, 1), random.uniform(-1, 1), 0.3 * random.uniform(-1, 1)));
  }
  const std::vector<float> weight(points.size(), 1);
  for (const float reach : {0.02f, 0.08f, 0.12f, 0.16f, 0.3f}) {
    // Labels spread from neighbour to neighbour until nothing changes.
    std::vector<int> label(points.size());
    std::iota(label.begin(), label.end(), 0);
    for (bool changed = true; changed;) {
      changed = false;
      for (size_t i = 0; i < points.size(); ++i)
        for (size_t k = 0; k < i; ++k)
          if (label[i] != label[k] && (points[i] - points[k]).norm() <= reach) {
            label[i] = label[k] = std::min(label[i], label[k]);
            changed = true;
          }
    }
    const Pieces pieces = find_pieces(points, weight, reach);
    EXPECT_EQ(pieces.size(), std::set<int>(label.begin(), label.end()).size()) << reach;
    for (size_t i = 0; i < points.size(); ++i) EXPECT_EQ(pieces.piece[i], pieces.piece[label[i]]) << reach << ' ' << i;
  }
}

TEST(Bridges, CloseAGapAlongASurfaceOfOneLook) {
  GaussianCloud cloud;
  add_leaf(0, 0.3f, 0, kGreen, cloud);
  add_leaf(0.4f, 0.2f, 0, kGreen, cloud);
  SolidSamples samples = samples_at(cloud);
  ASSERT_EQ(pieces_of(samples, kStep), 2u);
  const double volume = samples.total_volume();
  const BridgeSummary summary = bridge_gaps(kBridge, cloud, samples);
  EXPECT_EQ(pieces_of(samples, kStep), 1u);
  EXPECT_GE(summary.bridges, 2) << "a strip is joined across its width";
  EXPECT_LT(samples.total_volume(), 1.2 * volume);
  EXPECT_EQ(samples.thickness.size(), samples.size());
  for (size_t i = cloud.size(); i < samples.size(); ++i) EXPECT_NEAR(samples.position[i].z(), 0, 1e-6);
}

TEST(Bridges, HaveTheCrossSectionOfWhatTheyJoinAndOnlyWhereNoGaussianLies) {
  GaussianCloud cloud;
  add_leaf(0, 0.3f, 0, kGreen, cloud);
  add_leaf(0.4f, 0.2f, 0, kGreen, cloud);
  SolidSamples samples = samples_at(cloud);
  const double volume = samples.total_volume();
  bridge_gaps(kBridge, cloud, samples);
  // Four rows of samples .01 apart of 1e-6 each; the gap is .1 long, of which the Gaussians on either side reach over
  // .02.
  const double section = 4 * 1e-6 / 0.01;
  EXPECT_NEAR(samples.total_volume() - volume, 0.06 * section, 0.25 * 0.06 * section);
}

// Samples far apart in what the Gaussians show as one surface: it hangs together without a change of its mass.
TEST(Bridges, AddNoVolumeBetweenSamplesOfOneGaussian) {
  GaussianCloud cloud;
  add_leaf(0, 0.5f, 0, kGreen, cloud);
  SolidSamples samples;
  samples.spacing = 0.02f;
  for (float x = 0; x < 0.5f; x += 0.03f)
    for (const float y : {-0.03f, 0.0f, 0.03f}) samples.position.push_back(Vec3f(x, y, 0));
  for (size_t i = 0; i < samples.size(); ++i) samples.volume.push_back(1e-6f * static_cast<float>(1 + i % 3));
  const double volume = samples.total_volume();
  ASSERT_EQ(pieces_of(samples, kStep), samples.size());
  bridge_gaps(kBridge, cloud, samples);
  EXPECT_EQ(pieces_of(samples, kStep), 1u);
  EXPECT_NEAR(samples.total_volume(), volume, 1e-5 * volume);
  for (const float v : samples.volume) EXPECT_GT(v, 0);
}

TEST(Bridges, DoNotJoinWhatLooksOrFacesAnotherWayOrIsFar) {
  const auto joined = [](float begin, float height, const Vec3f& color) {
    GaussianCloud cloud;
    add_leaf(0, 0.3f, 0, kGreen, cloud);
    add_leaf(begin, 0.2f, height, color, cloud);
    SolidSamples samples = samples_at(cloud);
    EXPECT_EQ(pieces_of(samples, kStep), 2u);
    bridge_gaps(kBridge, cloud, samples);
    return pieces_of(samples, kStep) == 1;
  };
  EXPECT_TRUE(joined(0.4f, 0, kGreen));
  EXPECT_FALSE(joined(0.4f, 0, kRed)) << "another thing";
  EXPECT_FALSE(joined(0.05f, 0.1f, kGreen)) << "a leaf above another one";
  EXPECT_FALSE(joined(0.5f, 0, kGreen)) << "too far";
  EXPECT_TRUE(joined(0.33f, 0, kRed)) << "as near as what touches";
}

// A leaf of few long Gaussians, whose centres are farther apart than the cells that it is filled with.
TEST(OneBody, OfFewLongGaussiansHangsTogetherInSamplesAndDrivers) {
  GaussianCloud cloud;
  for (int k = 0; k < 12; ++k) {
    const float angle = 0.12f * static_cast<float>(k);  // an arc of radius .5
    cloud.resize(k + 1);
    cloud.position[k] = 0.5f * Vec3f(std::sin(angle), 0, std::cos(angle));
    cloud.rotation[k] = quaternion_wxyz(Mat3f(Eigen::AngleAxisf(angle, Vec3f::UnitY()).toRotationMatrix()));
    cloud.log_scale[k] = Vec3f(0.03f, 0.006f, 0.0005f).array().log();
    cloud.opacity_logit[k] = 3;
  }
  FillOptions options;
  options.target_count = 4000;
  const SolidSamples samples = fill_interior(options, cloud);
  DriverOptions wanted;
  wanted.count = 300;
  const DrivingParticles drivers = kmeans_drivers(wanted, samples);
  EXPECT_EQ(pieces_of(samples, 0.6f * drivers.cell_size), 1u);
  EXPECT_EQ(find_pieces(drivers.position, drivers.volume, drivers.cell_size).size(), 1u);
  // No sample of a thin part is far from the driver that moves it.
  for (size_t i = 0; i < samples.size(); ++i)
    EXPECT_LT((samples.position[i] - drivers.position[drivers.sample_driver[i]]).norm(), 0.9f * drivers.cell_size);
}

}  // namespace pliant

// Strands of one Gaussian after another are round rods: their volume is that of the Gaussians, however they lie.

#include "physics/body/strands.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <numbers>

#include "gaussians/base/random.h"
#include "physics/body/driving_particles.h"
#include "physics/body/interior_fill.h"
#include "physics/body/pieces.h"
#include "physics/body/surfels.h"
#include "physics/body/thin_parts.h"

namespace pliant {
namespace {

constexpr double kStrandLength = 0.6;

struct StrandOptions {
  int count = 1000;
  Vec3f size = Vec3f::Constant(0.004f);  ///< standard deviations, the last one along the strand
  double noise = 0;                      ///< standard deviation of the centres off the strand's middle
  double hole = 0;                       ///< length without Gaussians in the middle
  Mat3f turn = Mat3f::Identity();        ///< of the strand, which runs along z
};

GaussianCloud strand_cloud(const StrandOptions& options) {
  GaussianCloud cloud;
  cloud.resize(options.count);
  for (int i = 0; i < options.count; ++i) {
    Random random(1, i);
    double z = random.uniform(0, kStrandLength - options.hole);
    if (z > 0.5 * (kStrandLength - options.hole)) z += options.hole;
    const double x = options.noise * random.normal(), y = options.noise * random.normal();
    cloud.position[i] = options.turn * Vec3d(x, y, z).cast<float>();
    cloud.rotation[i] = quaternion_wxyz(options.turn);
    cloud.log_scale[i] = options.size.array().log();
    cloud.opacity_logit[i] = 4;
  }
  return cloud;
}

const Mat3f kTurns[] = {Mat3f::Identity(), Eigen::AngleAxisf(1.5707963f, Vec3f::UnitY()).toRotationMatrix(),
                        Eigen::AngleAxisf(1.17f, Vec3f(1, 2, 3).normalized()).toRotationMatrix()};

/// Volume of the body that is simulated with so many particles: with its gaps bridged.
double body_volume(const GaussianCloud& cloud, int particles) {
  FillOptions options;
  options.target_count = 8 * particles;
  SolidSamples samples = fill_interior(options, cloud);
  samples.rod = find_rods(samples);
  const float cell = select_simulated(samples, {}, particles).cell_size;
  bridge_gaps({0.5f * cell, 3 * cell, cell}, cloud, samples);
  EXPECT_EQ(find_pieces(samples.position, samples.volume, 0.75f * cell).size(), 1u);
  return samples.total_volume();
}

}  // namespace

TEST(Strands, HaveTheVolumeOfTheirGaussiansHoweverTheyLie) {
  // A round rod has the variance of Gaussians of standard deviation s where its radius is 2 s.
  const auto expect_rod = [](StrandOptions options, double variance, std::vector<int> counts) {
    const double rod = 4 * std::numbers::pi * variance * kStrandLength;
    for (const int particles : counts) {
      std::vector<double> volume;
      for (const Mat3f& turn : kTurns) {
        options.turn = turn;
        volume.push_back(body_volume(strand_cloud(options), particles));
        EXPECT_NEAR(volume.back() / rod, 1, 0.05);
        EXPECT_NEAR(volume.back() / volume[0], 1, 0.01);
      }
    }
  };
  expect_rod({}, 16e-6, {2000, 8000});
  expect_rod({200, {0.003f, 0.003f, 0.012f}}, 9e-6, {2000});
  expect_rod({1000, Vec3f::Constant(0.004f), 0.002}, 20e-6, {2000});
}

TEST(Strands, EndWhereTheirGaussiansEnd) {
  const double whole = body_volume(strand_cloud({}), 2000), hole = 0.1;
  FillOptions options;
  options.target_count = 16000;
  const double parted = fill_interior(options, strand_cloud({1000, Vec3f::Constant(0.004f), 0, hole})).total_volume();
  // The two ends at the hole stand for four standard deviations beyond at most.
  EXPECT_NEAR(parted / whole, 1 - hole / kStrandLength, 4 * 0.004 / kStrandLength);
}

TEST(Strands, AreFoundOnlyWhereRoundGaussiansLieInALine) {
  const auto share = [](const GaussianCloud& cloud) {
    double count = 0;
    for (const Surfel& s : make_surfels({}, cloud)) count += !s.along.isZero(0);
    return count / static_cast<double>(cloud.size());
  };
  EXPECT_EQ(share(strand_cloud({})), 1);
  EXPECT_EQ(share(strand_cloud({200, {0.02f, 0.004f, 0.0005f}})), 0) << "flat";
  EXPECT_EQ(share(strand_cloud({3})), 0) << "too few";
  // A plane of round Gaussians in rows.
  GaussianCloud rows;
  for (int i = 0; i < 40 * 20; ++i) {
    rows.resize(i + 1);
    rows.position[i] = Vec3f(0.01f * static_cast<float>(i % 40), 0.02f * static_cast<float>(i / 40), 0);
    rows.rotation[i] = Vec4f(1, 0, 0, 0);
    rows.log_scale[i].setConstant(std::log(0.01f));
    rows.opacity_logit[i] = 4;
  }
  EXPECT_EQ(share(rows), 0) << "beside others";
}

}  // namespace pliant

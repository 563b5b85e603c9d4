#include "fitting/distribution/object_distribution.h"

#include <gtest/gtest.h>

#include <cmath>

#include "gaussians/base/nearest.h"
#include "gaussians/base/random.h"
#include "tests/fitting/distribution/made_network.h"

namespace pliant {
namespace {

/// A block of samples whose lower half is green and whose upper half is red, with noise on the colours.
struct Block {
  SolidSamples samples;
  std::vector<Vec3f> colour;

  explicit Block(int side) {
    Random random(11);
    for (int x = 0; x < side; ++x)
      for (int y = 0; y < side; ++y)
        for (int z = 0; z < 2 * side; ++z) {
          samples.position.push_back(0.005f *
                                     Vec3f(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)));
          samples.volume.push_back(1.25e-7f);
          samples.thickness.push_back(0);
          const Vec3f noise = 0.04f * Vec3f(static_cast<float>(random.normal()), static_cast<float>(random.normal()),
                                            static_cast<float>(random.normal()));
          colour.push_back((z < side ? Vec3f(0.2f, 0.6f, 0.2f) : Vec3f(0.7f, 0.2f, 0.2f)) + noise);
        }
  }
  FeatureInput input() const { return {samples, colour, {}, Vec3f::UnitZ(), {1e4, 1e5, 1e6}}; }
};

/// Mean difference of log10 E between samples of one colour that lie next to each other.
double roughness(const Block& block, const std::vector<float>& young) {
  const NearestPoints tree(block.samples.position);
  std::vector<NearestPoints::Hit> hits;
  double sum = 0, count = 0;
  for (size_t i = 0; i < young.size(); ++i) {
    tree.query(block.samples.position[i], 7, hits);
    for (const auto& hit : hits)
      if (hit.index != static_cast<int>(i) && (block.colour[hit.index] - block.colour[i]).norm() < 0.4f) {
        sum += std::abs(std::log10(young[hit.index] / young[i]));
        ++count;
      }
  }
  return sum / count;
}

/// Difference of the mean log10 E of the red half from that of the green one, over the two layers at the border.
double step(const Block& block, const std::vector<float>& young) {
  double sum[2] = {0, 0}, count[2] = {0, 0};
  const float border = block.samples.position.back().z() / 2;
  for (size_t i = 0; i < young.size(); ++i) {
    const float z = block.samples.position[i].z();
    if (std::abs(z - border) > 0.008f) continue;
    sum[z > border] += std::log10(young[i]);
    ++count[z > border];
  }
  return sum[1] / count[1] - sum[0] / count[0];
}

// What noise of the looks makes of E goes, what a border of looks makes of it stays.
TEST(ObjectDistribution, IsSmoothWithinALookAndKeepsTheStepBetweenTwo) {
  const Block block(8);
  MaterialDistribution field;
  Random random(5);
  for (size_t i = 0; i < block.samples.size(); ++i) {
    const bool red = block.colour[i].x() > block.colour[i].y();
    const float young = static_cast<float>(std::pow(10.0, (red ? 5.0 : 4.0) + 0.3 * random.normal()));
    field.young.push_back(young);
    field.young_low.push_back(0.3f * young);
    field.young_high.push_back(3 * young);
    field.sigma.push_back(0.4f);
    field.poisson.push_back(0.3f);
    field.density.push_back(500);
  }
  const std::vector<float> before = field.young;
  average_over_neighbours(block.input(), field);
  EXPECT_LT(roughness(block, field.young), 0.2 * roughness(block, before));
  EXPECT_NEAR(step(block, before), 1, 0.1);
  EXPECT_NEAR(step(block, field.young), 1, 0.1);
  for (size_t i = 0; i < block.samples.size(); ++i) {
    EXPECT_NEAR(field.young_high[i] / field.young[i], 3, 1e-3);
    EXPECT_NEAR(field.young_low[i] / field.young[i], 0.3, 1e-3);
    EXPECT_NEAR(field.density[i], 500, 1e-2);
  }
}

TEST(ObjectDistribution, KeepsTheMeansOfWhatCounts) {
  const Block block(6);
  const MaterialMeans means{3e6, 0.25, 640};
  std::vector<float> volume = block.samples.volume;
  for (size_t i = 0; i < volume.size(); i += 3) volume[i] = 0;
  const auto found = object_distribution(made_network(5), block.input(), volume, means);
  double total = 0, young = 0, density = 0, poisson = 0;
  for (size_t i = 0; i < volume.size(); ++i) {
    total += volume[i];
    young += volume[i] * found.young[i];
    density += volume[i] * found.density[i];
    poisson += volume[i] * found.poisson[i];
  }
  EXPECT_NEAR(young / total, means.young, 1e-5 * means.young);
  EXPECT_NEAR(density / total, means.density, 1e-5 * means.density);
  EXPECT_NEAR(poisson / total, means.poisson, 1e-4);
}

TEST(ObjectDistribution, KeepsEveryPoissonRatioThatIsPossible) {
  const Block block(6);
  const std::vector<float>& volume = block.samples.volume;
  for (const double wanted : {-0.3, 0.02, 0.3, 0.49, 0.497}) {
    const auto found = object_distribution(made_network(5), block.input(), volume, {3e6, wanted, 640});
    double total = 0, sum = 0;
    for (size_t i = 0; i < volume.size(); ++i) {
      total += volume[i];
      sum += volume[i] * found.poisson[i];
      EXPECT_GT(found.poisson[i], -1);
      EXPECT_LT(found.poisson[i], 0.5);
    }
    EXPECT_NEAR(sum / total, wanted, 1e-4);
  }
}

}  // namespace
}  // namespace pliant

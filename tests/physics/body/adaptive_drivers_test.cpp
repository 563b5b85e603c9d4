// Driving particles by PGAS: the law of Poisson disks, the spacing that the formula gives, what is conserved, and that
// a body which they move vibrates as with K-means.

#include "physics/body/adaptive_drivers.h"

#include <gtest/gtest.h>
#include <omp.h>

#include <array>
#include <map>
#include <set>

#include "gaussians/base/error.h"
#include "physics/body/make_particles.h"
#include "tests/physics/cantilever.h"
#include "tests/physics/shapes.h"

namespace pliant {
namespace {

/// A block of samples, its upper part [z > border] of Young's modulus 1e5 / ratio, the rest of 1e5.
struct Block {
  SolidSamples samples;
  std::vector<float> young;
};
Block block_of_two(const Vec3d& size, double spacing, double border, double ratio) {
  Block block;
  block.samples = fixture::solid(size, spacing, [](const Vec3d&) { return true; });
  for (const Vec3f& x : block.samples.position)
    block.young.push_back(static_cast<float>(x.z() > border ? 1e5 / ratio : 1e5));
  return block;
}

TEST(PoissonDisk, KeepsDisksApartAndLeavesNoGap) {
  const SolidSamples samples = fixture::solid({0.3, 0.2, 0.2}, 0.01, [](const Vec3d&) { return true; });
  std::vector<float> radius;
  for (const Vec3f& x : samples.position) radius.push_back(0.012f + 0.2f * x.x() * x.x() * (x.y() < 0.1f ? 1 : 2));
  const std::vector<int> disks = poisson_disk(samples.position, radius, 3);
  ASSERT_GT(disks.size(), 100u);
  for (const int a : disks)
    for (const int b : disks)
      if (a != b) {
        EXPECT_GE((samples.position[a] - samples.position[b]).norm(), 0.99999f * std::min(radius[a], radius[b]));
      }
  for (size_t i = 0; i < samples.size(); ++i) {
    float nearest = INFINITY;
    for (const int d : disks) nearest = std::min(nearest, (samples.position[d] - samples.position[i]).norm());
    EXPECT_LT(nearest, radius[i]);
  }
  EXPECT_NE(poisson_disk(samples.position, radius, 4), disks);
}

TEST(RelativeRadii, FollowTheFormula) {
  // Soft and stiff halves of a block, and soft parts that are a sheet and a rod.
  Block body = block_of_two({0.2, 0.2, 0.4}, 0.01, 0.26, 4);
  const size_t bulk = body.samples.size();
  for (int i = 0; i < 40; ++i)
    for (int j = 0; j < 40; ++j) body.samples.position.emplace_back(1 + 0.01f * i, 0.01f * j, 0.0f);
  const size_t sheet = body.samples.size();
  for (int i = 0; i < 400; ++i) body.samples.position.emplace_back(-1.0f, 0.01f * i, 0.0f);
  const size_t rod = body.samples.size();
  for (int i = 0; i < 400; ++i) body.samples.position.emplace_back(-2.0f, 0.01f * i, 0.0f);
  body.samples.volume.resize(body.samples.size(), 1e-6f);
  body.young.resize(rod, 1e5f / 16);
  body.young.resize(body.samples.size(), 1e5f / 2);
  const std::vector<float> relative = relative_radii(body.samples, body.young);
  double sum = 0;
  int inner = 0;
  for (size_t i = 0; i < bulk; ++i) {
    const Vec3f& x = body.samples.position[i];
    if (body.young[i] == 1e5f) {
      EXPECT_EQ(relative[i], 1);
    } else if (x.z() > 0.30f && x.z() < 0.36f && std::min(x.x(), x.y()) > 0.04f && std::max(x.x(), x.y()) < 0.16f) {
      sum += relative[i];
      ++inner;
    }
  }
  EXPECT_NEAR(sum / inner, 0.5, 0.05);  // K_hat = 10, less the scatter of the samples
  for (size_t i = bulk; i < rod; ++i)
    ASSERT_NEAR(relative[i], std::sqrt(10.0 / 16), 1e-3) << (i < sheet ? "sheet" : "rod");
  for (size_t i = rod; i < relative.size(); ++i) ASSERT_EQ(relative[i], 1);  // the minimum caps 10 / 2
  EXPECT_EQ(relative_radii(body.samples, std::vector<float>(body.samples.size(), 7.0f)),
            std::vector<float>(body.samples.size(), 1.0f));
}

TEST(PgasDrivers, SpacingFollowsStiffness) {
  const Block body = block_of_two({0.12, 0.12, 0.4}, 0.12 / 22, 0.24, 4);
  for (const int count : {700, 2000}) {
    const DrivingParticles drivers = pgas_drivers({count, 0, 0}, body.samples, body.young);
    EXPECT_NEAR(drivers.size(), count, 0.02 * count);
    double stiff = 0, soft = 0;
    for (const Vec3f& x : drivers.position) {
      if (std::min(x.x(), x.y()) < 0.02f || std::max(x.x(), x.y()) > 0.1f) continue;
      if (x.z() > 0.03f && x.z() < 0.21f) stiff += 1 / 0.18;
      if (x.z() > 0.27f && x.z() < 0.37f) soft += 1 / 0.10;
    }
    EXPECT_NEAR(std::cbrt(soft / stiff), 2, 0.25);
  }
}

/// Share of the cells of size dx that lie wholly in [low, high] with fewer than `few` drivers, and their mean number.
std::pair<double, double> fill_of_cells(const DrivingParticles& drivers, const Vec3d& low, const Vec3d& high, int few) {
  const double dx = drivers.cell_size;
  double cells = 0, sparse = 0, sum = 0;
  for (const double offset : {0.0, 0.25, 0.5, 0.75}) {
    std::map<std::array<int, 3>, int> count;
    for (const Vec3f& x : drivers.position) {
      const Vec3d u = x.cast<double>() / dx + Vec3d::Constant(offset);
      ++count[{static_cast<int>(std::floor(u.x())), static_cast<int>(std::floor(u.y())),
               static_cast<int>(std::floor(u.z()))}];
    }
    const Eigen::Array3i first = (low / dx + Vec3d::Constant(offset)).array().ceil().cast<int>();
    const Eigen::Array3i last = (high / dx + Vec3d::Constant(offset)).array().floor().cast<int>();
    for (int i = first.x(); i < last.x(); ++i)
      for (int j = first.y(); j < last.y(); ++j)
        for (int k = first.z(); k < last.z(); ++k) {
          ++cells;
          sum += count[{i, j, k}];
          sparse += count[{i, j, k}] < few;
        }
  }
  return {sparse / cells, sum / cells};
}

TEST(PgasDrivers, FillTheCellsOfTheSparsestPart) {
  const Block body = block_of_two({0.12, 0.12, 0.4}, 0.12 / 22, 0.24, 4);
  const std::vector<float> even(body.samples.size(), 1e5f);
  const DrivingParticles uniform = pgas_drivers({2000, 0, 0}, body.samples, even);
  const DrivingParticles kmeans = kmeans_drivers({2000, 0, 10}, body.samples);
  EXPECT_NEAR(uniform.cell_size / kmeans.cell_size, 1, 0.01);
  const DrivingParticles adapted = pgas_drivers({2000, 0, 0}, body.samples, body.young);
  for (const auto& [drivers, top] : {std::pair{&uniform, 0.4}, std::pair{&adapted, 0.22}}) {
    const auto [sparse, mean] = fill_of_cells(*drivers, Vec3d::Zero(), Vec3d(0.12, 0.12, top), 5);
    EXPECT_GT(mean, 6.8);
    EXPECT_LT(mean, 8.5);
    EXPECT_LT(sparse, 0.06);
  }
  EXPECT_GT(fill_of_cells(adapted, Vec3d(0, 0, 0.27), Vec3d(0.12, 0.12, 0.4), 5).second, 30);
}

TEST(PgasDrivers, CarrySumsAndLogarithmicMeansOfTheirSamples) {
  Block body = block_of_two({0.1, 0.1, 0.3}, 0.1 / 16, 0.17, 3);
  for (size_t i = 0; i < body.samples.size(); ++i) body.samples.volume[i] *= 1.0f + 0.3f * (i % 4);
  const DrivingParticles drivers = pgas_drivers({800, 5, 0}, body.samples, body.young);
  EXPECT_EQ(std::set<int>(drivers.sample_driver.begin(), drivers.sample_driver.end()).size(), drivers.size());
  ElasticSamples material = ElasticSamples::homogeneous(body.samples.size(), 1, 0.3, 900);
  material.young = body.young;
  for (size_t i = 0; i < material.size(); ++i) material.density[i] += 1000 * body.samples.position[i].x();
  const auto particles = make_particles<double>(drivers, body.samples, material, 1.0);
  std::vector<double> log_young(drivers.size(), 0), volume(drivers.size(), 0);
  double mass = 0;
  Vec3d moment = Vec3d::Zero(), expected = Vec3d::Zero();
  for (size_t i = 0; i < material.size(); ++i) {
    const double v = body.samples.volume[i];
    mass += v * material.density[i];
    expected += v * body.samples.position[i].cast<double>();
    volume[drivers.sample_driver[i]] += v;
    log_young[drivers.sample_driver[i]] += v * std::log(material.young[i]);
  }
  EXPECT_NEAR(particles.total_mass() / mass, 1, 1e-9);
  EXPECT_NEAR(particles.total_volume() / body.samples.total_volume(), 1, 1e-9);
  int mixed = 0;
  for (size_t d = 0; d < drivers.size(); ++d) {
    EXPECT_NEAR(particles.volume[d] / volume[d], 1, 1e-9);
    EXPECT_NEAR(drivers.volume[d] / volume[d], 1, 1e-6);
    EXPECT_NEAR(std::log(particles.young[d]), log_young[d] / volume[d], 1e-6);
    mixed += particles.young[d] > 1e5 / 2.9 && particles.young[d] < 0.99e5;
    moment += drivers.volume[d] * drivers.position[d].cast<double>();
  }
  EXPECT_GT(mixed, 10);
  EXPECT_LT((moment - expected).norm(), 1e-5 * expected.norm());
}

TEST(PgasDrivers, AreEqualForAnyNumberOfThreads) {
  const Block body = block_of_two({0.1, 0.1, 0.3}, 0.1 / 16, 0.17, 3);
  const int threads = omp_get_max_threads();
  omp_set_num_threads(1);
  const DrivingParticles one = pgas_drivers({400, 3, 0}, body.samples, body.young);
  omp_set_num_threads(3);
  const DrivingParticles three = pgas_drivers({400, 3, 0}, body.samples, body.young);
  omp_set_num_threads(threads);
  EXPECT_TRUE(one.position == three.position && one.volume == three.volume && one.sample_driver == three.sample_driver);
  EXPECT_EQ(one.cell_size, three.cell_size);
}

TEST(PgasDrivers, TakeEverySampleWhenThereAreTooFew) {
  const Block body = block_of_two({0.1, 0.1, 0.1}, 0.025, 0.06, 3);
  EXPECT_EQ(pgas_drivers({1000, 0, 0}, body.samples, body.young).size(), body.samples.size());
  EXPECT_EQ(pgas_drivers({1, 0, 0}, body.samples, body.young).size(), 1u);
  EXPECT_THROW(pgas_drivers({0, 0, 0}, body.samples, body.young), Error);
  EXPECT_THROW(pgas_drivers({10, 0, 0}, {}, {}), Error);
}

TEST(PgasDrivers, KeepThreeOfTheirCellsInsideThePinnedRegion) {
  const Block body = block_of_two({0.1, 0.1, 0.6}, 0.01, 0.45, 4);
  const std::vector<Region> pot = {Region::half_space(Vec3d(0, 0, 0.3), Vec3d(0, 0, 1))};
  const SimulatedPart part = select_simulated(body.samples, pot, 800, body.young);
  std::vector<float> young;
  for (const int i : part.kept) young.push_back(body.young[i]);
  const DrivingParticles drivers = pgas_drivers({800, 0, 0}, body.samples.select(part.kept), young);
  EXPECT_NEAR(part.cell_size / drivers.cell_size, 1, 0.1);
  EXPECT_GT(drivers.cell_size, 1.2 * select_simulated(body.samples, pot, 800).cell_size);
  double lowest = 1;
  for (const int i : part.kept) lowest = std::min<double>(lowest, body.samples.position[i].z());
  EXPECT_NEAR((0.3 - lowest) / drivers.cell_size, 3, 0.5);
}

/// First frequency of a bar along x, clamped below x = kFoot, whose root (or tip) is four times softer than the rest.
double bar_frequency(bool adaptive, bool soft_root, double& cell_size) {
  constexpr double kHeight = 0.03, kFoot = 0.015, kStiff = 263824;
  const SolidSamples samples =
      fixture::solid({kFoot + 0.1, kHeight, kHeight}, kHeight / 14, [](const Vec3d&) { return true; });
  ElasticSamples material = ElasticSamples::homogeneous(samples.size(), kStiff, 0.4, 1070);
  for (size_t i = 0; i < samples.size(); ++i)
    if (soft_root ? samples.position[i].x() < 0.055f : samples.position[i].x() > 0.075f) material.young[i] /= 4;
  const DriverOptions options{1500, 0, 10};
  const DrivingParticles drivers =
      adaptive ? pgas_drivers(options, samples, material.young) : kmeans_drivers(options, samples);
  cell_size = drivers.cell_size;
  const Particles particles = make_particles<float>(drivers, samples, material, 1.0);
  std::vector<double> weight;
  for (size_t i = 0; i < particles.size(); ++i)
    weight.push_back(particles.mass[i] * std::pow(std::max<double>(0, particles.position[i].x() - kFoot), 2));
  Interaction wall;
  wall.type = InteractionType::kPin;
  wall.region = Region::half_space(Vec3d(kFoot, 0, 0), Vec3d::UnitX());
  return fixture::first_frequency(particles, wall, Vec3d(0, 0, -9.81), weight, 0.16);
}

TEST(PgasDrivers, ABarVibratesAsWithKmeans) {
  for (const bool soft_root : {false, true}) {
    double coarse = 0, fine = 0;
    const double adaptive = bar_frequency(true, soft_root, coarse), even = bar_frequency(false, soft_root, fine);
    EXPECT_GT(even, 3);
    EXPECT_NEAR(adaptive / even, 1, 0.04) << adaptive << " Hz, with K-means " << even;
    EXPECT_GT(coarse, 1.2 * fine);  // the stiff part has fewer drivers, and cells to match
  }
}

}  // namespace
}  // namespace pliant

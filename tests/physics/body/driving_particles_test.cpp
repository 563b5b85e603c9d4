#include "physics/body/driving_particles.h"

#include <gtest/gtest.h>
#include <omp.h>

#include <array>
#include <set>

#include "gaussians/base/error.h"
#include "physics/body/make_particles.h"
#include "physics/simulate/simulate.h"
#include "tests/physics/shapes.h"

namespace pliant {
namespace {

SolidSamples stem() {
  return fixture::solid({0.1, 0.1, 0.6}, 0.01,
                        [](const Vec3d& x) { return (x.head<2>() - Vec3d(0.05, 0.05, 0).head<2>()).norm() < 0.05; });
}

template <class F>
int failure_of(F&& call) {
  try {
    call();
  } catch (const Error& error) {
    return static_cast<int>(error.failure);
  }
  return 0;
}

TEST(KmeansDrivers, KeepVolumeAndCentreAndLeaveNoneEmpty) {
  const SolidSamples samples = stem();
  DriverOptions options;
  for (const int count : {1, 7, 500, 3000, 1000000}) {
    options.count = count;
    const DrivingParticles drivers = kmeans_drivers(options, samples);
    const size_t n = std::min(samples.size(), static_cast<size_t>(count));
    ASSERT_EQ(drivers.size(), n);
    EXPECT_EQ(std::set<int>(drivers.sample_driver.begin(), drivers.sample_driver.end()).size(), n);
    double volume = 0;
    Vec3d moment = Vec3d::Zero(), expected = Vec3d::Zero();
    for (size_t d = 0; d < n; ++d) {
      volume += drivers.volume[d];
      moment += drivers.volume[d] * drivers.position[d].cast<double>();
    }
    for (size_t i = 0; i < samples.size(); ++i) expected += samples.volume[i] * samples.position[i].cast<double>();
    EXPECT_NEAR(volume / samples.total_volume(), 1, 1e-5);
    EXPECT_LT((moment - expected).norm(), 1e-5 * expected.norm());
    EXPECT_NEAR(std::pow(drivers.cell_size, 3) * n / 8 / samples.total_volume(), 1, 1e-5);
  }
}

TEST(KmeansDrivers, SpreadEvenly) {
  const SolidSamples samples = stem();
  DriverOptions options;
  options.count = 600;
  const DrivingParticles drivers = kmeans_drivers(options, samples);
  const double mean = samples.total_volume() / 600;
  double variance = 0;
  for (const float v : drivers.volume) variance += (v - mean) * (v - mean) / 600;
  EXPECT_LT(std::sqrt(variance), 0.35 * mean);  // random centres: about 0.55
}

TEST(KmeansDrivers, AreEqualForAnyNumberOfThreads) {
  const SolidSamples samples = stem();
  const int threads = omp_get_max_threads();
  omp_set_num_threads(1);
  const DrivingParticles one = kmeans_drivers({400, 3, 5}, samples);
  omp_set_num_threads(4);
  const DrivingParticles four = kmeans_drivers({400, 3, 5}, samples);
  omp_set_num_threads(threads);
  EXPECT_TRUE(one.position == four.position && one.volume == four.volume && one.sample_driver == four.sample_driver);
}

/// Samples of a sheet in the plane z = 0 or of a rod along x.
SolidSamples thin_part(bool rod, float thickness) {
  SolidSamples samples;
  const int across = rod ? 1 : 40;
  for (int i = 0; i < 40 * 40 / across; ++i)
    for (int j = 0; j < across; ++j) samples.position.emplace_back(0.01f * i, 0.01f * j, 0.0f);
  samples.volume.assign(samples.size(), rod ? 0.01f * thickness * thickness : 1e-4f * thickness);
  samples.thickness.assign(samples.size(), thickness);
  samples.spacing = 0.01f;
  return samples;
}

// A few heavy samples leave clusters of the curve empty; these are filled by distance, which must not depend on what
// the memory held before.
TEST(KmeansDrivers, ClustersThatBeginEmptyDoNotDependOnUnusedMemory) {
  SolidSamples samples = stem();
  for (size_t i = 0; i < samples.size(); i += 50) samples.volume[i] *= 200;
  DriverOptions options;
  options.count = 400;
  std::vector<DrivingParticles> drivers;
  for (const float left_behind : {0.0f, 0.3f}) {
    { const std::vector<Vec3f> freed(options.count, Vec3f::Constant(left_behind)); }
    drivers.push_back(kmeans_drivers(options, samples));
  }
  EXPECT_EQ(drivers[0].sample_driver, drivers[1].sample_driver);
  EXPECT_EQ(drivers[0].position, drivers[1].position);
}

TEST(ThinParts, KeepMassAndBendingStiffness) {
  for (const bool rod : {false, true}) {
    const double thickness = rod ? 0.03 : 0.004;
    const SolidSamples samples = thin_part(rod, static_cast<float>(thickness));
    const DrivingParticles drivers = kmeans_drivers({200, 0, 10}, samples);
    const double full = kThinCells * drivers.cell_size, ratio = thickness / full, area = rod ? ratio * ratio : ratio;
    ASSERT_LT(ratio, 1);
    const auto particles =
        make_particles<double>(drivers, samples, ElasticSamples::homogeneous(samples.size(), 1e7, 0.3, 900), 1);
    EXPECT_NEAR(particles.total_mass() / (900 * samples.total_volume()), 1, 1e-5);
    EXPECT_NEAR(particles.total_volume() / (samples.total_volume() / area), 1, 1e-5);
    double out = 0, up = 0;
    for (size_t d = 0; d < drivers.size(); ++d) {
      EXPECT_EQ(drivers.rod[d], rod);
      EXPECT_NEAR(particles.young[d] / (1e7 * area * ratio * ratio), 1, 1e-4);
      const Vec3f& x = drivers.position[d];
      out += (rod ? x.tail<2>().squaredNorm() : x.z() * x.z()) / drivers.size();
      up += x.z() / drivers.size();
    }
    // The drivers lie around the middle with the variance of a slab, or of a round rod along each of two axes.
    EXPECT_NEAR(out / (full * full), rod ? 1.0 / 8 : 1.0 / 12, 0.01);
    EXPECT_NEAR(up, 0, 0.1 * full);
    // Some more than wanted, where samples would be too far from their driver.
    EXPECT_NEAR(drivers.size(), rod ? 600 : 200, 4);
    EXPECT_EQ(std::set<int>(drivers.sample_driver.begin(), drivers.sample_driver.end()).size(), drivers.size());
    EXPECT_NEAR(8 * particles.total_volume() / std::pow(particles.cell_size, 3), 200, 2);
  }
}

TEST(ThinParts, KeepTheirStrengthAndTheModuliOfTheirLaw) {
  for (const bool rod : {false, true}) {
    const SolidSamples samples = thin_part(rod, rod ? 0.03f : 0.004f);
    const DrivingParticles drivers = kmeans_drivers({200, 0, 10}, samples);
    const double r = (rod ? 0.03 : 0.004) / (kThinCells * drivers.cell_size), area = rod ? r * r : r;
    Particles particles =
        make_particles<float>(drivers, samples, ElasticSamples::homogeneous(samples.size(), 1e7, 0.3, 900), 1);
    Material common;
    common.law = Law::kMetal;
    common.yield_stress = 3e4;
    common.hardening = 2e5;
    common.branch_shear = 4e6;
    common.viscosity_time = 1e-3;
    give_material(drivers, common, particles);
    for (size_t d = 0; d < drivers.size(); ++d) {
      const Material& m = particles.material(d);
      EXPECT_NEAR(m.yield_stress / 3e4, area * r, 2e-3 * area * r);
      EXPECT_NEAR(m.hardening / 2e5, particles.young[d] / 1e7, 4e-3 * area * r * r);
      EXPECT_NEAR(m.branch_shear / 4e6, particles.young[d] / 1e7, 4e-3 * area * r * r);
      EXPECT_EQ(m.viscosity_time, 1e-3);
    }
    EXPECT_LE(particles.materials.size(), 4u) << "one thickness";
    common.law = Law::kHencky;
    give_material(drivers, common, particles);
    EXPECT_TRUE(particles.material_index.empty());

    const std::vector<RelaxingBranch> branch(samples.size(), RelaxingBranch{4e6f, 5e6f, 6e3f});
    const RelaxingBranch first = branches_of(drivers, samples, branch)[0];
    const double factor = thin_factors(drivers, 0).stiffness;
    EXPECT_NEAR(factor, area * r * r, 1e-4 * factor);
    EXPECT_NEAR(first.shear / 4e6, factor, 1e-4 * factor);
    EXPECT_NEAR(first.lambda / 5e6, factor, 1e-4 * factor);
    EXPECT_NEAR(first.viscosity / 6e3, factor, 1e-4 * factor);
  }
}

/// Deflection over that of a beam with bending stiffness D and mass m, both per length (and width), under a constant
/// acceleration a: w(x) = m a / (24 D) (x^4 - 4 L x^3 + 6 L^2 x^2).
double relative_deflection(const Particles& particles, double clamp, double length, double mass_over_stiffness,
                           double acceleration, GridKind grid = GridKind::kAutomatic) {
  Interaction pin, gust;
  pin.type = InteractionType::kPin;
  pin.region = Region::half_space(Vec3d(clamp, 0, 0), Vec3d(1, 0, 0));
  gust.type = InteractionType::kGust;
  gust.vector = Vec3d(0, 0, acceleration);
  SimulateOptions options;
  options.duration = 1.0;
  options.damping_time = 0.15;
  options.gravity.setZero();  // which acts on a metal although it is pinned
  options.grid = grid;
  const auto result = simulate<float>(options, particles, {pin, gust}, initial_state(particles));
  double measured = 0, expected = 0;
  for (size_t i = 0; i < particles.size(); ++i) {
    const double x = particles.position[i].x() - clamp;
    if (x < 0.5 * length) continue;
    measured += result.state.x[i].z() - particles.position[i].z();
    expected += mass_over_stiffness * acceleration / 24 * x * x * (x * x - 4 * length * x + 6 * length * length);
  }
  return measured / expected;
}

TEST(ThinParts, AThinSheetBendsLikeAPlate) {
  const double thickness = 0.006, young = 3e7, density = 900;
  const SolidSamples samples = thin_part(false, thickness);
  const DrivingParticles drivers = kmeans_drivers({600, 0, 10}, samples);
  const Particles particles =
      make_particles<float>(drivers, samples, ElasticSamples::homogeneous(samples.size(), young, 0.0, density), 1);
  EXPECT_LT(thickness / drivers.cell_size, 0.3);
  EXPECT_NEAR(relative_deflection(particles, 0.1, 0.295, 12 * density / (young * thickness * thickness), 0.5), 1, 0.15);
}

/// That of this sheet with another law, over that of a plate of E = 3e7 Pa.
double sheet_deflection(const Material& material, double young, double acceleration) {
  const double thickness = 0.006, density = 900;
  const SolidSamples samples = thin_part(false, thickness);
  const DrivingParticles drivers = kmeans_drivers({600, 0, 10}, samples);
  Particles particles =
      make_particles<float>(drivers, samples, ElasticSamples::homogeneous(samples.size(), young, 0.0, density), 1);
  give_material(drivers, material, particles);
  return relative_deflection(particles, 0.1, 0.295, 12 * density / (3e7 * thickness * thickness), acceleration,
                             GridKind::kEulerian);
}

TEST(ThinParts, AnUnrelaxedBranchStiffensASheetLikeYoungsModulus) {
  Material elastic, relaxing;
  relaxing.law = Law::kViscoelastic;
  relaxing.branch_shear = 0.5 * 3e6;  // of 3e6 Pa, at a Poisson's ratio of 0; the clamp's springs know E alone
  relaxing.branch_viscosity = 1e14;
  EXPECT_NEAR(sheet_deflection(relaxing, 2.7e7, 0.5) / sheet_deflection(elastic, 3e7, 0.5), 1, 0.02);
}

// The moment at the clamp is rho t a L^2 / 2; at Y t^2 / 6 the surface yields.
TEST(ThinParts, ASheetOfMetalYieldsAtItsMoment) {
  const double thickness = 0.006, density = 900, length = 0.295, yield = 1e5;
  const double onset = yield * thickness / (3 * density * length * length);  // m/s^2
  Material elastic, metal;
  elastic.law = Law::kHencky;
  metal.law = Law::kMetal;
  metal.yield_stress = yield;
  const auto growth = [&](double acceleration) {
    return sheet_deflection(metal, 3e7, acceleration) / sheet_deflection(elastic, 3e7, acceleration);
  };
  EXPECT_NEAR(growth(0.8 * onset), 1, 1e-4);
  EXPECT_GT(growth(1.3 * onset), 1.003);
}

TEST(ThinParts, AThinRodBendsLikeABeamHoweverSlowly) {
  const double thickness = 0.004, young = 6.75e7, density = 900, step = 1.0 / 3000;
  SolidSamples samples;
  for (int i = 0; i < 1200; ++i) samples.position.emplace_back(step * (i + 0.5), 0.0f, 0.0f);
  samples.volume.assign(1200, static_cast<float>(step * 3.14159265 / 4 * thickness * thickness));
  samples.thickness.assign(1200, thickness);
  samples.spacing = thickness;
  const DrivingParticles drivers = kmeans_drivers({60, 0, 10}, samples);
  const Particles particles =
      make_particles<float>(drivers, samples, ElasticSamples::homogeneous(samples.size(), young, 0.0, density), 1);
  EXPECT_LT(thickness / drivers.cell_size, 0.2);
  // Strains down to 1e-6, a fraction of the last digit of F per substep, must not be lost in single precision.
  for (const double acceleration : {0.1, 0.01}) {
    const double ratio =
        relative_deflection(particles, 0.1, 0.3, 16 * density / (young * thickness * thickness), acceleration);
    EXPECT_NEAR(ratio, 1, 0.25) << acceleration;
  }
}

TEST(SelectSimulated, KeepsThreeCellsInsideThePinnedRegion) {
  const SolidSamples samples = stem();
  const Region pot = Region::half_space(Vec3d(0, 0, 0.4), Vec3d(0, 0, 1));
  const SimulatedPart part = select_simulated(samples, std::vector<Region>{pot}, 1000);
  EXPECT_NEAR(std::pow(part.cell_size, 3) * 1000 / 8, part.volume, 1e-4 * part.volume);
  std::set<int> kept(part.kept.begin(), part.kept.end());
  for (size_t i = 0; i < samples.size(); ++i) {
    const double depth = 0.4 - samples.position[i].z();
    EXPECT_EQ(kept.count(static_cast<int>(i)) > 0, depth < 3 * part.cell_size) << depth / part.cell_size;
  }
  EXPECT_LT(kept.size(), samples.size());
  EXPECT_EQ(select_simulated(samples, {}, 1000).kept.size(), samples.size());
}

TEST(SelectSimulated, LeavesOutWhatIsHeldFarFromAnythingThatMoves) {
  // The same stem held by a narrow box, whose sides are near all that it holds.
  const SolidSamples samples = stem();
  const Region box = Region::box(Vec3d(-0.01, -0.01, -1), Vec3d(0.11, 0.11, 0.4));
  const SimulatedPart part = select_simulated(samples, std::vector<Region>{box}, 1000);
  double lowest = 1;
  for (const int i : part.kept) lowest = std::min<double>(lowest, samples.position[i].z());
  EXPECT_NEAR(lowest, 0.4 - 4 * part.cell_size, part.cell_size);
}

TEST(SelectSimulated, NothingLeftIsAUsageError) {
  const SolidSamples samples = stem();
  EXPECT_EQ(failure_of([&] { select_simulated(samples, std::vector<Region>{Region::all()}, 100); }), 2);
  EXPECT_EQ(failure_of([&] { select_simulated({}, {}, 100); }), 2);
  EXPECT_EQ(failure_of([&] { kmeans_drivers({}, {}); }), 2);
}

TEST(Material, ParticlesCarrySumsAndLogarithmicMeans) {
  SolidSamples samples;
  samples.position = {{0, 0, 0}, {0.1f, 0, 0}, {5, 0, 0}};
  samples.volume = {1, 3, 2};
  DrivingParticles drivers;
  drivers.position = {{0.075f, 0, 0}, {5, 0, 0}};
  drivers.volume = {4, 2};
  drivers.sample_driver = {0, 0, 1};
  drivers.cell_size = 2;
  const ElasticSamples material = {{1e4f, 1e6f, 5e5f}, {0.1f, 0.3f, 0.4f}, {500, 1500, 1000}};
  const auto particles = make_particles<double>(drivers, samples, material, 0.1);
  EXPECT_NEAR(particles.young[0], std::pow(10, (4 + 3 * 6) / 4.0), 1);
  EXPECT_NEAR(particles.poisson[0], 0.25, 1e-7);
  EXPECT_NEAR(particles.mass[0], (500 + 4500) * 1e-3, 1e-9);
  EXPECT_NEAR(particles.volume[0], 4e-3, 1e-9);
  EXPECT_NEAR(particles.cell_size, 0.2, 1e-7);
  EXPECT_NEAR(particles.position[1].x(), 0.5, 1e-7);
  EXPECT_NEAR(particles.mass[1], 2.0, 1e-9);
}

TEST(Material, ImpossibleValuesAreUsageErrors) {
  EXPECT_EQ(failure_of([] { validate_material("m", 1e5, 0.3, 1000); }), 0);
  for (const auto& [young, poisson, density] : std::vector<std::array<double, 3>>{{-1, 0.3, 1000},
                                                                                  {0, 0.3, 1000},
                                                                                  {1e5, 0.5, 1000},
                                                                                  {1e5, -1, 1000},
                                                                                  {1e5, 0.3, 0},
                                                                                  {NAN, 0.3, 1000},
                                                                                  {1e5, NAN, 1000},
                                                                                  {1e5, 0.3, INFINITY}})
    EXPECT_EQ(failure_of([&] { validate_material("m", young, poisson, density); }), 2) << young << poisson << density;
  try {
    validate_material("scene.json", -5, 0.3, 1000);
  } catch (const Error& error) {
    EXPECT_EQ(error.where, "scene.json");
    EXPECT_EQ(error.field, "young");
    EXPECT_NE(error.problem.find("-5"), std::string::npos);
  }
}

// lambda < 0 leaves the energies mu |F - R|^2 + lambda/2 (J - 1)^2 and mu/2 |F|^2 + lambda/2 (ln J)^2 without a lower
// bound; those of logarithmic strain have one as long as K > 0.
TEST(Material, AuxeticMaterialNeedsALawOfLogarithmicStrain) {
  for (const Law law : {Law::kFixedCorotated, Law::kNeoHookean, Law::kSnow, Law::kViscoelastic}) {
    EXPECT_EQ(failure_of([&] { validate_poisson("m", law, -0.21); }), 2) << law_name(law);
    EXPECT_EQ(failure_of([&] { validate_poisson("m", law, -0.2f); }), 0) << law_name(law);
  }
  for (const Law law : {Law::kHencky, Law::kMetal, Law::kSand, Law::kFoam, Law::kPlasticine, Law::kFluid})
    EXPECT_EQ(failure_of([&] { validate_poisson("m", law, -0.9); }), 0) << law_name(law);
}

}  // namespace
}  // namespace pliant

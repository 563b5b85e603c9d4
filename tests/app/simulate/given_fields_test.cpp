// Fields of a file count for points that they were not made for: those of the nearest sample, or, where they are
// uniform, those of any; a start is carried over.

#include "app/simulate/given_fields.h"

#include <gtest/gtest.h>

#include "app/store/material.h"
#include "app/store/velocity.h"
#include "gaussians/base/error.h"
#include "physics/simulate/simulate.h"
#include "tests/physics/shapes.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

TEST(GivenFields, AUniformMaterialIsThatOfAnyParticlesAndOthersNeedPositions) {
  const TemporaryFolder folder;
  ParticleFile particles;
  particles.solid_position = {Vec3f(0, 0, 0), Vec3f(1, 0, 0), Vec3f(2, 0, 0)};
  MaterialFile material{{2e5f, 2e5f}, {0.3f, 0.3f}, {400, 400}, "made", {}, {}};
  const auto given = [&] {
    write_material(folder / "material.h5", material, "{}");
    return given_material(folder / "material.h5", particles.solid_position);
  };
  EXPECT_EQ(given().young, std::vector<float>(3, 2e5));
  EXPECT_EQ(given().density, std::vector<float>(3, 400));
  material.young[1] = 3e5f;
  EXPECT_THROW(given(), Error);
  material.position = {Vec3f(0.1f, 0, 0), Vec3f(1.8f, 0, 0)};
  material.volume = {1, 1};
  EXPECT_EQ(given().young, (std::vector<float>{2e5, 3e5, 3e5}));
}

// particles.h5 beside a material is seeded anew with another number of samples.
TEST(GivenFields, AMaterialFromBeforeParticlesWereSeededAnewCountsWhereItIsUniform) {
  const TemporaryFolder folder;
  ParticleFile particles;
  particles.solid_position = {Vec3f(0, 0, 0), Vec3f(1, 0, 0), Vec3f(2, 0, 0)};
  particles.solid_volume.assign(3, 1);
  particles.solid_driver.assign(3, 0);
  particles.driving_position = {Vec3f(1, 0, 0)};
  particles.driving_volume = {3};
  particles.cell_size = 1;
  write_particles(folder / "particles.h5", particles, "{}");
  std::vector<std::string> said;
  Progress progress(true);
  progress.listen([&](const ProgressEvent& event) { said.push_back(event.text); });
  MaterialFile material;
  material.source = "made";
  const auto given = [&](std::vector<float> young) {
    said.clear();
    material.young = young;
    material.poisson.assign(young.size(), 0.3f);
    material.density.assign(young.size(), 400);
    write_material(folder / "material.h5", material, "{}");
    return given_material(folder / "material.h5", particles.solid_position, &progress).young;
  };
  for (const size_t count : {1u, 2u, 5u}) {
    EXPECT_EQ(given(std::vector<float>(count, 2e5f)), std::vector<float>(3, 2e5f));
    ASSERT_EQ(said.size(), 1u) << count;
    for (const std::string& word :
         {std::string("material.h5"), std::to_string(count) + " samples", std::string("3 of")})
      EXPECT_NE(said[0].find(word), std::string::npos) << said[0];
  }
  EXPECT_EQ(given({2e5f, 2e5f, 2e5f}), std::vector<float>(3, 2e5f));
  EXPECT_TRUE(said.empty());
  EXPECT_EQ(given({2e5f, 3e5f, 4e5f}), (std::vector<float>{2e5f, 3e5f, 4e5f}));
  expect_error(Failure::kInput, {"material.h5", "/solid/young", "2 rows", "3 points", "seed"}, [&] {
    given({2e5f, 3e5f});
  });
}

TEST(GivenFields, SamplesThatLieElsewhereAreRefused) {
  const TemporaryFolder folder;
  const std::vector<Vec3f> samples = {Vec3f(0, 0, 0), Vec3f(1, 0, 0), Vec3f(2, 1, 0)};
  const auto given = [&](float scale, float shift) {
    MaterialFile material{
        {2e5f, 3e5f, 4e5f, 5e5f}, std::vector<float>(4, 0.3f), std::vector<float>(4, 400), "made", {}, {}};
    for (const Vec3f& x : {Vec3f(0.1f, 0, 0), Vec3f(0.9f, 0.1f, 0), Vec3f(1.5f, 0.5f, 0), Vec3f(1.9f, 0.9f, 0)})
      material.position.push_back(scale * x + Vec3f(0, 0, shift));
    material.volume.assign(4, 1);
    write_material(folder / "material.h5", material, "{}");
    return given_material(folder / "material.h5", samples).young;
  };
  EXPECT_EQ(given(1, 0), (std::vector<float>{2e5f, 3e5f, 5e5f}));
  for (const auto& [scale, shift] : {std::pair{1000.0f, 0.0f}, {0.001f, 0.0f}, {1.0f, 50.0f}})
    expect_error(Failure::kInput, {"material.h5", "/solid/position", "fill a box", "units"},
                 [&] { given(scale, shift); });
  ParticleFile particles;
  particles.driving_position = samples;
  VelocityFile start;
  for (int i = 0; i < 4; ++i) start.position.push_back(Vec3f(static_cast<float>(i), 0, 50));
  start.displacement.assign(4, Vec3f::Zero());
  start.velocity.assign(4, Vec3f::Zero());
  start.F.assign(4, Mat3f::Identity());
  start.C.assign(4, Mat3f::Zero());
  write_velocity(folder / "velocity.h5", start, "{}");
  expect_error(Failure::kInput, {"velocity.h5", "/driving/position"},
               [&] { given_start(folder / "velocity.h5", particles, {}); });
}

TEST(GivenFields, ValuesOfOtherUnitsAreDoubted) {
  EXPECT_EQ(unit_doubt(ElasticSamples::homogeneous(3, 2e3, 0.3, 20)), "");
  const std::string giga = unit_doubt(ElasticSamples::homogeneous(3, 2e-5, 0.3, 700)),
                    grams = unit_doubt(ElasticSamples::homogeneous(3, 2e4, 0.3, 0.7)),
                    both = unit_doubt(ElasticSamples::homogeneous(3, 0.02, 0.3, 0.7));
  EXPECT_NE(giga.find("GPa"), std::string::npos) << giga;
  EXPECT_EQ(giga.find("density"), std::string::npos) << giga;
  EXPECT_NE(grams.find("g/cm^3"), std::string::npos) << grams;
  EXPECT_EQ(grams.find("E of"), std::string::npos) << grams;
  for (const char* word : {"MPa", "g/cm^3"}) EXPECT_NE(both.find(word), std::string::npos) << both;
  // The median counts: a few soft samples are no doubt.
  EXPECT_EQ(unit_doubt({{0.1f, 2e4f, 3e4f}, {0.3f, 0.3f, 0.3f}, {1, 500, 500}}), "");
}

TEST(GivenFields, AStartOfOtherParticlesDiesAwayToTheShapeAtRest) {
  constexpr float kUnit = 0.5f;  // m
  const Particles fine = fixture::block<float>({0.03, 0.03, 0.12}, 0.01, 1.0, 3e4),
                  coarse = fixture::block<float>({0.03, 0.03, 0.12}, 0.015, 1.0, 3e4);
  ParticleFile particles;
  particles.cell_size = coarse.cell_size / kUnit;
  Vec3f centre = Vec3f::Zero();
  for (const Vec3f& x : coarse.position) {
    particles.driving_position.push_back(x / kUnit);
    centre += x / static_cast<float>(coarse.size());
  }
  // Stretched by a tenth while it contracts.
  const Mat3f F = Vec3f(1, 1, 1.1f).asDiagonal(), C = Vec3f(0, 0, -0.5f).asDiagonal();
  VelocityFile start;
  for (const Vec3f& x : fine.position) {
    start.position.push_back(x / kUnit);
    start.displacement.push_back((F - Mat3f::Identity()) * (x - centre));
    start.velocity.push_back(C * (x - centre));
  }
  start.F.assign(fine.size(), F);
  start.C.assign(fine.size(), C);
  const TemporaryFolder folder;
  const auto given = [&] {
    write_velocity(folder / "velocity.h5", start, "{}");
    return given_start(folder / "velocity.h5", particles, coarse);
  };
  const auto farthest = [&](const SimulationState& state) {
    double most = 0;
    for (size_t i = 0; i < state.size(); ++i) most = std::max<double>(most, (state.x[i] - coarse.position[i]).norm());
    return most;
  };
  const auto left = [&](const SimulationState& state) {
    SimulateOptions options;
    options.gravity.setZero();
    options.duration = 0.4;
    options.damping_time = 0.05;
    return farthest(simulate<float>(options, coarse, {}, state).state) / farthest(state);
  };
  const SimulationState state = given();
  for (size_t i = 0; i < coarse.size(); ++i) {
    const Vec3f from = coarse.position[i] - centre;
    ASSERT_LT((state.x[i] - centre - F * from).norm(), 2e-6f) << i;
    ASSERT_LT((state.v[i] - C * from).norm(), 2e-6f) << i;
    ASSERT_LT((state.F[i] - F).norm() + (state.C[i] - C).norm(), 1e-5f) << i;
  }
  EXPECT_LT(left(state), 0.02);
  // A displacement without the deformation that it is.
  start.F.assign(fine.size(), Mat3f::Identity());
  EXPECT_GT(farthest(given()), 0.8 * farthest(state));
  EXPECT_LT(left(given()), 0.05);
}

}  // namespace
}  // namespace pliant

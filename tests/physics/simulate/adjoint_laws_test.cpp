// Gradients of roll-outs of every law, memory and plastic flow included, against differences in double.

#include <gtest/gtest.h>

#include "tests/check_adjoint.h"
#include "tests/physics/simulate/adjoint_rollout_case.h"

namespace pliant {
namespace {

using fixture::Input;
using Case = fixture::RolloutCase<double>;
using List = std::vector<double>;

Case block_of(Law law) {
  Case c = fixture::moving_block<double>(2);
  c.interactions.resize(1);
  Material m;
  m.law = law;
  m.damping_time = 0.5;
  m.viscosity_time = 1e-4;
  m.yield_stress = 300;
  m.plastic_viscosity = 20;
  m.hardening = law == Law::kPlasticine ? -200 : 2000;
  m.dynamic_viscosity = 0.5;
  m.bulk_modulus = 3e4;
  m.branch_shear = 5e3;
  m.branch_lambda = 4e3;
  m.branch_viscosity = 10;
  c.particles.materials = {Material{}, m};
  c.particles.material_index.assign(c.particles.size(), 1);
  c.particles.material_index[0] = 0;  // beside a law without a memory
  c.start = initial_state(c.particles);
  for (size_t i = 0; i < c.start.size(); ++i) {
    Random random(4, i);
    for (int a = 0; a < 3; ++a) c.start.v[i][a] = 0.2 * random.normal();
    for (int k = 0; k < 9; ++k) {
      c.start.C[i](k / 3, k % 3) = 5 * random.normal();
      c.start.F[i](k / 3, k % 3) += 0.03 * random.normal();
    }
    if (law == Law::kSand) c.start.F[i] *= 0.97;
    if (law == Law::kSnow) c.particles.young[i] *= 0.02;  // it hardens
  }
  c.options.simulate.duration = 0.01;
  c.options.simulate.substeps = 10;
  return c;
}

class AdjointLaws : public ::testing::TestWithParam<Law> {};

/// The edges of the cone of sand lie close: its step is small.
void expect_gradient(const Case& c, Law law, double step) {
  if (law != Law::kHencky) {
    const auto end = rollout(c.options, c.particles, c.interactions, c.start).frames.back();
    ASSERT_GT((end.F[1] - end.memory[1].F_total).norm() + (end.F[1] - end.memory[1].F_viscous).norm(), 1e-3)
        << "no flow";
  }
  const RolloutGradient<double> gradient = c.gradient();
  AdjointCheckOptions options;
  options.step = step;
  options.random_cotangents = 0;
  options.inputs = 3;
  options.random_directions = 1;
  for (const auto& [kind, name] : fixture::kInputs) {
    if (c.get(kind).empty()) continue;
    const AdjointCheck result = check_adjoint(
        [&, kind = kind](const List& u) { return List{c.with(kind, u).value()}; },
        [&, kind = kind](const List&, const List&) { return c.part(gradient, kind); }, c.get(kind), options);
    EXPECT_LT(result.worst, 1e-5) << name << ": " << result.message;
  }
}

TEST_P(AdjointLaws, RolloutAgreesWithDifferences) {
  expect_gradient(block_of(GetParam()), GetParam(), GetParam() == Law::kSand ? 1e-5 : 1e-4);
}

// On the ground, held by a pin at one side, with a weight and turned by a torque.
TEST_P(AdjointLaws, RolloutWithSupportsWeightAndTorqueAgreesWithDifferences) {
  Case c = block_of(GetParam());
  c.interactions.push_back(fixture::ground(0, 0.3));
  Interaction it;
  it.type = InteractionType::kPin;
  it.region = Region::half_space(Vec3d(0.016, 0, 0), Vec3d(-1, 0, 0));
  c.interactions.push_back(it);
  it.type = InteractionType::kWeight;
  it.mass = 2e-3;
  it.region = Region::sphere({0.005, 0.015, 0.015}, 0.01);
  c.interactions.push_back(it);
  it.type = InteractionType::kTorque;
  it.mass = 0;
  it.vector = {1e-3, -2e-3, 1.5e-3};
  c.interactions.push_back(it);
  for (Vec3d& v : c.start.v) v += Vec3d(0, 0, -0.4);
  // So do those of the box of snow here.
  expect_gradient(c, GetParam(), GetParam() == Law::kSand || GetParam() == Law::kSnow ? 1e-5 : 1e-4);
}

// The wind presses on the surface as the whole deformation turns and stretches it.
TEST(AdjointLawsInTheWind, RolloutAgreesWithDifferences) {
  for (const Law law : {Law::kMetal, Law::kFluid, Law::kViscoelastic}) {
    Case c = block_of(law);
    Interaction wind;
    wind.type = InteractionType::kWind;
    wind.vector = {8, -3, 2};
    wind.air_density = 10;  // of air itself, too little moves to see
    c.interactions = {wind};
    for (size_t i = 1; i < c.start.size(); ++i) {
      Random random(8, i);
      c.start.memory[i].F_total << 0.8, -0.7, 0.1, 0.6, 0.9, -0.1, 0, 0.1, 1.2;
      for (int k = 0; k < 9; ++k) c.start.memory[i].F_total(k / 3, k % 3) += 0.03 * random.normal();
    }
    expect_gradient(c, law, 1e-5);
  }
}

TEST_P(AdjointLaws, RolloutWithFlipAgreesWithDifferences) {
  Case c = block_of(GetParam());
  c.options.simulate.flip_time = 0.002;
  expect_gradient(c, GetParam(), GetParam() == Law::kSand ? 1e-5 : 1e-4);
}

TEST_P(AdjointLaws, PartsOfAFrameGiveTheBitsOfTheWhole) {
  Case c = block_of(GetParam());
  const RolloutGradient<double> whole = c.gradient();
  c.options.memory = 0;
  const RolloutGradient<double> parts = c.gradient();
  EXPECT_EQ(whole.start.x, parts.start.x);
  EXPECT_EQ(whole.start.F, parts.start.F);
  EXPECT_EQ(whole.young, parts.young);
  EXPECT_EQ(whole.poisson, parts.poisson);
}

INSTANTIATE_TEST_SUITE_P(Laws, AdjointLaws,
                         ::testing::Values(Law::kHencky, Law::kMetal, Law::kSand, Law::kSnow, Law::kFoam,
                                           Law::kPlasticine, Law::kFluid, Law::kViscoelastic),
                         [](const auto& info) { return std::string(law_name(info.param)); });

}  // namespace
}  // namespace pliant

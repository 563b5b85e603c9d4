// Mechanics of small bodies, law by law; tests/studies/laws_study.cpp has the large ones.

#include "tests/physics/simulate/laws_bodies.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "gaussians/base/error.h"
#include "physics/body/surface_elements.h"
#include "tests/physics/laws/laws_cases.h"

namespace pliant {
namespace {

using namespace pliant::fixture;

Substance substance(Law law) {
  Substance s;
  s.material.law = law;
  s.material.yield_stress = 1e4;
  s.material.plastic_viscosity = 50;
  s.material.hardening = 0;
  s.material.branch_shear = 3e4;
  s.material.branch_lambda = 2e4;
  s.material.branch_viscosity = 1e6;
  return s;
}

TEST(LawBodies, PressureOfACompressedBlockGivesTheBulkModulus) {
  for (const Law law : kAllLaws) {
    const Substance s = substance(law);
    double expected = s.bulk();
    if (law == Law::kViscoelastic) expected += s.material.branch_lambda + 2 * s.material.branch_shear / 3;
    EXPECT_NEAR(measured_bulk_modulus(s) / expected, 1, 1e-3) << law_name(law);
  }
}

TEST(LawBodies, PulsesTravelAtTheSpeedOfPressureWaves) {
  for (const Law law : {Law::kNeoHookean, Law::kFluid}) {
    const Substance s = substance(law);
    const Lame<double> l = s.moduli();
    const double modulus = law == Law::kFluid ? s.bulk() : l.lambda + 2 * l.mu;
    const double expected = std::sqrt(modulus / s.density);
    EXPECT_NEAR(p_wave_speed(s, expected, 2) / expected, 1, 0.02) << law_name(law);
  }
}

TEST(LawBodies, SandHoldsTwoDegreesBelowItsCriticalSlopeAndFlowsTwoDegreesAbove) {
  const double critical = critical_slope(30);
  EXPECT_NEAR(critical, 34.7, 0.05);
  EXPECT_LT(sand_slope_run(30, critical - 2, 4, 0.15), 0.01);
  EXPECT_GT(sand_slope_run(30, critical + 2, 4, 0.15), 0.03);
}

TEST(LawBodies, ALayerHeldInShearRelaxesInTheTimeOfItsBranch) {
  Substance s = substance(Law::kViscoelastic);
  s.material.branch_viscosity = 2 * s.material.branch_shear * 0.02;
  EXPECT_NEAR(branch_relaxation_time(s) / 0.02, 1, 0.05);
}

TEST(LawBodies, FoamHeldInShearRelaxesInTheTimeViscosityOverTwoMu) {
  Substance s = substance(Law::kFoam);
  s.material.yield_stress = 1e3;
  s.material.plastic_viscosity = 2 * s.moduli().mu * 0.02;
  EXPECT_NEAR(foam_relaxation_time(s) / 0.02, 1, 0.05);
}

TEST(LawBodies, ShearFlowOfAFluidDecaysByItsViscosity) {
  Substance s = substance(Law::kFluid);
  s.material.bulk_modulus = 1e5;
  s.material.dynamic_viscosity = 20;
  const double expected = s.density * std::pow(0.08 / M_PI, 2) / s.material.dynamic_viscosity;
  EXPECT_NEAR(shear_flow_decay_time(s, 0.01, 8) / expected, 1, 0.05);
}

Substance soft_metal(Law law) {
  Substance s;
  s.material.law = law;
  s.material.yield_stress = 2e4;
  s.young = 2e6;
  s.density = 2000;
  return s;
}

TEST(LawBodies, MetalKeepsItsDent) {
  const Dent d = dent(soft_metal(Law::kMetal), 1e5, 0.03, 0.02);
  EXPECT_GT(d.loaded, 0.004);
  EXPECT_GT(d.left, 0.5 * d.loaded);
}

TEST(LawBodies, AnElasticBodyLosesItsDent) {
  const Dent d = dent(soft_metal(Law::kHencky), 1e5, 0.03, 0.02);
  EXPECT_LT(d.left, 0.2 * d.loaded);
}

TEST(LawBodies, ASnowBallKeepsItsShape) {
  Substance s;
  s.material.law = Law::kSnow;
  s.young = 1.4e5;
  s.poisson = 0.2;
  s.density = 400;
  const auto [before, after] = rest_on_ground(ball_of(s, 0.2, 6), 0.3);
  EXPECT_LT(after.width, 1.1 * before.width);
  EXPECT_GT(after.height, 0.9 * before.height);
}

TEST(LawBodies, AFoamColumnStandsUntilItsWeightExceedsTheYieldStress) {
  Substance s;
  s.material.law = Law::kFoam;
  s.young = 2e5;
  const double height = 0.12, weight = s.density * 9.81 * height;
  s.material.plastic_viscosity = 100;
  for (const double part : {2.0, 0.1}) {
    s.material.yield_stress = part * weight;
    const auto [before, after] = rest_on_ground(block_of(s, Vec3d(0.08, 0.08, height), 0.02, 1.0), 0.4);
    if (part > 1) {
      EXPECT_GT(after.height, 0.95 * before.height);
    } else {
      EXPECT_LT(after.height, 0.75 * before.height);
    }
  }
}

TEST(LawBodies, PlasticineThatSoftensSinksFurther) {
  Substance s;
  s.material.law = Law::kPlasticine;
  s.young = 2e5;
  const double height = 0.12, weight = s.density * 9.81 * height;
  s.material.yield_stress = 0.7 * weight;
  double left[2];
  for (const int soft : {0, 1}) {
    s.material.hardening = soft ? -2 * s.material.yield_stress : 0;
    left[soft] = rest_on_ground(block_of(s, Vec3d(0.06, 0.06, height), 0.02, 1.0), 0.6).second.height / height;
  }
  EXPECT_GT(1 - left[1], 3 * (1 - left[0]));
}

TEST(LawBodies, WaterCarriesItsWeightAndKeepsItsVolume) {
  const WaterColumn w = water_column(8, 0.3, false);
  EXPECT_NEAR(w.mean_pressure, 1, 0.03);
  EXPECT_NEAR(w.height_change, 0, 0.02);
}

// What hangs from a pin, 3.5 cells and more below it, falls as freely as nothing holds it; rubber stays.
TEST(LawBodies, APinnedColumnFallsWhereItFlowsAndStaysWhereItIsElastic) {
  const double dx = 0.02, seconds = 0.1, free = 0.5 * 9.81 * seconds * seconds;
  Interaction pin;
  pin.type = InteractionType::kPin;
  pin.region = Region::half_space(Vec3d(0, 0, 0.12), -Vec3d::UnitZ());
  for (const Law law : {Law::kHencky, Law::kSand, Law::kFluid}) {
    Substance s = substance(law);
    const Bodies p = block_of(s, Vec3d(0.08, 0.08, 0.2), dx, 1.0);
    SimulateOptions options = run_options(50, seconds);
    const auto result = simulate<double>(options, p, {pin}, initial_state(p));
    double fallen = 0, count = 0;
    for (size_t i = 0; i < p.size(); ++i) {
      if (p.position[i].z() > 0.05) continue;
      fallen += p.position[i].z() - result.state.x[i].z();
      ++count;
    }
    EXPECT_EQ(result.summary.gravity_cancelled, law == Law::kHencky) << law_name(law);
    if (law == Law::kHencky) {
      EXPECT_LT(std::abs(fallen / count), 1e-9);
    } else {
      EXPECT_GT(fallen / count, 0.5 * free) << law_name(law);
    }
  }
}

TEST(LawBodies, EnergyOfAFreeBlockDoesNotGrow) {
  for (const Law law : {Law::kFixedCorotated, Law::kNeoHookean, Law::kHencky})
    EXPECT_LE(energy_growth(substance(law), 4, 500, 0.4), 1e-3) << law_name(law);
}

/// Impulse that wind along x gives to a block of 3 x 4 x 6 cells which has deformed for good, relative to that of its
/// pressure on the surface elements that face it then.
double share_of_wind(Law law, const Mat3d& deformation) {
  const Bodies p = block_of(substance(law), Vec3d(0.03, 0.04, 0.06), 0.01, 1.0);
  BodyState start = initial_state(p);
  for (size_t i = 0; i < p.size(); ++i) {
    start.x[i] = deformation * p.position[i];
    start.memory[i].F_total = deformation;
  }
  Interaction wind;
  wind.type = InteractionType::kWind;
  wind.vector = Vec3d(8, 0, 0);
  const double seconds = 0.02;  // in which the block hardly moves
  const auto result = simulate<double>(run_options(100, seconds, Vec3d::Zero()), p, {wind}, start);
  double given = 0, area = 0;
  for (const auto& frame : result.summary.impulse_of_frame) given += frame[0].x();
  for (const Vec3d& element : surface_elements(p, p.cell_size))
    area += std::max(0.0, -(cofactor(deformation) * element).x());
  return given / (seconds * 0.5 * wind.air_density * wind.drag_coefficient * wind.vector.squaredNorm() * area);
}

// At rest 6 x 4 cells face it, turned 3 x 4, stretched twice as much: the elastic part of F knows nothing of that.
TEST(LawBodies, WindPressesOnTheSurfaceThatFacesItOfWhatHasFlowed) {
  Mat3d turned, stretched = Mat3d::Identity();
  turned << 0, 0, 1, 0, 1, 0, -1, 0, 0;
  stretched(1, 1) = 2;
  EXPECT_NEAR(share_of_wind(Law::kFluid, Mat3d::Identity()), 1, 0.05);
  EXPECT_NEAR(share_of_wind(Law::kFluid, turned), 1, 0.05);
  EXPECT_NEAR(share_of_wind(Law::kMetal, stretched), 1, 0.05);
}

/// Largest displacement [m] of a column that is held at its foot while a steady acceleration bends it.
double bent_column(const Substance& s) {
  Interaction pin, push;
  pin.type = InteractionType::kPin;
  pin.region = Region::half_space(Vec3d(0, 0, 0.01), Vec3d(0, 0, 1));
  push.type = InteractionType::kGust;
  push.vector = Vec3d(2, 0, 0);
  const Bodies p = block_of(s, Vec3d(0.03, 0.03, 0.12), 0.01);
  return simulate<double>(run_options(50, 0.14), p, {pin, push}, initial_state(p)).summary.max_displacement;
}

TEST(LawBodies, BendingIsStableDownToTheLeastPoissonsRatioOfALaw) {
  for (const Law law : {Law::kFixedCorotated, Law::kNeoHookean, Law::kHencky, Law::kMetal}) {
    Substance s = substance(law);
    const double usual = bent_column(s);
    s.poisson = std::max(least_poisson(law), -0.9);
    const double auxetic = bent_column(s);
    // Bending depends on E, hardly on nu.
    EXPECT_GT(auxetic, 0.4 * usual) << law_name(law);
    EXPECT_LT(auxetic, 2 * usual) << law_name(law);
    s.poisson = least_poisson(law) - 0.01;
    EXPECT_THROW(bent_column(s), Error) << law_name(law);
  }
}

}  // namespace
}  // namespace pliant

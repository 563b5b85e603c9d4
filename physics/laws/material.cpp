#include "physics/laws/material.h"

#include <cmath>

#include "gaussians/base/error.h"

namespace pliant {
namespace {

constexpr const char* kNames[] = {"fixed_corotated", "neo_hookean", "hencky",      "metal", "sand", "snow", "foam",
                                  "plasticine",      "fluid",       "viscoelastic"};

void require(bool good, const std::string& where, const char* field, double value, const char* remedy) {
  if (!good) throw usage_error(where, field, "is " + std::to_string(value), remedy);
}

}  // namespace

const char* law_name(Law law) { return kNames[static_cast<int>(law)]; }

std::vector<std::string> law_names() { return {std::begin(kNames), std::end(kNames)}; }

bool has_memory(Law law) { return law != Law::kFixedCorotated && law != Law::kNeoHookean && law != Law::kHencky; }

void validate_material(const std::string& where, double young, double poisson, double density) {
  const auto positive = [&](const char* field, double value, const char* remedy) {
    if (!(value > 0) || !std::isfinite(value))
      throw usage_error(where, field, "is " + std::to_string(value) + ", must be positive", remedy);
  };
  positive("young", young, "give Young's modulus in pascal, for example 1e6");
  if (!(poisson > -1 && poisson < 0.5))
    throw usage_error(where, "poisson", "is " + std::to_string(poisson) + ", must lie between -1 and 0.5",
                      "give Poisson's ratio, for example 0.3; nearly incompressible is 0.45");
  positive("density", density, "give the density in kg/m^3, for example 1000");
}

double least_poisson(Law law) {
  constexpr double kStableTo17Percent = -0.2;  // stretched in all directions, by mu |F - R|^2 + lambda/2 (J - 1)^2
  switch (law) {
    case Law::kFixedCorotated:
    case Law::kNeoHookean:
    case Law::kSnow:
    case Law::kViscoelastic:
      return kStableTo17Percent;
    case Law::kHencky:
    case Law::kMetal:
    case Law::kSand:
    case Law::kFoam:
    case Law::kPlasticine:
    case Law::kFluid:
      break;
  }
  return -1;
}

void validate_poisson(const std::string& where, Law law, double poisson) {
  constexpr double kRounding = 1e-6;
  if (!(poisson < least_poisson(law) - kRounding)) return;
  throw usage_error(where, "poisson",
                    "is " + std::to_string(poisson) + ", for which the law " + law_name(law) + " is unstable",
                    "give -0.2 or more, or choose the law hencky, which holds from -1 to 0.5");
}

void validate_material(const std::string& where, const Material& m) {
  const auto positive = [&](const char* field, double value) {
    require(value > 0 && std::isfinite(value), where, field, value, "give a positive number");
  };
  const auto not_negative = [&](const char* field, double value) {
    require(value >= 0 && std::isfinite(value), where, field, value, "give a number that is not negative");
  };
  not_negative("damping_time", m.damping_time);
  not_negative("viscosity_time", m.viscosity_time);
  switch (m.law) {
    case Law::kFixedCorotated:
    case Law::kNeoHookean:
    case Law::kHencky:
      break;
    case Law::kFoam:
      not_negative("plastic_viscosity", m.plastic_viscosity);
      [[fallthrough]];
    case Law::kMetal:
    case Law::kPlasticine:
      positive("yield_stress", m.yield_stress);
      require(std::isfinite(m.hardening) && (m.hardening >= 0 || m.law == Law::kPlasticine), where, "hardening",
              m.hardening, "give pascal per unit of plastic strain; only plasticine softens");
      break;
    case Law::kSand:
      require(m.friction_angle > 0 && m.friction_angle < 90, where, "friction_angle", m.friction_angle,
              "give degrees between 0 and 90, for example 30");
      break;
    case Law::kSnow:
      require(m.critical_compression >= 0 && m.critical_compression < 1, where, "critical_compression",
              m.critical_compression, "give a strain below 1, for example 0.025");
      not_negative("critical_stretch", m.critical_stretch);
      not_negative("compaction_hardening", m.compaction_hardening);
      break;
    case Law::kFluid:
      not_negative("bulk_modulus", m.bulk_modulus);
      require(m.pressure_exponent > 0 && m.pressure_exponent <= 20, where, "pressure_exponent", m.pressure_exponent,
              "give a number up to 20, for example 7");
      not_negative("dynamic_viscosity", m.dynamic_viscosity);
      break;
    case Law::kViscoelastic:
      not_negative("branch_shear", m.branch_shear);
      not_negative("branch_lambda", m.branch_lambda);
      positive("branch_viscosity", m.branch_viscosity);
      break;
  }
}

}  // namespace pliant

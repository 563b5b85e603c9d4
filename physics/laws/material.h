#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace pliant {

/// Constitutive laws.
enum class Law : uint8_t {
  kFixedCorotated,  ///< elastic; large rotations, moderate strain (default)
  kNeoHookean,      ///< elastic; rubber
  kHencky,          ///< elastic; quadratic in logarithmic strain
  kMetal,           ///< Hencky, von Mises yield with isotropic hardening
  kSand,            ///< Hencky, Drucker-Prager yield with volume correction
  kSnow,            ///< fixed corotated with stretches clamped and hardening by compaction
  kFoam,            ///< Hencky, viscoplastic flow above a yield stress
  kPlasticine,      ///< Hencky, von Mises yield with softening until it flows
  kFluid,           ///< weakly compressible, Newtonian viscosity
  kViscoelastic,    ///< fixed corotated beside a branch whose Hencky strain relaxes
};

/// Name in files and on the command line: fixed_corotated, neo_hookean, hencky, metal, sand, snow, foam, plasticine,
/// fluid, viscoelastic.
const char* law_name(Law law);
/// All names, in the order of the enumeration.
std::vector<std::string> law_names();
/// Whether the law changes F or remembers something after a step, so that its return map has to be called.
bool has_memory(Law law);

/// What a material is made of beside E, nu and rho, which vary from particle to particle.  A law ignores what it does
/// not name.
struct Material {
  Law law = Law::kFixedCorotated;
  double damping_time = 0;    ///< s in which mass-proportional damping lowers an amplitude to 1/e; 0 = none
  double viscosity_time = 0;  ///< s, Kelvin-Voigt: stress of strain + time * strain rate; 0 = none

  bool as_physgaussian = false;  ///< repeats the stresses of its released code, see physgaussian.h; metal, foam, snow

  double yield_stress = 0;       ///< Pa in uniaxial tension; metal, foam, plasticine
  double hardening = 0;          ///< Pa per unit of plastic strain; metal (negative values only for plasticine)
  double plastic_viscosity = 0;  ///< Pa s; foam
  double friction_angle = 30;    ///< degrees; sand
  double critical_compression = 2.5e-2, critical_stretch = 7.5e-3;  ///< snow, Stomakhin et al. 2013
  double compaction_hardening = 10;                                 ///< xi; snow
  double bulk_modulus = 0;                                          ///< Pa; fluid; 0 = of E and nu
  double pressure_exponent = 7;                                     ///< gamma of p = K / gamma (J^-gamma - 1); fluid
  double dynamic_viscosity = 0;                                     ///< Pa s; fluid
  double branch_shear = 0, branch_lambda = 0;  ///< Pa; Lame parameters of the relaxing branch; viscoelastic
  double branch_viscosity = 0;                 ///< Pa s; viscoelastic
};

/// Throws Error{kUsage} naming `where`, the field and the value unless E > 0, -1 < nu < 0.5 and rho > 0 (and finite).
void validate_material(const std::string& where, double young, double poisson, double density);
/// Poisson's ratio from which on a law holds: -0.2 where its energy has a term lambda f(J)^2, because a negative lambda
/// leaves such an energy without a lower bound and the body inflates or collapses; else -1, where K vanishes.
double least_poisson(Law law);
/// Throws Error{kUsage} unless `law` holds for this Poisson's ratio.
void validate_poisson(const std::string& where, Law law, double poisson);
/// Throws Error{kUsage} for impossible constants that `material.law` uses.
void validate_material(const std::string& where, const Material& material);

/// First and second Lame parameter [Pa] of Young's modulus and Poisson's ratio.
template <class T>
struct Lame {
  T lambda, mu;
};
template <class T>
Lame<T> lame(T young, T poisson) {
  return {young * poisson / ((1 + poisson) * (1 - 2 * poisson)), young / (2 * (1 + poisson))};
}

}  // namespace pliant

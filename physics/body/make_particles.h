#pragma once

#include <string>
#include <vector>

#include "physics/body/driving_particles.h"
#include "physics/body/samples.h"
#include "physics/laws/material.h"
#include "physics/mpm/particles.h"

namespace pliant {

/// Constants of a relaxing branch beside the elastic one (Law::kViscoelastic).
struct RelaxingBranch {
  float shear = 0, lambda = 0;  ///< Pa
  float viscosity = 0;          ///< Pa s
};

/// Elastic material of every solid sample.
struct ElasticSamples {
  std::vector<float> young;                 ///< [M] E, Pa
  std::vector<float> poisson;               ///< [M] nu
  std::vector<float> density;               ///< [M] rho, kg/m^3
  std::vector<RelaxingBranch> branch = {};  ///< [M], or empty: the law and its constants are the same everywhere

  size_t size() const { return young.size(); }
  static ElasticSamples homogeneous(size_t count, double young, double poisson, double density);
  ElasticSamples select(std::span<const int> indices) const;
};

/// Throws Error{kUsage} naming `where`, the field and the value of the first sample that is impossible.
void validate_material(const std::string& where, const ElasticSamples& material);

/// What makes a part of thickness t, simulated as thick as w = kThinCells dx where t < w, resist bending as it does.
/// With r = t / w (at least kThinnestPart): bent alike, its surface is strained 1 / r times as much, and a moment is a
/// stress times w^2 per width of a sheet, times w^3 for a rod.  So a stress of the real part becomes one of r^2 (rod:
/// r^3) times its size, and what is a stress over a strain or strain rate becomes r^3 (r^4) times as large.
struct ThinFactors {
  double area = 1;       ///< real over simulated cross-section: r, of a rod r^2
  double strength = 1;   ///< of yield stresses
  double stiffness = 1;  ///< of moduli, hardening and viscosities
};
ThinFactors thin_factors(const DrivingParticles& drivers, size_t driver);

/// Particles of the solver, in SI units: a driver's volume and mass are the sums over its samples, log E and nu their
/// volume-weighted means; volume and E of thin parts by `thin_factors`.  `metres_per_unit` converts the units of the
/// samples.
template <class T>
BasicParticles<T> make_particles(const DrivingParticles& drivers, const SolidSamples& samples,
                                 const ElasticSamples& material, double metres_per_unit);

/// Gives all particles the material `common`, with its constants in pascal times the factors of thin parts: where the
/// law has such constants, parts whose thicknesses differ by more than 0.1 % get a material each.
void give_material(const DrivingParticles& drivers, const Material& common, Particles& particles);

/// [N] volume-weighted means of the branches of each driver's samples, times the stiffness factor of thin parts.
std::vector<RelaxingBranch> branches_of(const DrivingParticles& drivers, const SolidSamples& samples,
                                        const std::vector<RelaxingBranch>& branch);
/// Gives every particle a material of its own: `common`, as a viscoelastic one with that particle's branch [N].  Throws
/// Error{kUsage} for more than 65,536 particles or impossible constants.
void give_branches(const std::vector<RelaxingBranch>& branch, const Material& common, Particles& particles);

extern template BasicParticles<float> make_particles(const DrivingParticles&, const SolidSamples&,
                                                     const ElasticSamples&, double);
extern template BasicParticles<double> make_particles(const DrivingParticles&, const SolidSamples&,
                                                      const ElasticSamples&, double);

}  // namespace pliant

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

/// Particles of the solver, in SI units: a driver's volume and mass are the sums over its samples, log E and nu their
/// volume-weighted means.  A driver thinner than w = kThinCells dx gets the volume of a part of thickness w and the
/// Young's modulus that keeps its bending stiffness: E (t / w)^3 for a sheet, E (t / w)^4 for a rod.  `metres_per_unit`
/// converts the units of the samples.
template <class T>
BasicParticles<T> make_particles(const DrivingParticles& drivers, const SolidSamples& samples,
                                 const ElasticSamples& material, double metres_per_unit);

/// [N] volume-weighted means of the branches of each driver's samples.
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

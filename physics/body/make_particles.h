#pragma once

#include <string>
#include <vector>

#include "physics/body/driving_particles.h"
#include "physics/body/samples.h"
#include "physics/laws/material.h"
#include "physics/mpm/particles.h"

namespace pliant {

/// Elastic material of every solid sample.
struct ElasticSamples {
  std::vector<float> young;    ///< [M] E, Pa
  std::vector<float> poisson;  ///< [M] nu
  std::vector<float> density;  ///< [M] rho, kg/m^3

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

extern template BasicParticles<float> make_particles(const DrivingParticles&, const SolidSamples&,
                                                     const ElasticSamples&, double);
extern template BasicParticles<double> make_particles(const DrivingParticles&, const SolidSamples&,
                                                      const ElasticSamples&, double);

}  // namespace pliant

#pragma once

#include <string>
#include <vector>

#include "physics/driving_particles.h"
#include "physics/particles.h"
#include "physics/samples.h"

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

/// Throws Error{kUsage} naming `where`, the field and the value unless E > 0, -1 < nu < 0.5 and rho > 0 (and finite).
void validate_material(const std::string& where, double young, double poisson, double density);
void validate_material(const std::string& where, const ElasticSamples& material);

/// First and second Lame parameter [Pa] of Young's modulus and Poisson's ratio.
template <class T>
struct Lame {
  T lambda, mu;
};
template <class T>
Lame<T> lame(T young, T poisson) {
  return {young * poisson / ((1 + poisson) * (1 - 2 * poisson)), young / (2 * (1 + poisson))};
}

/// Particles of the solver, in SI units: a driver's volume and mass are the sums over its samples, log E and nu their
/// volume-weighted means.  A driver thinner than w = kThinCells dx gets the volume of a part of thickness w and the
/// Young's modulus that keeps its bending stiffness: E (t / w)^3 for a sheet, E (t / w)^4 for a rod.  `metres_per_unit` converts the units of the samples.
template <class T>
BasicParticles<T> make_particles(const DrivingParticles& drivers, const SolidSamples& samples,
                                 const ElasticSamples& material, double metres_per_unit);

extern template BasicParticles<float> make_particles(const DrivingParticles&, const SolidSamples&,
                                                     const ElasticSamples&, double);
extern template BasicParticles<double> make_particles(const DrivingParticles&, const SolidSamples&,
                                                      const ElasticSamples&, double);

}  // namespace pliant

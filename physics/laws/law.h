#pragma once

#include "gaussians/base/types.h"
#include "physics/laws/material.h"

namespace pliant {

// Every function of this header takes any F (flat, inverted, 1e-8, 1e8) and gives finite results in float and double,
// as long as the material passes `validate_material`.  What a law means, where it holds and where it comes from stands
// in the file of its name.

/// A particle as its law sees it.
template <class T>
struct LawPoint {
  const Material* material;
  T mu, lambda;  ///< Lame parameters [Pa]
};

/// What a particle remembers besides its elastic deformation gradient F.
template <class T>
struct LawMemory {
  Mat3<T> F_total = Mat3<T>::Identity();    ///< of elastic and permanent deformation together; what is drawn
  Mat3<T> F_viscous = Mat3<T>::Identity();  ///< elastic part of the relaxing branch (viscoelastic)
  T history = 0;  ///< plastic strain (metal, plasticine), volume gained (sand), log of the plastic volume (snow)
};

/// Derivatives of a scalar with respect to the constants of the relaxing branch.
template <class T>
struct BranchGradient {
  T shear = 0, lambda = 0, viscosity = 0;

  BranchGradient& operator+=(const BranchGradient& other) {
    shear += other.shear;
    lambda += other.lambda;
    viscosity += other.viscosity;
    return *this;
  }
};

/// Derivatives of a scalar with respect to what a law reads.
template <class T>
struct LawGradient {
  Mat3<T> F = Mat3<T>::Zero(), F_viscous = Mat3<T>::Zero();
  T history = 0, mu = 0, lambda = 0;
  BranchGradient<T> branch = {};  ///< viscoelastic
};

/// Stored energy per rest volume, Psi [J/m^3].
template <class T>
T energy_density(const LawPoint<T>& point, const Mat3<T>& F, const LawMemory<T>& memory);

/// Kirchhoff stress tau = (dPsi/dF) F^T [Pa], symmetric; the relaxing branch adds its own.
template <class T>
Mat3<T> kirchhoff_stress(const LawPoint<T>& point, const Mat3<T>& F, const LawMemory<T>& memory);
template <class T>
LawGradient<T> kirchhoff_stress_adjoint(const LawPoint<T>& point, const Mat3<T>& F, const LawMemory<T>& memory,
                                        const Mat3<T>& adj_tau);

/// Whether stress follows from F alone: the law neither flows, yields nor relaxes, and has a reference configuration.
bool is_elastic(Law law);
/// Whether the material can go on giving way under a constant load: neither elastic nor viscoelastic, so that a shape
/// which was captured need not be one in which it stands.
bool flows(Law law);
/// First Piola-Kirchhoff stress P = dPsi/dF [Pa] of an elastic law.
template <class T>
Mat3<T> piola_stress(const LawPoint<T>& point, const Mat3<T>& F);
template <class T>
LawGradient<T> piola_stress_adjoint(const LawPoint<T>& point, const Mat3<T>& F, const Mat3<T>& adj_P);

/// Takes the trial state of a step of length dt, F = (I + dt C) F_n (F_viscous likewise), back to the yield surface.
/// F_total is not touched.
template <class T>
void return_map(const LawPoint<T>& point, T dt, Mat3<T>& F, LawMemory<T>& memory);
/// `adj` holds the derivatives with respect to the results (F, F_viscous, history); returned are those with respect to
/// the trial state and to mu, lambda.
template <class T>
LawGradient<T> return_map_adjoint(const LawPoint<T>& point, T dt, const Mat3<T>& trial_F,
                                  const LawMemory<T>& trial_memory, const LawGradient<T>& adj);

/// Viscous stress tau = 2 shear D + bulk tr(D) I of the strain rate D = (C + C^T) / 2.
template <class T>
struct Viscosity {
  T shear, bulk;  ///< Pa s
};
/// Kelvin-Voigt time times the Lame parameters; for a fluid its dynamic viscosity, free of volume change.
template <class T>
Viscosity<T> viscosity(const LawPoint<T>& point);

/// Modulus of plane pressure waves at rest [Pa], without branches and hardening: lambda + 2 mu, of a fluid K.
struct WaveModulus {
  double own = 0, by_mu = 2, by_lambda = 1;  ///< own + by_mu * mu + by_lambda * lambda

  explicit WaveModulus(const Material& m) {
    if (m.law != Law::kFluid) return;
    const double derived = m.bulk_modulus > 0 ? 0 : 1;
    own = m.bulk_modulus;
    by_mu = 2 * derived / 3;
    by_lambda = derived;
  }
  template <class T>
  T operator()(T mu, T lambda) const {
    return T(own) + T(by_mu) * mu + T(by_lambda) * lambda;
  }
};

/// Speed of the fastest elastic wave in the rest state [m/s], of all branches together.
double sound_speed(const Material& material, double young, double poisson, double density);

}  // namespace pliant

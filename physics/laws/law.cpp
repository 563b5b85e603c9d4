#include "physics/laws/law.h"

#include <cmath>

#include "gaussians/base/error.h"
#include "physics/laws/drucker_prager.h"
#include "physics/laws/fixed_corotated.h"
#include "physics/laws/fluid.h"
#include "physics/laws/hencky.h"
#include "physics/laws/neo_hookean.h"
#include "physics/laws/physgaussian.h"
#include "physics/laws/relaxation.h"
#include "physics/laws/snow.h"
#include "physics/laws/viscoplastic.h"
#include "physics/laws/von_mises.h"

namespace pliant {
namespace {

/// F scaled back until no entry exceeds 1000: no material gets there, and powers of such numbers overflow.
template <class T>
struct Bounded {
  T scale;
  Mat3<T> F;

  explicit Bounded(const Mat3<T>& unbounded) {
    constexpr T kLargest = T(1e3);
    const T size = unbounded.cwiseAbs().maxCoeff();
    scale = size > kLargest ? kLargest / size : T(1);
    F = unbounded * scale;
  }
};

template <class T>
Hencky<T> branch(const Material& m) {
  return {static_cast<T>(m.branch_shear), static_cast<T>(m.branch_lambda)};
}

template <class T>
Fluid<T> fluid(const LawPoint<T>& point) {
  const T bulk = static_cast<T>(point.material->bulk_modulus);
  return {bulk > T(0) ? bulk : point.lambda + 2 * point.mu / 3, static_cast<T>(point.material->pressure_exponent)};
}

/// Calls visit with the stored energy of the elastic part as a law of F.
template <class T, class Visit>
auto with_elastic(const LawPoint<T>& point, const LawMemory<T>& memory, Visit&& visit) {
  const Law law = point.material->law;
  if (point.material->as_physgaussian) {
    if (law == Law::kSnow) return visit(Stressless<T>{});
    if (law == Law::kMetal || law == Law::kFoam) return visit(StretchedHencky<T>{point.mu, point.lambda});
  }
  switch (law) {
    case Law::kFixedCorotated:
    case Law::kViscoelastic:
      break;
    case Law::kNeoHookean:
      return visit(NeoHookean<T>{point.mu, point.lambda});
    case Law::kHencky:
    case Law::kMetal:
    case Law::kSand:
    case Law::kFoam:
    case Law::kPlasticine:
      return visit(Hencky<T>{point.mu, point.lambda});
    case Law::kSnow: {
      const T factor = SnowHardening<T>(point.material->compaction_hardening, memory.history).factor;
      return visit(FixedCorotated<T>{factor * point.mu, factor * point.lambda});
    }
    case Law::kFluid:
      return visit(fluid(point));
  }
  return visit(FixedCorotated<T>{point.mu, point.lambda});
}

/// Calls visit with the return map of the principal stretches of F; not at all for laws without one.
template <class Visit>
void with_return_map(const Material& m, double dt, Visit&& visit) {
  switch (m.law) {
    case Law::kMetal:
    case Law::kPlasticine:
      return visit(VonMises{m.yield_stress, m.hardening});
    case Law::kSand:
      return visit(DruckerPrager{DruckerPrager::alpha_of(m.friction_angle)});
    case Law::kSnow:
      return visit(SnowClamp{m.critical_compression, m.critical_stretch});
    case Law::kFoam:
      return visit(Viscoplastic{m.yield_stress, m.plastic_viscosity, dt});
    case Law::kFixedCorotated:
    case Law::kNeoHookean:
    case Law::kHencky:
    case Law::kFluid:
    case Law::kViscoelastic:
      break;
  }
}

Relaxation relaxation(const Material& m, double dt) { return {m.branch_viscosity, dt}; }

}  // namespace

template <class T>
T energy_density(const LawPoint<T>& point, const Mat3<T>& F, const LawMemory<T>& memory) {
  T energy = with_elastic(point, memory, [&](const auto& law) { return law.energy(Bounded<T>(F).F); });
  if (point.material->law == Law::kViscoelastic)
    energy += branch<T>(*point.material).energy(Bounded<T>(memory.F_viscous).F);
  return energy;
}

template <class T>
Mat3<T> kirchhoff_stress(const LawPoint<T>& point, const Mat3<T>& F, const LawMemory<T>& memory) {
  Mat3<T> tau = with_elastic(point, memory, [&](const auto& law) -> Mat3<T> { return law.stress(Bounded<T>(F).F); });
  if (point.material->law == Law::kViscoelastic)
    tau += branch<T>(*point.material).stress(Bounded<T>(memory.F_viscous).F);
  return tau;
}

template <class T>
LawGradient<T> kirchhoff_stress_adjoint(const LawPoint<T>& point, const Mat3<T>& F, const LawMemory<T>& memory,
                                        const Mat3<T>& adj_tau) {
  const Material& m = *point.material;
  const Bounded<T> bounded(F);
  LawGradient<T> g =
      with_elastic(point, memory, [&](const auto& law) { return law.stress_adjoint(bounded.F, adj_tau); });
  g.F *= bounded.scale;
  if (m.law == Law::kSnow) {
    const SnowHardening<T> hardening(m.compaction_hardening, memory.history);
    g.history = hardening.slope * (g.mu * point.mu + g.lambda * point.lambda);
    g.mu *= hardening.factor;
    g.lambda *= hardening.factor;
  }
  if (m.law == Law::kFluid) {
    if (m.bulk_modulus > 0) g.lambda = 0;
    g.mu = 2 * g.lambda / 3;
  }
  if (m.law == Law::kViscoelastic) {
    const Bounded<T> viscous(memory.F_viscous);
    const LawGradient<T> by = branch<T>(m).stress_adjoint(viscous.F, adj_tau);
    g.F_viscous = by.F * viscous.scale;
    g.branch = {by.mu, by.lambda, T(0)};
  }
  return g;
}

bool is_elastic(Law law) { return law == Law::kFixedCorotated || law == Law::kNeoHookean || law == Law::kHencky; }

bool flows(Law law) { return !is_elastic(law) && law != Law::kViscoelastic; }

template <class T>
Mat3<T> piola_stress(const LawPoint<T>& point, const Mat3<T>& F) {
  const Law law = point.material->law;
  CHECK(is_elastic(law));
  const Mat3<T> bounded = Bounded<T>(F).F;
  if (law == Law::kNeoHookean) return NeoHookean<T>{point.mu, point.lambda}.piola(bounded);
  if (law == Law::kHencky) return Hencky<T>{point.mu, point.lambda}.piola(bounded);
  return FixedCorotated<T>{point.mu, point.lambda}.piola(bounded);
}

template <class T>
LawGradient<T> piola_stress_adjoint(const LawPoint<T>& point, const Mat3<T>& F, const Mat3<T>& adj_P) {
  const Law law = point.material->law;
  CHECK(is_elastic(law));
  const Bounded<T> bounded(F);
  LawGradient<T> g = law == Law::kNeoHookean ? NeoHookean<T>{point.mu, point.lambda}.piola_adjoint(bounded.F, adj_P)
                     : law == Law::kHencky   ? Hencky<T>{point.mu, point.lambda}.piola_adjoint(bounded.F, adj_P)
                                           : FixedCorotated<T>{point.mu, point.lambda}.piola_adjoint(bounded.F, adj_P);
  g.F *= bounded.scale;
  return g;
}

template <class T>
void return_map(const LawPoint<T>& point, T dt, Mat3<T>& F, LawMemory<T>& memory) {
  const Material& m = *point.material;
  with_return_map(m, dt,
                  [&](const auto& map) { principal_return_map(map, point.mu, point.lambda, F, memory.history); });
  if (m.law == Law::kFluid) {
    F = Bounded<T>(F).F;
    Fluid<T>::return_map(F);
  }
  if (m.law == Law::kViscoelastic) {
    T unused = 0;
    principal_return_map(relaxation(m, dt), T(m.branch_shear), T(m.branch_lambda), memory.F_viscous, unused);
  }
}

template <class T>
LawGradient<T> return_map_adjoint(const LawPoint<T>& point, T dt, const Mat3<T>& trial_F,
                                  const LawMemory<T>& trial_memory, const LawGradient<T>& adj) {
  const Material& m = *point.material;
  LawGradient<T> g;
  g.F = adj.F;
  g.F_viscous = adj.F_viscous;
  g.history = adj.history;
  with_return_map(m, dt, [&](const auto& map) {
    g = principal_return_map_adjoint(map, point.mu, point.lambda, trial_F, trial_memory.history, adj.F, adj.history);
    g.F_viscous = adj.F_viscous;
  });
  if (m.law == Law::kFluid) g.F = Fluid<T>::return_map_adjoint(Bounded<T>(trial_F).F, adj.F);
  if (m.law == Law::kViscoelastic) {
    const T shear = T(m.branch_shear), lambda = T(m.branch_lambda), viscosity = T(m.branch_viscosity);
    const LawGradient<T> by = principal_return_map_adjoint(relaxation(m, dt), shear, lambda, trial_memory.F_viscous,
                                                           T(0), adj.F_viscous, T(0));
    g.F_viscous = by.F;
    // The strain that is left depends on the ratios to the viscosity alone (Euler's theorem).
    g.branch = {by.mu, by.lambda, -(by.mu * shear + by.lambda * lambda) / viscosity};
  }
  return g;
}

template <class T>
Viscosity<T> viscosity(const LawPoint<T>& point) {
  const Material& m = *point.material;
  if (m.law == Law::kFluid) {
    const T shear = static_cast<T>(m.dynamic_viscosity);
    return {shear, -2 * shear / 3};
  }
  const T time = static_cast<T>(m.viscosity_time);
  return {time * point.mu, time * point.lambda};
}

double sound_speed(const Material& m, double young, double poisson, double density) {
  const Lame<double> l = lame(young, poisson);
  double modulus = WaveModulus(m)(l.mu, l.lambda);
  if (m.law == Law::kSnow) modulus *= SnowHardening<double>::largest(m.compaction_hardening);
  if (m.law == Law::kViscoelastic) modulus += m.branch_lambda + 2 * m.branch_shear;
  return std::sqrt(modulus / density);
}

#define PLIANT_INSTANTIATE_LAW(T)                                                                           \
  template T energy_density(const LawPoint<T>&, const Mat3<T>&, const LawMemory<T>&);                       \
  template Mat3<T> kirchhoff_stress(const LawPoint<T>&, const Mat3<T>&, const LawMemory<T>&);               \
  template LawGradient<T> kirchhoff_stress_adjoint(const LawPoint<T>&, const Mat3<T>&, const LawMemory<T>&, \
                                                   const Mat3<T>&);                                         \
  template Mat3<T> piola_stress(const LawPoint<T>&, const Mat3<T>&);                                        \
  template LawGradient<T> piola_stress_adjoint(const LawPoint<T>&, const Mat3<T>&, const Mat3<T>&);         \
  template void return_map(const LawPoint<T>&, T, Mat3<T>&, LawMemory<T>&);                                 \
  template LawGradient<T> return_map_adjoint(const LawPoint<T>&, T, const Mat3<T>&, const LawMemory<T>&,    \
                                             const LawGradient<T>&);                                        \
  template Viscosity<T> viscosity(const LawPoint<T>&);
PLIANT_INSTANTIATE_LAW(float)
PLIANT_INSTANTIATE_LAW(double)
#undef PLIANT_INSTANTIATE_LAW

}  // namespace pliant

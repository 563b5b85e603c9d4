#include "physics/simulate/energy.h"

#include "physics/laws/law.h"

namespace pliant {

template <class T>
double kinetic_energy(const BasicParticles<T>& particles, const BasicSimulationState<T>& state) {
  const T affine = particles.cell_size * particles.cell_size / 4;
  double sum = 0;
  for (size_t i = 0; i < state.size(); ++i)
    sum += 0.5 * double(particles.mass[i]) * (state.v[i].squaredNorm() + affine * state.C[i].squaredNorm());
  return sum;
}

template <class T>
double elastic_energy(const BasicParticles<T>& particles, const BasicSimulationState<T>& state) {
  double sum = 0;
  for (size_t i = 0; i < state.size(); ++i) {
    // In double: Psi of small strains is a difference of numbers near 1.
    const Lame<double> law = lame<double>(particles.young[i], particles.poisson[i]);
    LawMemory<double> memory;
    if (!state.memory.empty()) {
      const LawMemory<T>& m = state.memory[i];
      memory.F_total = m.F_total.template cast<double>();
      memory.F_viscous = m.F_viscous.template cast<double>();
      memory.history = m.history;
    }
    sum += particles.volume[i] * energy_density<double>({&particles.material(i), law.mu, law.lambda},
                                                        state.F[i].template cast<double>(), memory);
  }
  return sum;
}

template double kinetic_energy(const BasicParticles<float>&, const BasicSimulationState<float>&);
template double kinetic_energy(const BasicParticles<double>&, const BasicSimulationState<double>&);
template double elastic_energy(const BasicParticles<float>&, const BasicSimulationState<float>&);
template double elastic_energy(const BasicParticles<double>&, const BasicSimulationState<double>&);

}  // namespace pliant

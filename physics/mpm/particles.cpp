#include "physics/mpm/particles.h"

#include <algorithm>

namespace pliant {

template <class T>
double BasicParticles<T>::total_mass() const {
  double sum = 0;
  for (const T m : mass) sum += m;
  return sum;
}

template <class T>
double BasicParticles<T>::total_volume() const {
  double sum = 0;
  for (const T v : volume) sum += v;
  return sum;
}

template <class T>
bool BasicParticles<T>::has_memory() const {
  return std::any_of(materials.begin(), materials.end(), [](const Material& m) { return pliant::has_memory(m.law); });
}

template <class T>
BasicSimulationState<T> initial_state(const BasicParticles<T>& particles) {
  BasicSimulationState<T> state;
  state.x = particles.position;
  state.v.assign(particles.size(), Vec3<T>::Zero());
  state.C.assign(particles.size(), Mat3<T>::Zero());
  state.F.assign(particles.size(), Mat3<T>::Identity());
  if (particles.has_memory()) state.memory.assign(particles.size(), {});
  return state;
}

template struct BasicParticles<float>;
template struct BasicParticles<double>;
template BasicSimulationState<float> initial_state(const BasicParticles<float>&);
template BasicSimulationState<double> initial_state(const BasicParticles<double>&);

}  // namespace pliant

#include "physics/particles.h"

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
BasicSimulationState<T> initial_state(const BasicParticles<T>& particles) {
  BasicSimulationState<T> state;
  state.x = particles.position;
  state.v.assign(particles.size(), Vec3<T>::Zero());
  state.C.assign(particles.size(), Mat3<T>::Zero());
  state.F.assign(particles.size(), Mat3<T>::Identity());
  return state;
}

template struct BasicParticles<float>;
template struct BasicParticles<double>;
template BasicSimulationState<float> initial_state(const BasicParticles<float>&);
template BasicSimulationState<double> initial_state(const BasicParticles<double>&);

}  // namespace pliant

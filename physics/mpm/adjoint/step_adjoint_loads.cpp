// What loads give to single particles, and the way back: to the particles, and to the loads by the sums of all blocks.

#include <vector>

#include "physics/laws/law.h"
#include "physics/mpm/adjoint/step_adjoint.h"
#include "physics/mpm/mpm.h"

namespace pliant {

/// [count, 3] what the loads give to single particles; see `Mpm::apply_body_loads`.
template <class T>
std::vector<T> StepAdjoint<T>::gains(const TapeStep<T>& step, int b, const TapeParticle<T>* particle) const {
  std::vector<T> gain;
  for (int s = step.begin[b]; s < step.begin[b + 1]; ++s, ++particle) {
    const AdjointRecord<T>& r = record_[slot_[step.index[s]]];
    Vec3<T> sum = Vec3<T>::Zero();
    if (r.bits != 0) {
      LoadedParticle<T> p = loaded_particle(solver_, r, particle->x, particle->v, particle->F);
      if (has_memory(solver_, r)) p.F = step.memory[r.side].F_total;
      for (const BodyLoad<T>& load : step.loads.body)
        if (r.bits & load.bit) sum += velocity_gain(load, step.dt, p);
    }
    gain.insert(gain.end(), sum.data(), sum.data() + 3);
  }
  return gain;
}

/// [count, 3] velocities with those; empty where there are no loads.
template <class T>
std::vector<T> StepAdjoint<T>::loaded_velocities(const TapeStep<T>& step, int b) const {
  if (step.loads.body.empty()) return {};
  const TapeParticle<T>* particle = step.particle.data() + step.begin[b];
  std::vector<T> velocity = gains(step, b, particle);
  for (size_t k = 0; k < velocity.size(); ++k) velocity[k] += particle[k / 3].v[k % 3];
  return velocity;
}

template <class T>
void StepAdjoint<T>::reverse_body_loads(const TapeStep<T>& step, int b, const TapeParticle<T>* particle,
                                        const T* by_gains) {
  using RowMajor = Eigen::Matrix<T, 3, 3, Eigen::RowMajor>;
  BodyLoadGradient* by_load = block_sums_.data() + b * step.loads.body.size();
  for (int s = step.begin[b]; s < step.begin[b + 1]; ++s) {
    AdjointRecord<T>& r = record_[slot_[step.index[s]]];
    if (r.bits == 0) continue;
    const TapeParticle<T>& of = particle[s - step.begin[b]];
    LoadedParticle<T> p = loaded_particle(solver_, r, of.x, of.v, of.F);
    const bool remembers = has_memory(solver_, r);
    if (remembers) p.F = step.memory[r.side].F_total;
    const T* by = by_gains ? by_gains + 3 * (s - step.begin[b]) : r.v;
    const Vec3<T> by_gain(by[0], by[1], by[2]);
    LoadedParticleGradient<T> sum;
    for (size_t l = 0; l < step.loads.body.size(); ++l)
      if (r.bits & step.loads.body[l].bit)
        velocity_gain_adjoint(step.loads.body[l], step.dt, p, by_gain, sum, by_load[l]);
    for (int a = 0; a < 3; ++a) {
      r.x[a] += sum.x[a];
      r.v[a] += sum.v[a];
    }
    if (remembers)
      memory_[r.side].F_total += sum.F;
    else
      Eigen::Map<RowMajor>(r.F) += sum.F;
    // The stiffness is the modulus times V / (m dx^2).
    const WaveModulus modulus(solver_.materials[r.material]);
    const T by_modulus = sum.stiffness * r.volume / r.mass * solver_.inverse_dx * solver_.inverse_dx;
    r.by_mass += sum.mass - sum.stiffness * p.stiffness / r.mass;
    r.by_mu += T(modulus.by_mu) * by_modulus;
    r.by_lambda += T(modulus.by_lambda) * by_modulus;
  }
}

template <class T>
StepLoadsGradient StepAdjoint<T>::sum_loads(const TapeStep<T>& step) const {
  StepLoadsGradient sum;
  for (const StepLoadsGradient& s : node_sums_) {
    sum.gravity += s.gravity;
    sum.velocity_scale += s.velocity_scale;
  }
  for (int n = 0; n < static_cast<int>(by_density_.size()); ++n) {
    const size_t object = static_cast<size_t>(step.grid->node_block(n).object);
    if (sum.density.size() <= object) sum.density.resize(object + 1);
    sum.density[object] += by_density_[n];
  }
  const size_t loads = step.loads.body.size();
  sum.body.resize(loads);
  for (size_t k = 0; k < block_sums_.size(); ++k) {
    const BodyLoadGradient& s = block_sums_[k];
    BodyLoadGradient& body = sum.body[k % loads];
    body.acceleration += s.acceleration;
    body.angular += s.angular;
    body.centre += s.centre;
    body.wind += s.wind;
    body.per_volume += s.per_volume;
    body.drag += s.drag;
  }
  return sum;
}

template class StepAdjoint<float>;
template class StepAdjoint<double>;

}  // namespace pliant

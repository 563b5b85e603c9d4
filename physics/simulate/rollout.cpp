#include "physics/simulate/rollout.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "gaussians/base/error.h"
#include "physics/laws/material.h"
#include "physics/simulate/simulator.h"

namespace pliant {
namespace {

double seconds_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

SimulateOptions fixed_step(const RolloutOptions& options, int substeps) {
  SimulateOptions fixed = options.simulate;
  fixed.substeps = substeps;
  fixed.max_retries = 0;
  fixed.sleep_speed = 0;
  return fixed;
}

/// Number of parts into which n substeps are cut so that one part and a snapshot per part fit into the memory; if none
/// does, the number that needs least.
int parts_of(int n, size_t step_bytes, size_t snapshot_bytes, size_t memory) {
  if (n * step_bytes <= memory) return 1;
  int best = 1;
  size_t least = SIZE_MAX;
  for (int parts = 2; parts <= n; ++parts) {
    const size_t bytes = (n + parts - 1) / parts * step_bytes + parts * snapshot_bytes;
    if (bytes < least) {
      least = bytes;
      best = parts;
    }
    if (bytes <= memory) return parts;
  }
  return best;
}

/// dL/d(E, nu) of dL/d(mu, lambda).
template <class T>
void add_young_and_poisson(const BasicParticles<T>& particles, const ParticleGradient<T>& by,
                           RolloutGradient<T>& result) {
  for (size_t i = 0; i < particles.size(); ++i) {
    const T E = particles.young[i], nu = particles.poisson[i], a = 1 + nu, b = 1 - 2 * nu;
    const Lame<T> law = lame(E, nu);
    result.young[i] = (by.mu[i] * law.mu + by.lambda[i] * law.lambda) / E;
    result.poisson[i] = -by.mu[i] * law.mu / a + by.lambda[i] * E * (1 + 2 * nu * nu) / (a * a * b * b);
  }
}

/// By the times of damping, of the options (all particles) and of the materials (their own), and by relaxing branches.
template <class T>
void add_materials(const BasicParticles<T>& particles, const ParticleGradient<T>& by, RolloutGradient<T>& result) {
  result.material.resize(particles.materials.size());
  for (size_t i = 0; i < particles.size(); ++i) {
    const size_t m = particles.material_index.empty() ? 0 : particles.material_index[i];
    const Material& material = particles.materials[m];
    result.viscosity_time += by.viscosity_time[i];
    // The rate is 2 / time.
    if (const double time = material.damping_time; time > 0)
      result.material[m].damping_time -= 2 / (time * time) * by.damping_rate[i];
    if (material.viscosity_time > 0 && material.law != Law::kFluid)
      result.material[m].viscosity_time += by.viscosity_time[i];
    if (!by.branch.empty())
      result.material[m].branch += {by.branch[i].shear, by.branch[i].lambda, by.branch[i].viscosity};
  }
}

/// Goes back through the frames of a roll-out.
template <class T>
class Reverser {
 public:
  Reverser(const RolloutOptions& options, const BasicParticles<T>& particles,
           const std::vector<Interaction>& interactions, int substeps)
      : options_(fixed_step(options, substeps)),
        memory_(options.memory),
        substeps_(substeps),
        given_(options.gradient_substeps > 0 ? std::max(0, substeps - options.gradient_substeps) : 0),
        simulator_(options_, particles, interactions, summary_),
        adjoint_(simulator_.particles(), simulator_.solver().data()),
        loads_(interactions.size()) {}

  /// From derivatives by `end` to those by `start`, one frame before it.
  void reverse(const BasicSimulationState<T>& start, const BasicSimulationState<T>& end, StateGradient<T>& gradient) {
    Mpm<T>& solver = simulator_.solver();
    auto clock = std::chrono::steady_clock::now();
    simulator_.begin_frame(start);
    const size_t step_bytes = solver.tape_bytes(), snapshot_bytes = solver.snapshot_bytes();
    run(start, 0, given_, nullptr);
    const int followed = substeps_ - given_, parts = parts_of(followed, step_bytes, snapshot_bytes, memory_);
    const auto first_of = [&](int part) { return given_ + static_cast<int>(int64_t{followed} * part / parts); };
    snapshots_.resize(parts);
    for (int part = 0; part + 1 < parts; ++part) {
      snapshots_[part] = solver.save();
      run(start, first_of(part), first_of(part + 1), nullptr);
    }
    for (int part = parts - 1; part >= 0; --part) {
      if (part < parts - 1) solver.restore(snapshots_[part]);
      const int first = first_of(part);
      tape_.clear();
      run(start, first, first_of(part + 1), &tape_);
      forward_seconds_ += seconds_since(clock);
      clock = std::chrono::steady_clock::now();
      if (part == parts - 1) adjoint_.load(gradient, end, tape_);
      const double time = start.frame / options_.fps, dt = simulator_.time_step(substeps_);
      adjoint_.reverse(tape_, [&](int k, const StepLoadsGradient& by_loads) {
        simulator_.schedule().at_adjoint(time + (first + k) * dt, dt, tape_[k], by_loads, adjoint_, loads_);
      });
      reverse_seconds_ += seconds_since(clock);
      clock = std::chrono::steady_clock::now();
    }
    if (given_ > 0)
      gradient = StateGradient<T>::zero(start.size());
    else
      adjoint_.store(start, tape_, gradient);
    bytes_ = std::max(bytes_, tape_.bytes() + (parts > 1 ? parts * snapshot_bytes : 0) + adjoint_.bytes());
  }

  void finish(const BasicParticles<T>& particles, RolloutGradient<T>& result) const {
    const ParticleGradient<T> by = adjoint_.particle_gradient();
    result.mass = by.mass;
    result.weight = simulator_.schedule().add_by_mass(particles, loads_, result.mass);
    add_young_and_poisson(particles, by, result);
    simulator_.schedule().add_by_young(particles, loads_, result.young);
    result.interaction = loads_.vector;
    result.gravity = loads_.gravity;
    result.damping_time = loads_.damping_time;
    add_materials(particles, by, result);
    if (!(options_.viscosity_time > 0)) result.viscosity_time = 0;
    result.forward_seconds = forward_seconds_;
    result.reverse_seconds = reverse_seconds_;
    result.bytes = bytes_;
  }

 private:
  void run(const BasicSimulationState<T>& start, int first, int last, StepTape<T>* tape) {
    if (!simulator_.run(start, substeps_, first, last, tape))
      throw numerical_error("rollout", "frame " + std::to_string(start.frame + 1) + " is unstable",
                            "give more substeps, or lower forces and Young's modulus");
  }

  SimulateOptions options_;
  size_t memory_;
  int substeps_, given_;  // in a frame, and those of them at its start that gradients do not reach
  SimulateSummary summary_;
  Simulator<T> simulator_;
  StepAdjoint<T> adjoint_;
  LoadsGradient loads_;
  StepTape<T> tape_;
  std::vector<typename Mpm<T>::Snapshot> snapshots_;
  double forward_seconds_ = 0, reverse_seconds_ = 0;
  size_t bytes_ = 0;
};

}  // namespace

template <class T>
Rollout<T> rollout(const RolloutOptions& options, const BasicParticles<T>& particles,
                   const std::vector<Interaction>& interactions, const BasicSimulationState<T>& start) {
  Rollout<T> result;
  result.substeps = options.simulate.substeps;
  if (result.substeps == 0) {
    SimulateSummary unused;
    result.substeps = Simulator<T>(options.simulate, particles, interactions, unused).substeps_of(start);
  }
  result.summary = simulate<T>(fixed_step(options, result.substeps), particles, interactions, start,
                               [&](const BasicSimulationState<T>& state) {
                                 result.frames.push_back(state);
                                 return true;
                               })
                       .summary;
  if (start.frame != 0) result.frames.insert(result.frames.begin(), start);
  return result;
}

template <class T>
RolloutGradient<T> rollout_adjoint(const RolloutOptions& options, const BasicParticles<T>& particles,
                                   const std::vector<Interaction>& interactions, const Rollout<T>& rollout,
                                   const FrameCotangent<T>& cotangent) {
  CHECK(!rollout.frames.empty() && rollout.substeps > 0);
  const auto require_count = [](const char* field, int value) {
    if (value < 0)
      throw usage_error("rollout", field, "is " + std::to_string(value), "give a positive number; 0 = all");
  };
  require_count("gradient_window", options.gradient_window);
  require_count("gradient_substeps", options.gradient_substeps);
  const size_t n = particles.size();
  RolloutGradient<T> result;
  result.start = StateGradient<T>::zero(n);
  result.young.resize(n);
  result.poisson.resize(n);
  Reverser<T> reverser(options, particles, interactions, rollout.substeps);
  for (int k = static_cast<int>(rollout.frames.size()) - 1; k > 0; --k) {
    if (options.gradient_window > 0 && k % options.gradient_window == 0) result.start = StateGradient<T>::zero(n);
    cotangent(k, result.start);
    reverser.reverse(rollout.frames[k - 1], rollout.frames[k], result.start);
  }
  cotangent(0, result.start);
  reverser.finish(particles, result);
  const size_t of_nodes = 2 * rollout.frames.back().node_velocity.size() * sizeof(Vec3<T>);
  result.bytes += rollout.frames.size() * (n * sizeof(TapeParticle<T>) + of_nodes);
  return result;
}

#define PLIANT_ROLLOUT(T)                                                                                       \
  template Rollout<T> rollout(const RolloutOptions&, const BasicParticles<T>&, const std::vector<Interaction>&, \
                              const BasicSimulationState<T>&);                                                  \
  template RolloutGradient<T> rollout_adjoint(const RolloutOptions&, const BasicParticles<T>&,                  \
                                              const std::vector<Interaction>&, const Rollout<T>&,               \
                                              const FrameCotangent<T>&);
PLIANT_ROLLOUT(float)
PLIANT_ROLLOUT(double)

}  // namespace pliant

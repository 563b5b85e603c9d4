#pragma once

#include <functional>
#include <vector>

#include "physics/mpm/mpm.h"
#include "physics/simulate/loads.h"
#include "physics/simulate/simulate.h"

namespace pliant {

/// The fastest wave in a body at rest.
struct FastestWave {
  double speed = 0;     ///< m/s; viscosity counts as the speed whose time step it asks for
  size_t particle = 0;  ///< through which it runs
};
/// That on cells of `dx` [m].  The time step of a body at rest is `options.courant` dx / speed.
template <class T>
FastestWave fastest_wave(const SimulateOptions& options, const BasicParticles<T>& particles, double dx);
/// Substeps of a frame in which that body rests; `options.substeps` where these are given.
template <class T>
double substeps_at_rest(const SimulateOptions& options, const BasicParticles<T>& particles);

/// Advances one body frame by frame: the inside of `simulate` and of roll-outs.
template <class T>
class Simulator {
 public:
  /// `summary` must outlive this.
  Simulator(const SimulateOptions& options, const BasicParticles<T>& particles,
            const std::vector<Interaction>& interactions, SimulateSummary& summary);

  const LoadSchedule<T>& schedule() const { return schedule_; }
  Mpm<T>& solver() { return solver_; }
  /// What moves: the particles with the weights that hang on them.
  const BasicParticles<T>& particles() const { return particles_; }
  /// Continues the path of grab or finger `k`.
  void set_path(size_t k, const std::vector<Interaction::PathPoint>& path) { schedule_.set_path(k, path); }

  /// Substeps of the next frame: `options.substeps`, or what the Courant number asks for.
  int substeps_of(const BasicSimulationState<T>& state) const;

  /// Advances `state` by one frame, with a smaller time step again if it becomes unstable.  `glance` is called after
  /// every time step, and may store the solver's state.
  void advance(BasicSimulationState<T>& state, const std::function<void()>& glance = {});

  /// Loads the start of a frame into the solver.
  void begin_frame(const BasicSimulationState<T>& state);
  /// Takes substeps [first, last) of `substeps` of the frame that starts at `state`; false when unstable.
  bool run(const BasicSimulationState<T>& state, int substeps, int first, int last, StepTape<T>* tape = nullptr,
           const std::function<void()>& glance = {});
  double time_step(int substeps) const { return 1 / options_.fps / substeps; }
  bool interrupted() const { return options_.interrupted && options_.interrupted(); }

 private:
  void see_border(int frame);
  double fastest(const BasicSimulationState<T>& state) const;
  double courant_number(double speed, double dt, double limit, double jump) const;

  SimulateOptions options_;
  BasicParticles<T> particles_;
  double dx_, diagonal_ = 0, sound_speed_ = 0;
  double courant_number_ = 0;  // of the last substep
  bool lagrangian_;
  LoadSchedule<T> schedule_;
  Mpm<T> solver_;
  StepLoads<T> loads_;
  SimulateSummary& summary_;
  std::vector<Vec3d> impulse_;  // [interactions] N s since the frame began
};

extern template FastestWave fastest_wave(const SimulateOptions&, const BasicParticles<float>&, double);
extern template FastestWave fastest_wave(const SimulateOptions&, const BasicParticles<double>&, double);
extern template double substeps_at_rest(const SimulateOptions&, const BasicParticles<float>&);
extern template double substeps_at_rest(const SimulateOptions&, const BasicParticles<double>&);
extern template class Simulator<float>;
extern template class Simulator<double>;

}  // namespace pliant

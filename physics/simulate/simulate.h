#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "physics/mpm/particles.h"
#include "physics/simulate/interaction.h"

namespace pliant {

constexpr int kMaxSubstepsOfFrame = 1 << 20;
constexpr double kFarStretch = 2;  ///< beyond which nobody has measured most materials' laws

/// Beyond this Poisson's ratio bodies are noticeably too stiff (volumetric locking): the height of a beam being six
/// cells, it sags by 2 % too little at .47, 3 % at .48, 7 % at .49 and 26 % at .499 (tests/studies/beam_study.cpp).
constexpr double kLockingPoisson = 0.48;

/// What the captured shape of a body that a pin holds and that does not flow means.
enum class RestShapeMode {
  kCaptured,  ///< it is free of stress, and the gravity under which it was captured is cancelled
  kSolve,     ///< it is in equilibrium under gravity: the unloaded shape is found, the body carries the pre-stress
};

/// Where stencils lie.
enum class GridKind {
  kAutomatic,   ///< Lagrangian where it can be
  kEulerian,    ///< under the particles as they move: for every law, and what peers do
  kLagrangian,  ///< where the particles were at rest: elastic bodies neither tear nor stick; see MpmOptions
};

struct SimulateOptions {
  double fps = 30;
  double duration = 3;            ///< s; frames = round(fps * duration)
  double courant = 0.4;           ///< chosen (c + |v|) dt / dx, c = sqrt((lambda + 2 mu) / rho)
  double courant_cap = 0.6;       ///< a frame in which it is exceeded is repeated with half the time step
  int substeps = 0;               ///< per frame; 0 = from `courant`
  Vec3d gravity = {0, 0, -9.81};  ///< m/s^2; see below
  double damping_time = 0;        ///< s in which mass-proportional damping lowers an amplitude to 1/e, and the speed of
                                  ///< a free body to 1/e^2; 0 = none
  double viscosity_time = 0;      ///< s, Kelvin-Voigt: stress of strain + time * strain rate; 0 = none
  double strain_rate_damping = 0;  ///< 1/s at which the symmetric part of the particles' affine velocity decays (RPIC,
                                   ///< Jiang et al. 2015); infinity = at once
  bool pic = false;                ///< transfers without affine velocity (PIC); strongly damped, for comparison
  double cell_size = 0;            ///< m; 0 = that of the particles
  double settle_time = 0;          ///< s, at most, of settling before frame 0, where gravity is not cancelled
  RestShapeMode rest_shape = RestShapeMode::kCaptured;  ///< of bodies that a pin holds
  std::optional<bool> held_as_captured = {};  ///< a pin held the body as it was captured; none = where one does at 0 s
  double object_friction =
      0.5;  ///< Coulomb coefficient between the objects of `particles`, and of parts of one that meet
  int max_substeps = kMaxSubstepsOfFrame;  ///< a frame that needs more fails
  int max_retries = 4;                     ///< halvings of the time step before a frame is given up
  double flip_time = 0;                    ///< s, 0 = APIC; see MpmOptions
  double sleep_speed = 0;                  ///< m/s, 0 = off; see MpmOptions
  GridKind grid = GridKind::kAutomatic;
  std::function<bool()> interrupted = {};  ///< asked while a body settles before frame 0; true throws kInterrupted
};

struct SimulateSummary {
  int frames = 0;                      ///< computed
  std::vector<int> substeps_of_frame;  ///< [frames]
  double min_dt = 0, max_dt = 0;       ///< s
  double mass = 0;                     ///< kg
  double cell_size = 0;                ///< m
  double max_displacement = 0;         ///< m, largest distance of a particle from its rest position over all frames
  double max_stretch = 0;              ///< of elastic material in any frame, where beyond kFarStretch, else 0
  int max_stretch_frame = 0;
  Vec3d max_stretch_place = Vec3d::Zero();  ///< m, at rest
  double settle_displacement = 0;           ///< m, moved before frame 0
  double settle_seconds = 0;                ///< s, simulated before frame 0
  double rest_shape_residual = 0;           ///< m, of the solved rest shape: captured shape against equilibrium
  double rest_shape_sag = 0;                ///< m, captured against unloaded shape
  int rest_shape_iterations = 0;
  double thin_share = 0;  ///< of the particles, in parts thinner than 3 cells
  Box thin_bounds;        ///< m, of those
  int64_t strays = 0;     ///< times a particle was put back at the border of the grid, which is far away
  int retries = 0;        ///< frames repeated with a smaller time step
  int64_t particle_substeps = 0;
  double seconds = 0;  ///< wall time of the solver
  /// [frames][interactions] momentum [N s] that each gave to the body; over the frame's length, its mean force [N].
  std::vector<std::vector<Vec3d>> impulse_of_frame;
  bool gravity_cancelled = false;  ///< a pin holds the body, which does not flow: its captured shape is its equilibrium
  std::vector<std::string> warnings;
};

/// Why these particles cannot be simulated on a Lagrangian grid, as a clause; empty when they can.
template <class T>
std::string why_not_lagrangian(const SimulateOptions& options, const BasicParticles<T>& particles);

/// Whether they are: as `options` say, or where nothing speaks against it.
template <class T>
bool is_lagrangian(const SimulateOptions& options, const BasicParticles<T>& particles) {
  return options.grid == GridKind::kLagrangian ||
         (options.grid == GridKind::kAutomatic && why_not_lagrangian(options, particles).empty());
}

template <class T>
struct BasicSimulateResult {
  BasicSimulationState<T> state;  ///< last frame
  bool stopped = false;           ///< the sink asked to stop
  SimulateSummary summary;
};
using SimulateResult = BasicSimulateResult<float>;

/// Receives the state of each frame, from one thread; false stops the simulation.
template <class T>
using BasicFrameSink = std::function<bool(const BasicSimulationState<T>&)>;
using FrameSink = BasicFrameSink<float>;

/// MLS-MPM (Hu et al. 2018) with APIC (Jiang et al. 2015) and quadratic B-splines under `interactions`, from `start`
/// to `duration`.  A start at frame 0 is settled and handed to the sink first; a later one continues.  Positions of
/// the regions are those of the rest shape.
/// Gravity: the captured shape of a body that a pin holds at the start is already loaded, so while one holds it, what
/// acts is the difference of the world's gravity from `options.gravity`; when the last pin ends the whole of it acts,
/// as it does always on a body that no pin holds at the start or part of which flows (see law.h).  With
/// RestShapeMode::kSolve the whole of it acts always, on a body that starts with the stress that balances it; what
/// `start` differs by from rest is added to that.
/// Trajectories are equal bit for bit for any number of threads and across save and restore.
/// Throws Error{kUsage} for impossible options, particles or interactions, Error{kNumerical} when a frame stays
/// unstable after all retries (the sink then has every good frame).
template <class T>
BasicSimulateResult<T> simulate(const SimulateOptions& options, const BasicParticles<T>& particles,
                                const std::vector<Interaction>& interactions, BasicSimulationState<T> start,
                                const BasicFrameSink<T>& sink = {});

/// As above; `summary` is that of the frames up to `start`, goes on with those after it, and may be read by the sink.
template <class T>
BasicSimulateResult<T> simulate(const SimulateOptions& options, const BasicParticles<T>& particles,
                                const std::vector<Interaction>& interactions, BasicSimulationState<T> start,
                                const BasicFrameSink<T>& sink, SimulateSummary& summary);

extern template std::string why_not_lagrangian(const SimulateOptions&, const BasicParticles<float>&);
extern template std::string why_not_lagrangian(const SimulateOptions&, const BasicParticles<double>&);
extern template BasicSimulateResult<float> simulate(const SimulateOptions&, const BasicParticles<float>&,
                                                    const std::vector<Interaction>&, BasicSimulationState<float>,
                                                    const BasicFrameSink<float>&);
extern template BasicSimulateResult<double> simulate(const SimulateOptions&, const BasicParticles<double>&,
                                                     const std::vector<Interaction>&, BasicSimulationState<double>,
                                                     const BasicFrameSink<double>&);

extern template BasicSimulateResult<float> simulate(const SimulateOptions&, const BasicParticles<float>&,
                                                    const std::vector<Interaction>&, BasicSimulationState<float>,
                                                    const BasicFrameSink<float>&, SimulateSummary&);
extern template BasicSimulateResult<double> simulate(const SimulateOptions&, const BasicParticles<double>&,
                                                     const std::vector<Interaction>&, BasicSimulationState<double>,
                                                     const BasicFrameSink<double>&, SimulateSummary&);

}  // namespace pliant

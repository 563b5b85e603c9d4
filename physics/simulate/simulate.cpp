#include "physics/simulate/simulate.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>

#include "gaussians/base/error.h"
#include "physics/body/surface_elements.h"
#include "physics/laws/law.h"
#include "physics/laws/material.h"
#include "physics/simulate/interaction_warnings.h"
#include "physics/simulate/rest_shape.h"
#include "physics/simulate/settle.h"
#include "physics/simulate/simulator.h"

namespace pliant {
namespace {

template <class T>
void validate(const SimulateOptions& options, const BasicParticles<T>& particles,
              const BasicSimulationState<T>& start) {
  const auto require = [](bool good, const char* field, double value, const char* remedy) {
    if (!good) throw usage_error("simulate", field, "is " + std::to_string(value), remedy);
  };
  require(options.fps > 0 && std::isfinite(options.fps), "fps", options.fps, "give a positive frame rate");
  require(options.duration >= 0 && std::isfinite(options.duration), "duration", options.duration, "give seconds");
  require(options.courant > 0 && options.courant <= options.courant_cap, "courant", options.courant,
          "give a positive number below courant_cap");
  require(options.courant_cap <= 1, "courant_cap", options.courant_cap, "the scheme is unstable above 1");
  require(options.substeps >= 0 && options.substeps <= kMaxSubstepsOfFrame, "substeps", options.substeps,
          "give 0 to let the time step be chosen");
  require(options.damping_time >= 0, "damping_time", options.damping_time, "give seconds, 0 = none");
  require(options.viscosity_time >= 0, "viscosity_time", options.viscosity_time, "give seconds, 0 = none");
  require(options.flip_time >= 0, "flip_time", options.flip_time, "give seconds, 0 = APIC");
  require(options.sleep_speed >= 0, "sleep_speed", options.sleep_speed, "give meters per second, 0 = off");
  require(options.settle_time >= 0, "settle_time", options.settle_time, "give seconds, 0 = none");
  require(options.max_retries >= 0, "max_retries", options.max_retries, "give a number of halvings");
  require(options.gravity.allFinite(), "gravity", options.gravity.norm(), "give three finite numbers");

  if (const std::string why = why_not_lagrangian(options, particles);
      options.grid == GridKind::kLagrangian && !why.empty())
    throw usage_error("simulate", "grid", "cannot be Lagrangian: " + why, "use the Eulerian grid");

  const size_t n = particles.size();
  require(n > 0, "particles", 0, "seed the object first; it has no driving particle");
  CHECK(particles.volume.size() == n && particles.mass.size() == n && particles.young.size() == n &&
        particles.poisson.size() == n);
  for (size_t i = 0; i < n; ++i) {
    require(particles.volume[i] > 0 && std::isfinite(particles.volume[i]), "volume", particles.volume[i],
            "every particle needs a positive volume");
    validate_material("particle " + std::to_string(i), particles.young[i], particles.poisson[i],
                      particles.mass[i] / particles.volume[i]);
    validate_poisson("particle " + std::to_string(i), particles.material(i).law, particles.poisson[i]);
    require(particles.position[i].allFinite(), "position", particles.position[i].norm(), "positions must be finite");
  }
  CHECK_MSG(start.x.size() == n && start.v.size() == n && start.C.size() == n && start.F.size() == n,
            "state and particles differ in number");
  for (size_t i = 0; i < n; ++i)
    require(start.x[i].allFinite() && start.v[i].allFinite() && start.C[i].allFinite() && start.F[i].allFinite(),
            "state", static_cast<double>(i), "this particle's state is not finite; start from another frame");
}

template <class T>
double largest_displacement(const BasicParticles<T>& particles, const BasicSimulationState<T>& state) {
  double largest = 0;
  for (size_t i = 0; i < state.size(); ++i)
    largest = std::max(largest, static_cast<double>((state.x[i] - particles.position[i]).norm()));
  return largest;
}

/// Sentence about parts that the grid is too coarse for, empty if there are next to none.
template <class T>
std::string describe_thin_parts(const BasicParticles<T>& particles, double dx, SimulateSummary& summary) {
  constexpr double kWorthSaying = 0.01;
  const std::vector<uint8_t> thin = thin_parts(particles, dx);
  double count = 0;
  for (size_t i = 0; i < thin.size(); ++i)
    if (thin[i]) {
      ++count;
      summary.thin_bounds.add(particles.position[i].template cast<float>());
    }
  summary.thin_share = count / static_cast<double>(thin.size());
  if (summary.thin_share < kWorthSaying) return "";
  const auto text = [](const Vec3f& x) {
    std::string words = "(";
    for (int a = 0; a < 3; ++a) words += std::to_string(x[a]) + (a < 2 ? ", " : ")");
    return words;
  };
  return std::to_string(std::lround(100 * summary.thin_share)) +
         " % of the particles are in parts thinner than 3 cells of " + std::to_string(dx) + " m, between " +
         text(summary.thin_bounds.low) + " and " + text(summary.thin_bounds.high) +
         " m; their bending stiffness is inaccurate, more driving particles make the cells smaller";
}

/// Sentence about material so nearly incompressible that the grid locks, empty if there is none.
template <class T>
std::string describe_locking(const BasicParticles<T>& particles) {
  double highest = 0;
  for (size_t i = 0; i < particles.size(); ++i)
    if (particles.material(i).law != Law::kFluid)
      highest = std::max(highest, static_cast<double>(particles.poisson[i]));
  if (!(highest > kLockingPoisson + 1e-6)) return "";
  char line[256];
  std::snprintf(line, sizeof line,
                "Poisson's ratio %.4g causes volumetric locking: the body is too stiff, by 7 %% at 0.49 and 26 %% at "
                "0.499; use 0.47, whose bending stiffness is almost the same",
                highest);
  return line;
}

/// Where elastic material is stretched beyond the range for which anyone has measured its law.
template <class T>
void note_stretch(const BasicParticles<T>& particles, const BasicSimulationState<T>& state, SimulateSummary& summary) {
  for (size_t i = 0; i < state.size(); ++i) {
    // No stretch is longer than all three together.
    const T bound = state.F[i].squaredNorm();
    if (!is_elastic(particles.material(i).law) || bound <= kFarStretch * kFarStretch ||
        bound <= summary.max_stretch * summary.max_stretch)
      continue;
    Eigen::SelfAdjointEigenSolver<Mat3d> eigen;
    const Mat3d F = state.F[i].template cast<double>();
    eigen.computeDirect(F.transpose() * F, Eigen::EigenvaluesOnly);
    const double stretch = std::sqrt(eigen.eigenvalues()[2]);
    if (stretch <= kFarStretch || stretch <= summary.max_stretch) continue;
    summary.max_stretch = stretch;
    summary.max_stretch_frame = state.frame;
    summary.max_stretch_place = particles.position[i].template cast<double>();
  }
}

void warn_of_stretch(SimulateSummary& summary) {
  if (summary.max_stretch == 0) return;
  const Vec3d& x = summary.max_stretch_place;
  char line[256];
  std::snprintf(line, sizeof line,
                "the material at (%.3g, %.3g, %.3g) m is stretched to %.3g times its length in frame %d, beyond the "
                "range in which its law is valid; pull less, or raise Young's modulus",
                x.x(), x.y(), x.z(), summary.max_stretch, summary.max_stretch_frame);
  summary.warnings.push_back(line);
}

/// Adds what `given` differs by from the captured shape at rest: its displacement, motion and deformation.
template <class T>
void superpose(const BasicParticles<T>& particles, const BasicSimulationState<T>& given,
               BasicSimulationState<T>& state) {
  for (size_t i = 0; i < state.size(); ++i) {
    state.x[i] += given.x[i] - particles.position[i];
    state.v[i] = given.v[i];
    state.C[i] = given.C[i];
    state.F[i] = (given.F[i] * state.F[i]).eval();
  }
  for (size_t i = 0; i < std::min(state.memory.size(), given.memory.size()); ++i) {
    LawMemory<T>& memory = state.memory[i];
    memory.F_total = (given.memory[i].F_total * memory.F_total).eval();
    memory.F_viscous = (given.memory[i].F_viscous * memory.F_viscous).eval();
    memory.history += given.memory[i].history;
  }
  state.quiet_time = given.quiet_time;
}

}  // namespace

template <class T>
BasicSimulateResult<T> simulate(const SimulateOptions& options, const BasicParticles<T>& particles,
                                const std::vector<Interaction>& interactions, BasicSimulationState<T> start,
                                const BasicFrameSink<T>& sink) {
  SimulateSummary summary;
  return simulate(options, particles, interactions, std::move(start), sink, summary);
}

template <class T>
BasicSimulateResult<T> simulate(const SimulateOptions& options, const BasicParticles<T>& particles,
                                const std::vector<Interaction>& interactions, BasicSimulationState<T> start,
                                const BasicFrameSink<T>& sink, SimulateSummary& summary) {
  const auto begin = std::chrono::steady_clock::now();
  validate(options, particles, start);
  BasicSimulateResult<T> result;
  result.state = std::move(start);
  summary.mass = particles.total_mass();
  summary.cell_size = options.cell_size > 0 ? options.cell_size : static_cast<double>(particles.cell_size);
  if (!(summary.cell_size > 0))
    throw usage_error("simulate", "cell_size", "is " + std::to_string(summary.cell_size), "give meters");

  Simulator<T> simulator(options, particles, interactions, summary);
  const int frames = static_cast<int>(std::lround(options.fps * options.duration));
  const double seconds = frames / options.fps;
  const bool told = !summary.warnings.empty();
  if (!told) summary.warnings = simulator.schedule().warnings();
  if (!told && frames > 0) {
    warn_of_idle(simulator.schedule(), seconds, summary);
    warn_of_thin_obstacles(simulator.schedule(), seconds, summary);
  }
  const bool viscous = options.viscosity_time > 0 ||
                       std::any_of(particles.materials.begin(), particles.materials.end(), [](const Material& m) {
                         return m.viscosity_time > 0 || (m.law == Law::kFluid && m.dynamic_viscosity > 0);
                       });
  if (options.flip_time > 0 && viscous && !told)
    summary.warnings.push_back(
        "with flip_time, viscosity damps less than specified, because particles keep velocity gradients that the grid "
        "cannot represent; damping_time is exact");
  const bool pinned = simulator.schedule().pinned(0);
  const bool cancelled = simulator.schedule().cancels_gravity(0);
  summary.gravity_cancelled = cancelled && options.gravity.norm() > 0;
  const auto deliver = [&] {
    summary.max_displacement = std::max(summary.max_displacement, largest_displacement(particles, result.state));
    note_stretch(particles, result.state, summary);
    result.stopped = sink && !sink(result.state);
  };
  for (const std::string& warning :
       {describe_thin_parts(particles, summary.cell_size, summary), describe_locking(particles)})
    if (!warning.empty() && !told) summary.warnings.push_back(warning);
  if (result.state.frame == 0) {
    if (pinned && options.rest_shape == RestShapeMode::kSolve) {
      RestShapeOptions solve;
      solve.simulate = options;
      RestShape<T> shape = solve_rest_shape(solve, particles, interactions);
      superpose(particles, result.state, shape.state);
      result.state = std::move(shape.state);
      summary.settle_seconds = shape.summary.seconds;
      summary.rest_shape_residual = shape.summary.residual;
      summary.rest_shape_sag = shape.summary.sag;
      summary.rest_shape_iterations = shape.summary.iterations;
      if (!shape.summary.converged)
        summary.warnings.push_back("the unloaded shape was not found: at rest the body is " +
                                   std::to_string(shape.summary.residual) + " m off the captured shape");
    } else if (const SimulateOptions settling = settling_options(options, particles, interactions);
               options.settle_time > 0 && !cancelled && !settling.gravity.isZero()) {
      SimulateSummary ignored;
      Simulator<T> resting(settling, particles, resting_interactions(interactions), ignored);
      const SettleSummary settled =
          settle(resting, particles, options.settle_time, rest_speed(settling, particles), result.state);
      summary.settle_displacement = settled.displacement;
      summary.settle_seconds = settled.seconds;
      if (!settled.at_rest)
        summary.warnings.push_back("the body still moves at " + std::to_string(settled.speed) + " m/s after " +
                                   std::to_string(settled.seconds) + " s of settling");
    }
    deliver();
  }
  while (result.state.frame < frames && !result.stopped) {
    simulator.advance(result.state);
    deliver();
  }
  warn_of_misses(simulator.schedule(), seconds, summary);
  warn_of_weak_grabs(simulator.schedule(), options.fps, summary);
  warn_of_leaving(simulator.schedule(), result.state, summary);
  warn_of_stretch(summary);
  if (summary.strays > 0)
    summary.warnings.push_back("particles left the grid " + std::to_string(summary.strays) +
                               " times, farther than 100,000 cells from the body, and were put back at its border");
  summary.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  result.summary = summary;
  return result;
}

template <class T>
std::string why_not_lagrangian(const SimulateOptions& options, const BasicParticles<T>& particles) {
  for (const Material& material : particles.materials)
    if (!is_elastic(material.law)) return std::string("the law ") + law_name(material.law) + " has no reference shape";
  if (options.rest_shape == RestShapeMode::kSolve) return "the body starts with pre-stress";
  if (options.sleep_speed > 0) return "parts may sleep, whose nodes would move on";
  if (options.flip_time > 0) return "flip_time blends what such a grid keeps anyway";
  if (options.pic || options.strain_rate_damping > 0) return "transfers damp the affine velocity";
  return "";
}

template std::string why_not_lagrangian(const SimulateOptions&, const BasicParticles<float>&);
template std::string why_not_lagrangian(const SimulateOptions&, const BasicParticles<double>&);
template BasicSimulateResult<float> simulate(const SimulateOptions&, const BasicParticles<float>&,
                                             const std::vector<Interaction>&, BasicSimulationState<float>,
                                             const BasicFrameSink<float>&);
template BasicSimulateResult<double> simulate(const SimulateOptions&, const BasicParticles<double>&,
                                              const std::vector<Interaction>&, BasicSimulationState<double>,
                                              const BasicFrameSink<double>&);

template BasicSimulateResult<float> simulate(const SimulateOptions&, const BasicParticles<float>&,
                                             const std::vector<Interaction>&, BasicSimulationState<float>,
                                             const BasicFrameSink<float>&, SimulateSummary&);
template BasicSimulateResult<double> simulate(const SimulateOptions&, const BasicParticles<double>&,
                                              const std::vector<Interaction>&, BasicSimulationState<double>,
                                              const BasicFrameSink<double>&, SimulateSummary&);

}  // namespace pliant

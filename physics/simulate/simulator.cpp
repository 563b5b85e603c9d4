#include "physics/simulate/simulator.h"

#include <algorithm>
#include <cmath>

#include "gaussians/base/error.h"
#include "physics/body/surface_elements.h"
#include "physics/laws/material.h"
#include "physics/simulate/weights.h"

namespace pliant {
namespace {

// Cells by which a Lagrangian body may move in a step: as chosen at the start of a frame, and before it is repeated.
constexpr double kJump = 1.0 / 3, kJumpCap = 0.8;
constexpr int kMostHalvings = 4;  // of the time step in one retry

/// Origin of the grid: a multiple of dx near the middle of the body, so that coordinates stay small.
template <class T>
Vec3d grid_origin(const BasicParticles<T>& particles, double dx) {
  Vec3d low = Vec3d::Constant(INFINITY), high = Vec3d::Constant(-INFINITY);
  for (const Vec3<T>& x : particles.position) {
    low = low.cwiseMin(x.template cast<double>());
    high = high.cwiseMax(x.template cast<double>());
  }
  return dx * (0.5 / dx * (low + high)).array().round().matrix();
}

template <class T>
BasicParticles<T> with_weights(BasicParticles<T> particles, const std::vector<Interaction>& interactions) {
  particles.mass = masses_with_weights(particles, interactions);
  return particles;
}

/// Halvings of the time step by which a frame with this Courant number (1 = stable) is repeated.
int halvings_of(double courant_number) {
  int halvings = 1;
  while (halvings < kMostHalvings && std::ldexp(1.0, halvings) < courant_number) ++halvings;
  return halvings;
}

/// Frame `frame` is unstable with `tried` substeps (0 = none were tried), and needs more than `allowed` of them where
/// that is not 0.
Error unstable(int frame, int tried, int allowed) {
  std::string problem = "frame " + std::to_string(frame);
  if (tried > 0) problem += " stays unstable with " + std::to_string(tried) + " substeps";
  if (tried > 0 && allowed > 0) problem += " and";
  if (allowed > 0) problem += " needs more than the maximum of " + std::to_string(allowed) + " substeps";
  return numerical_error("simulate", problem,
                         tried > 0 ? "lower the forces, raise Young's modulus, or use fewer driving particles"
                                   : "lower the speeds or Young's modulus, or use fewer driving particles");
}

}  // namespace

template <class T>
FastestWave fastest_wave(const SimulateOptions& options, const BasicParticles<T>& particles, double dx) {
  FastestWave fastest;
  for (size_t i = 0; i < particles.size(); ++i) {
    const double density = static_cast<double>(particles.mass[i]) / particles.volume[i];
    const double c = sound_speed(particles.material(i), particles.young[i], particles.poisson[i], density);
    const Lame<double> law = lame<double>(particles.young[i], particles.poisson[i]);
    const Viscosity<double> viscous = viscosity(LawPoint<double>{&particles.material(i), law.mu, law.lambda});
    // Explicit viscosity lowers the stable step of the shortest wave, whose damping ratio is xi.
    const double modulus = density * c * c;
    const double time = options.viscosity_time * (law.lambda + 2 * law.mu) + viscous.bulk + 2 * viscous.shear;
    const double xi = time / modulus * c / dx;
    const double speed = c * (std::sqrt(1 + xi * xi) + xi);
    if (speed > fastest.speed) fastest = {speed, i};
  }
  return fastest;
}

template <class T>
double substeps_at_rest(const SimulateOptions& options, const BasicParticles<T>& particles) {
  if (options.substeps > 0) return options.substeps;
  const double dx = options.cell_size > 0 ? options.cell_size : static_cast<double>(particles.cell_size);
  const double wave = fastest_wave(options, particles, dx).speed / (options.courant * dx);
  return std::max(1.0, std::ceil(wave / options.fps));
}

template <class T>
Simulator<T>::Simulator(const SimulateOptions& options, const BasicParticles<T>& particles,
                        const std::vector<Interaction>& interactions, SimulateSummary& summary)
    : options_(options),
      particles_(with_weights(particles, interactions)),
      dx_(options.cell_size > 0 ? options.cell_size : static_cast<double>(particles.cell_size)),
      lagrangian_(is_lagrangian(options, particles)),
      schedule_(options, particles, interactions),
      solver_(particles_, dx_, grid_origin(particles, dx_),
              {.flip_time = options.flip_time, .lagrangian = lagrangian_, .sleep_speed = options.sleep_speed}),
      summary_(summary) {
  solver_.set_load_bits(schedule_.bits());
  if (schedule_.has_wind()) solver_.set_exposure(surface_elements(particles, dx_));
  sound_speed_ = fastest_wave(options, particles_, dx_).speed;
  Vec3<T> low = particles.position[0], high = low;
  for (const Vec3<T>& x : particles.position) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  diagonal_ = std::max((high - low).template cast<double>().norm(), 8 * dx_);
}

template <class T>
double Simulator<T>::fastest(const BasicSimulationState<T>& state) const {
  double speed = 0;
  for (const Vec3<T>& v : state.v) speed = std::max(speed, static_cast<double>(v.norm()));
  return speed;
}

/// How many cells waves and matter run through in a step, as a share of what is stable: on an Eulerian grid both
/// together, on a Lagrangian one waves alone, while what moves must not jump over what it may touch.
template <class T>
double Simulator<T>::courant_number(double speed, double dt, double limit, double jump) const {
  if (!lagrangian_) return (sound_speed_ + speed) * dt / (limit * dx_);
  return std::max(sound_speed_ / (limit * dx_), speed / (jump * dx_)) * dt;
}

template <class T>
int Simulator<T>::substeps_of(const BasicSimulationState<T>& state) const {
  if (options_.substeps > 0) return options_.substeps;
  const double speed = std::max(fastest(state), schedule_.collider_speed(state.frame / options_.fps, 1 / options_.fps));
  const double wanted = courant_number(speed, 1 / options_.fps, options_.courant, kJump);
  return wanted < kMaxSubstepsOfFrame ? std::max(1, static_cast<int>(std::ceil(wanted))) : kMaxSubstepsOfFrame + 1;
}

template <class T>
void Simulator<T>::advance(BasicSimulationState<T>& state, const std::function<void()>& glance) {
  int substeps = substeps_of(state), tried = 0;
  for (int halvings = 0;;) {
    if (halvings > options_.max_retries || substeps > options_.max_substeps)
      throw unstable(state.frame + 1, tried, substeps > options_.max_substeps ? options_.max_substeps : 0);
    begin_frame(state);
    tried = substeps;
    if (run(state, substeps, 0, substeps, nullptr, glance)) break;
    // The smallest step that is allowed is tried in any case.
    const int left = options_.max_retries - halvings, more = std::min(halvings_of(courant_number_), std::max(left, 1));
    halvings += more;
    substeps <<= more;
    ++summary_.retries;
  }
  solver_.store(state);
  ++state.frame;
  state.time = state.frame / options_.fps;
  state.substeps += substeps;

  const double dt = time_step(substeps);
  summary_.min_dt = summary_.frames ? std::min(summary_.min_dt, dt) : dt;
  summary_.max_dt = std::max(summary_.max_dt, dt);
  summary_.substeps_of_frame.push_back(substeps);
  summary_.impulse_of_frame.push_back(impulse_);
  summary_.particle_substeps += static_cast<int64_t>(substeps) * static_cast<int64_t>(state.size());
  summary_.strays += solver_.strays();
  ++summary_.frames;
}

template <class T>
void Simulator<T>::begin_frame(const BasicSimulationState<T>& state) {
  const Vec3d anywhere = Vec3d::Constant(std::numeric_limits<double>::infinity());
  solver_.load(state, -anywhere, anywhere);
  if (options_.sleep_speed > 0) see_border(state.frame);
  impulse_.assign(schedule_.size(), Vec3d::Zero());
}

/// Shows the solver what acts just before a frame begins.  Steps of both frames are compared with that: what changes at
/// the border wakes what sleeps, whether the run goes on or is resumed there.
template <class T>
void Simulator<T>::see_border(int frame) {
  const double moment = 1e-6 / options_.fps;
  schedule_.at(frame / options_.fps - moment, moment, solver_, loads_);
  solver_.wake_on_change(loads_);
}

template <class T>
bool Simulator<T>::run(const BasicSimulationState<T>& state, int substeps, int first, int last, StepTape<T>* tape,
                       const std::function<void()>& glance) {
  const double start = state.frame / options_.fps, dt = time_step(substeps);
  const bool good = solver_.advance(
      last - first, static_cast<T>(dt), loads_,
      [&](int k) { schedule_.at(start + (first + k) * dt, dt, solver_, loads_); },
      [&] {
        // Supports meet velocities that are damped already; with v' = k (v + dt a + J / m), J is 1 / k of what they
        // change.
        const size_t supports = loads_.colliders.size() + loads_.pins.size();
        for (size_t l = 0; l < loads_.source.size(); ++l)
          impulse_[loads_.source[l]] += solver_.impulses()[l] / (l < supports ? double{loads_.velocity_scale} : 1.0);
        // The grid's gravity pulls at the weights as well.
        for (size_t k = 0; k < schedule_.size(); ++k)
          if (schedule_[k].type == InteractionType::kWeight)
            impulse_[k] += dt * schedule_[k].mass * loads_.gravity.template cast<double>();
        courant_number_ = courant_number(solver_.max_speed(), dt, options_.courant_cap, kJumpCap);
        if (!(courant_number_ <= 1)) return false;
        if (glance) glance();
        return true;
      },
      tape);
  if (good && last == substeps && options_.sleep_speed > 0) see_border(state.frame + 1);
  return good;
}

template FastestWave fastest_wave(const SimulateOptions&, const BasicParticles<float>&, double);
template FastestWave fastest_wave(const SimulateOptions&, const BasicParticles<double>&, double);
template double substeps_at_rest(const SimulateOptions&, const BasicParticles<float>&);
template double substeps_at_rest(const SimulateOptions&, const BasicParticles<double>&);
template class Simulator<float>;
template class Simulator<double>;

}  // namespace pliant

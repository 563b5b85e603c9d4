#pragma once

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <functional>
#include <vector>

#include "physics/mpm/mpm.h"
#include "physics/simulate/simulator.h"
#include "tests/physics/shapes.h"

namespace pliant::fixture {

struct Substance {
  Material material;
  double young = 1e5, poisson = 0.3, density = 1000;
  GridKind grid = GridKind::kAutomatic;  // of its roll-outs

  Lame<double> moduli() const { return lame(young, poisson); }
  double bulk() const {
    if (material.law == Law::kFluid && material.bulk_modulus > 0) return material.bulk_modulus;
    return moduli().lambda + 2 * moduli().mu / 3;
  }
};

using Bodies = BasicParticles<double>;
using BodyState = BasicSimulationState<double>;

template <class Inside>
Bodies body_of(const Substance& s, const Vec3d& size, double dx, Inside&& inside, double jitter = 0) {
  Bodies p = fill_shape<double>(size, dx, 2, jitter, s.young, s.poisson, s.density, inside);
  p.materials = {s.material};
  return p;
}
inline Bodies block_of(const Substance& s, const Vec3d& size, double dx, double jitter = 0) {
  return body_of(
      s, size, dx, [](const Vec3d&) { return true; }, jitter);
}

/// Plane that matter slides along, sticks to, or rests on with Coulomb friction 1.
inline Interaction wall(const Vec3d& point, const Vec3d& normal, ContactKind contact = ContactKind::kSlip) {
  Interaction it;
  it.type = InteractionType::kGround;
  it.contact = contact;
  it.friction = 1;
  it.region = Region::half_space(point, normal);
  return it;
}
/// Frictionless walls around the box [0, size] along `axis`.
inline void add_walls(std::vector<Interaction>& world, const Vec3d& size, int axis) {
  world.push_back(wall(Vec3d::Zero(), Vec3d::Unit(axis)));
  world.push_back(wall(size, -Vec3d::Unit(axis)));
}

inline SimulateOptions run_options(double fps, double duration, const Vec3d& gravity = Vec3d(0, 0, -9.81)) {
  SimulateOptions options;
  options.fps = fps;
  options.duration = duration;
  options.gravity = gravity;
  return options;
}

/// Speed of a compressive pulse along a bar between frictionless walls, where strain is uniaxial [m/s]: the times at
/// which the centroid of the velocity passes two stations 16 cells apart.
inline double p_wave_speed(const Substance& s, double expected, int cells_wide = 4) {
  const double dx = 0.01, amplitude = 2e-4, width = 5 * dx, first = 15 * dx, stations[2] = {26 * dx, 42 * dx};
  const Vec3d size(58 * dx, cells_wide * dx, cells_wide * dx);
  const Bodies p = block_of(s, size, dx);
  BodyState state = initial_state(p);
  for (size_t i = 0; i < p.size(); ++i) {
    const double d = (p.position[i].x() - first) / width, strain = amplitude * std::exp(-d * d);
    state.v[i].x() = expected * strain;
    state.F[i](0, 0) -= strain;
    if (!state.memory.empty()) state.memory[i].F_viscous = state.F[i];
  }
  std::vector<Interaction> world;
  add_walls(world, size, 1);
  add_walls(world, size, 2);
  const double step = 0.2 * dx / expected;  // a fifth of a cell
  double weight[2] = {}, moment[2] = {};
  SimulateOptions options = run_options(1 / step, 43 * dx / expected, Vec3d::Zero());
  options.grid = s.grid;
  simulate<double>(options, p, world, state, [&](const BodyState& now) {
    for (int k = 0; k < 2; ++k) {
      double velocity = 0;
      for (size_t i = 0; i < p.size(); ++i)
        if (std::abs(p.position[i].x() - stations[k]) < 0.5 * dx) velocity += now.v[i].x();
      velocity = std::max(velocity, 0.0) * (std::abs(now.time * expected - (stations[k] - first)) < 10 * dx);
      weight[k] += velocity * velocity;
      moment[k] += velocity * velocity * now.time;
    }
    return true;
  });
  return (stations[1] - stations[0]) / (moment[1] / weight[1] - moment[0] / weight[0]);
}

/// Pressure across the middle plane of a cube scaled by (1 - strain) [Pa]: momentum that one half gains in one step.
inline double compressed_pressure(const Substance& s, double strain) {
  const double dx = 0.01, side = 8 * dx, dt = 1e-7;
  const Bodies p = block_of(s, Vec3d::Constant(side), dx);
  BodyState state = initial_state(p);
  for (size_t i = 0; i < p.size(); ++i) {
    state.x[i] *= 1 - strain;
    state.F[i] *= 1 - strain;
    if (!state.memory.empty()) state.memory[i].F_viscous = state.F[i];
  }
  Mpm<double> solver(p, dx, Vec3d::Zero());
  solver.load(state, Vec3d::Constant(-1), Vec3d::Constant(1));
  const StepLoads<double> none;
  solver.particles_to_grid(dt, none);
  solver.update_grid(dt, none);
  solver.grid_to_particles(dt);
  solver.store(state);
  double momentum = 0;
  for (size_t i = 0; i < p.size(); ++i)
    if (p.position[i].x() > 0.5 * side) momentum += p.mass[i] * state.v[i].x();
  return momentum / dt / std::pow(side * (1 - strain), 2);
}

/// K = -V dp / dV at rest [Pa], from two compressions so that what is quadratic in the strain cancels.
inline double measured_bulk_modulus(const Substance& s) {
  const double one = 1e-3, two = 1 - std::pow(1 - one, 2);
  return (4 * compressed_pressure(s, one) - compressed_pressure(s, two)) / (-6 * std::log(1 - one));
}

/// A layer without ends: a core of `kPeriod` cells along x between copies of itself, which take over the core's state
/// after every few steps, before anything from their outer ends can have come through them.
class EndlessLayer {
 public:
  static constexpr int kPeriod = 4, kCopies = 3;  // on either side

  EndlessLayer(const Substance& s, double dx, double width, double depth)
      : size_((2 * kCopies + 1) * kPeriod * dx, width, depth),
        period_(kPeriod * dx),
        particles(block_of(s, size_, dx)) {
    // Particles were filled x first: the layer of one period is one run of equal length.
    const size_t run = particles.size() / (2 * kCopies + 1);
    for (size_t i = 0; i < particles.size(); ++i) core_.push_back(kCopies * run + i % run);
    state = initial_state(particles);
  }

  /// Frames of eight cell transits of the fastest wave at most; visit(state) sees each and returns false to stop.
  void run(const SimulateOptions& base, const std::vector<Interaction>& world, double duration,
           const std::function<bool(const BodyState&)>& visit) {
    SimulateOptions options = base;
    const double c = sound_speed(particles.materials[0], particles.young[0], particles.poisson[0],
                                 particles.mass[0] / particles.volume[0]);
    options.fps = std::ceil(c / (6 * static_cast<double>(particles.cell_size)));
    SimulateSummary summary;
    Simulator<double> simulator(options, particles, world, summary);
    while (state.time < duration && visit(state)) {
      simulator.advance(state);
      for (size_t i = 0; i < core_.size(); ++i) {
        const size_t j = core_[i];
        if (i == j) continue;
        const double shift = std::round((particles.position[i].x() - particles.position[j].x()) / period_) * period_;
        state.x[i] = state.x[j] + Vec3d(shift, 0, 0);
        state.v[i] = state.v[j];
        state.C[i] = state.C[j];
        state.F[i] = state.F[j];
        if (!state.memory.empty()) state.memory[i] = state.memory[j];
      }
    }
  }

 private:
  Vec3d size_;
  double period_;
  std::vector<size_t> core_;  // particle that each copies

 public:
  Bodies particles;
  BodyState state;
};

/// How far the surface of an endless layer of sand, `cells` deep on a sticky bed, runs down in `duration` s when
/// gravity is turned by `slope` degrees, in cells.  It starts under the pressure and shear of its own weight.
inline double sand_slope_run(double friction_angle, double slope, int cells, double duration) {
  const double dx = 0.1, depth = cells * dx, g = 9.81, angle = slope * M_PI / 180;
  Substance sand;
  sand.material.law = Law::kSand;
  sand.material.friction_angle = friction_angle;
  sand.young = 1e7;
  sand.poisson = 0.3;
  sand.density = 1600;
  EndlessLayer layer(sand, dx, 2 * dx, depth);
  for (size_t i = 0; i < layer.state.size(); ++i) {
    const double pressure = sand.density * g * std::cos(angle) * (depth - layer.state.x[i].z());
    layer.state.F[i] *= 1 - pressure / (3 * sand.bulk());
    layer.state.F[i](0, 2) = pressure * std::tan(angle) / sand.moduli().mu;
  }
  std::vector<Interaction> world = {wall(Vec3d::Zero(), Vec3d::UnitZ(), ContactKind::kSticky)};
  add_walls(world, Vec3d(1, 2 * dx, 1), 1);
  double run = 0;
  layer.run(run_options(1, 1, g * Vec3d(std::sin(angle), 0, -std::cos(angle))), world, duration,
            [&](const BodyState& now) {
              double sum = 0;
              int count = 0;
              for (size_t i = 0; i < now.size(); ++i)
                if (layer.particles.position[i].z() > depth - dx) {
                  sum += now.x[i].x() - layer.particles.position[i].x();
                  ++count;
                }
              run = sum / count / dx;
              return true;
            });
  return run;
}
inline double critical_slope(double friction_angle) {
  const double s = std::sin(friction_angle * M_PI / 180);
  return std::atan(2 * std::sqrt(3.0) * s / (3 - s)) * 180 / M_PI;
}

/// Time in which a shear flow v_x = cos(pi z / depth) of an endless layer of fluid decays to 1/e [s].
inline double shear_flow_decay_time(const Substance& fluid, double dx, int cells) {
  const double depth = cells * dx, c = std::sqrt(fluid.bulk() / fluid.density);
  const double expected = fluid.density * depth * depth / (M_PI * M_PI * fluid.material.dynamic_viscosity);
  EndlessLayer layer(fluid, dx, 2 * dx, depth);
  for (size_t i = 0; i < layer.state.size(); ++i) {
    const double phase = M_PI * layer.state.x[i].z() / depth;
    layer.state.v[i].x() = 1e-3 * c * std::cos(phase);
    layer.state.C[i](0, 2) = -1e-3 * c * M_PI / depth * std::sin(phase);
  }
  std::vector<Interaction> world;
  add_walls(world, Vec3d(1, 2 * dx, depth), 1);
  add_walls(world, Vec3d(1, 2 * dx, depth), 2);
  double first = 0, last = 0, start = 0, end = 0;
  layer.run(run_options(1, 1, Vec3d::Zero()), world, 1.2 * expected, [&](const BodyState& now) {
    double sum = 0;
    for (size_t i = 0; i < now.size(); ++i)
      sum += now.v[i].x() * std::cos(M_PI * layer.particles.position[i].z() / depth);
    if (now.time < 0.2 * expected) {
      first = sum;
      start = now.time;
    }
    last = sum;
    end = now.time;
    return true;
  });
  return (end - start) / std::log(first / last);
}

/// Holds an endless layer between two plates at shear `strain` for `duration` s.  Returns the time in which the mean of
/// excess(F, memory) over its particles decays to 1/e [s].
inline double decay_time_in_shear(const Substance& s, double strain, double duration,
                                  const std::function<double(const Mat3d&, const LawMemory<double>&)>& excess) {
  const double dx = 0.01, depth = 6 * dx;
  EndlessLayer layer(s, dx, 2 * dx, depth);
  for (size_t i = 0; i < layer.state.size(); ++i) {
    layer.state.x[i].x() += strain * layer.state.x[i].z();
    layer.state.F[i](0, 2) = strain;
    layer.state.memory[i].F_viscous = layer.state.memory[i].F_total = layer.state.F[i];
  }
  std::vector<Interaction> world = {wall(Vec3d::Zero(), Vec3d::UnitZ(), ContactKind::kSticky),
                                    wall(Vec3d(0, 0, depth), -Vec3d::UnitZ(), ContactKind::kSticky)};
  add_walls(world, Vec3d(1, 2 * dx, 1), 1);
  double first = 0, last = 0, end = 0;
  layer.run(run_options(1, 1, Vec3d::Zero()), world, duration, [&](const BodyState& now) {
    last = 0;
    end = now.time;
    for (size_t i = 0; i < now.size(); ++i) last += excess(now.F[i], now.memory[i]);
    if (first == 0) first = last;
    return true;
  });
  return end / std::log(first / last);
}

inline double deviator_norm(const Mat3d& tau) { return (tau - tau.trace() / 3 * Mat3d::Identity()).norm(); }

/// Time in which the stress of the relaxing branch decays to 1/e in a layer held in shear [s].
inline double branch_relaxation_time(const Substance& s) {
  const LawPoint<double> point{&s.material, s.moduli().mu, s.moduli().lambda};
  const double expected = s.material.branch_viscosity / (2 * s.material.branch_shear);
  return decay_time_in_shear(s, 0.05, expected, [&](const Mat3d& F, const LawMemory<double>& memory) {
    return deviator_norm(kirchhoff_stress(point, F, memory) - kirchhoff_stress(point, F, {}));
  });
}

/// Time in which what exceeds the yield stress decays to 1/e in a layer of foam held in shear [s].
inline double foam_relaxation_time(const Substance& s) {
  const LawPoint<double> point{&s.material, s.moduli().mu, s.moduli().lambda};
  const double expected = s.material.plastic_viscosity / (2 * s.moduli().mu);
  return decay_time_in_shear(s, 0.1, expected, [&](const Mat3d& F, const LawMemory<double>& memory) {
    return deviator_norm(kirchhoff_stress(point, F, memory)) - std::sqrt(2.0 / 3) * s.material.yield_stress;
  });
}

/// Spread [m] along an axis that holds all but `tail` of the particles at either end.
inline double extent(const BodyState& s, int axis, double tail = 0.005) {
  std::vector<double> x;
  for (const Vec3d& at : s.x) x.push_back(at[axis]);
  std::sort(x.begin(), x.end());
  const size_t cut = static_cast<size_t>(tail * static_cast<double>(x.size()));
  return x[x.size() - 1 - cut] - x[cut];
}

struct Shape {
  double width, height;  ///< m, largest horizontal extent and vertical extent
};
inline Shape shape_of(const BodyState& s) { return {std::max(extent(s, 0), extent(s, 1)), extent(s, 2)}; }
/// Shape before and after `duration` s under gravity on rough ground.
inline std::pair<Shape, Shape> rest_on_ground(const Bodies& p, double duration) {
  const BodyState start = initial_state(p);
  const auto result = simulate<double>(run_options(20, duration), p,
                                       {wall(Vec3d::Zero(), Vec3d::UnitZ(), ContactKind::kSeparating)}, start);
  return {shape_of(start), shape_of(result.state)};
}

/// Ball on the ground, the diameter `cells` cells.
inline Bodies ball_of(const Substance& s, double diameter, int cells) {
  const Vec3d centre = Vec3d::Constant(0.5 * diameter);
  return body_of(s, Vec3d::Constant(diameter), diameter / cells,
                 [&](const Vec3d& x) { return (x - centre).norm() < 0.5 * diameter; });
}

struct Dent {
  double loaded, left;  ///< m, depth under the load and after unloading
};
/// Presses the middle of a block's top with `pressure` Pa for `duration` s and lets go for as long again.
inline Dent dent(const Substance& s, double pressure, double duration, double dx) {
  const double height = 6 * dx, radius = 2 * dx;
  const Vec3d size(10 * dx, 10 * dx, height), middle(5 * dx, 5 * dx, height);
  const Bodies p = block_of(s, size, dx);
  Interaction press;
  press.region = Region::sphere(middle, radius);
  press.duration = duration;
  press.vector = Vec3d(0, 0, -pressure * M_PI * radius * radius);
  SimulateOptions options = run_options(20 / duration, 2 * duration);
  options.damping_time = duration / 10;
  options.grid = s.grid;
  Dent result{};
  simulate<double>(options, p, {wall(Vec3d::Zero(), Vec3d::UnitZ(), ContactKind::kSeparating), press}, initial_state(p),
                   [&](const BodyState& now) {
                     double pressed = 0, around = 0;
                     int inside = 0, outside = 0;
                     for (size_t i = 0; i < p.size(); ++i) {
                       if (p.position[i].z() < height - dx) continue;
                       const double sink = p.position[i].z() - now.x[i].z();
                       const double r = (p.position[i] - middle).head<2>().norm();
                       if (r < radius) {
                         pressed += sink;
                         ++inside;
                       }
                       if (r > 4 * dx) {
                         around += sink;
                         ++outside;
                       }
                     }
                     const double depth = pressed / inside - around / outside;
                     if (now.time <= duration * 1.0001) result.loaded = depth;
                     result.left = depth;
                     return true;
                   });
  return result;
}

struct WaterColumn {
  double pressure_slope;  ///< of pressure over depth, relative to density times gravity
  double mean_pressure;   ///< of all particles, relative to that at half the depth
  double height_change;   ///< relative, of the mean height of the particles
};
/// Water in a box with frictionless walls, `cells` deep, after `duration` s under gravity, which acts suddenly or has
/// compressed it already; the pressure is a mean over the second half.
inline WaterColumn water_column(int cells, double duration, bool suddenly) {
  const double dx = 0.01, depth = cells * dx, g = 9.81;
  Substance water;
  water.material.law = Law::kFluid;
  water.material.bulk_modulus = 200 * water.density * g * depth;
  water.material.dynamic_viscosity = 0.01;
  const Vec3d size(6 * dx, 6 * dx, depth);
  const Bodies p = block_of(water, size, dx);
  std::vector<Interaction> world = {wall(Vec3d::Zero(), Vec3d::UnitZ())};
  add_walls(world, size, 0);
  add_walls(world, size, 1);
  BodyState start = initial_state(p);
  for (size_t i = 0; i < p.size() && !suddenly; ++i) {
    const double pressure = water.density * g * (depth - p.position[i].z()), gamma = water.material.pressure_exponent;
    start.F[i] *= std::pow(1 + gamma * pressure / water.bulk(), -1 / (3 * gamma));
  }
  double n = 0, z = 0, q = 0, zz = 0, zq = 0, height = 0, mean = 0, frames = 0;
  simulate<double>(run_options(100, duration), p, world, start, [&](const BodyState& now) {
    if (now.time < 0.5 * duration) return true;
    for (size_t i = 0; i < p.size(); ++i) {
      height += now.x[i].z() / static_cast<double>(p.size());
      const double J = now.F[i].determinant();
      const double pressure = -kirchhoff_stress({&p.materials[0], 0, 0}, now.F[i], {}).trace() / 3 / J;
      mean += pressure / static_cast<double>(p.size());
      if (std::abs(now.x[i].z() - 0.5 * depth) > 0.3 * depth) continue;  // away from bottom and surface
      n += 1;
      z += now.x[i].z();
      q += pressure;
      zz += now.x[i].z() * now.x[i].z();
      zq += now.x[i].z() * pressure;
    }
    frames += 1;
    return true;
  });
  const double slope = (zq - z * q / n) / (zz - z * z / n);
  return {-slope / (water.density * g), mean / frames / (0.5 * water.density * g * depth),
          height / frames / (0.5 * depth) - 1};
}

/// Largest rise of PE_n + (KE_n + KE_n+1) / 2 of a free, spinning, strained block above any earlier value, relative to
/// the first.  v_n belongs to the time half a step before F_n.
inline double energy_growth(const Substance& s, int cells, int steps, double courant) {
  const double dx = 0.01;
  const Bodies p = block_of(s, Vec3d::Constant(cells * dx), dx, 1.0);
  BodyState state = initial_state(p);
  const Vec3d centre = Vec3d::Constant(0.5 * cells * dx);
  const double c = sound_speed(s.material, s.young, s.poisson, s.density);
  Mat3d stretch = Mat3d::Identity(), rate = Mat3d::Zero();
  stretch.diagonal() = Vec3d(1.1, 0.95, 0.92);
  rate(0, 1) = 0.05 * c / (cells * dx);
  rate(1, 0) = -rate(0, 1);
  rate(2, 2) = -0.05 * c / (cells * dx);
  for (size_t i = 0; i < p.size(); ++i) {
    state.x[i] = centre + stretch * (state.x[i] - centre);
    state.v[i] = rate * (state.x[i] - centre);
    state.C[i] = rate;
    state.F[i] = stretch;
  }
  Mpm<double> solver(p, dx, Vec3d::Zero());
  solver.load(state, Vec3d::Constant(-10), Vec3d::Constant(10));
  const double dt = courant * dx / (c + 0.1 * c);
  const StepLoads<double> none;
  const auto kinetic = [&] {
    double sum = 0;
    for (size_t i = 0; i < p.size(); ++i)
      sum += 0.5 * p.mass[i] * (state.v[i].squaredNorm() + 0.25 * dx * dx * state.C[i].squaredNorm());
    return sum;
  };
  const auto potential = [&] {
    double sum = 0;
    for (size_t i = 0; i < p.size(); ++i)
      sum += p.volume[i] * energy_density({&s.material, s.moduli().mu, s.moduli().lambda}, state.F[i], {});
    return sum;
  };
  double before = kinetic(), stored = potential(), start = 0, least = INFINITY, most = 0;
  for (int k = 0; k <= steps; ++k) {
    solver.particles_to_grid(dt, none);
    solver.update_grid(dt, none);
    solver.grid_to_particles(dt);
    solver.store(state);
    const double after = kinetic(), energy = stored + 0.5 * (before + after);
    if (k == 0) start = energy;
    least = std::min(least, energy);
    most = std::max(most, (energy - least) / start);
    before = after;
    stored = potential();
  }
  return most;
}

}  // namespace pliant::fixture

#pragma once

#include <filesystem>
#include <functional>

#include "app/store/particles.h"
#include "app/store/trajectory.h"
#include "physics/simulate/energy.h"

namespace pliant::fixture {

/// 1/s at which the amplitude of a motion fell, by the balance of energy over the frames that `simulate` wrote into the
/// object's folder: of fixed corotated matter of this E [Pa] at places in scene units.
inline double decay_rate(const std::filesystem::path& object, const std::function<double(const Vec3f&)>& young,
                         double poisson = 0.3, double density = 1000) {
  const ParticleFile file = read_particles(object / "particles.h5");
  const TrajectoryFile motion = read_trajectory(object / "trajectory.h5");
  const float unit = static_cast<float>(motion.metres_per_unit);
  Particles p;
  p.position = file.driving_position;
  p.cell_size = 0;
  for (size_t i = 0; i < p.size(); ++i) {
    p.volume.push_back(file.driving_volume[i] * unit * unit * unit);
    p.mass.push_back(static_cast<float>(density) * p.volume[i]);
    p.young.push_back(static_cast<float>(young(p.position[i])));
    p.poisson.push_back(static_cast<float>(poisson));
  }
  double kinetic = 0, before = 0, first = 0, last = 0;
  for (size_t f = 0; f < motion.frames.size(); ++f) {
    SimulationState state = initial_state(p);
    state.v = motion.frames[f].velocity;
    state.F = motion.frames[f].F;
    const double now = kinetic_energy(p, state), all = now + elastic_energy(p, state);
    if (f > 0) kinetic += 0.5 * (before + now) / motion.fps;
    if (f == 0) first = all;
    before = now;
    last = all;
  }
  return (first - last) / (4 * kinetic);
}

}  // namespace pliant::fixture

#include "fitting/modal/dissipation.h"

#include <algorithm>

#include "physics/simulate/energy.h"

namespace pliant {

Dissipation dissipation_of(const Motion<float>& motion) {
  // A frame is one time step, so that the integral is the solver's own.
  SimulateOptions options = motion.options.simulate;
  const int frames = static_cast<int>(std::lround(options.fps * options.duration));
  const int substeps = std::max(1, options.substeps);
  options.fps *= substeps;
  options.substeps = 1;
  options.duration = double(frames) * substeps / options.fps;
  double kinetic = 0, first = 0, last = 0, before = 0;
  simulate<float>(options, motion.particles, motion.interactions, motion.start, [&](const SimulationState& state) {
    const double now = kinetic_energy(motion.particles, state);
    if (state.frame == 0) first = now + elastic_energy(motion.particles, state);
    if (state.frame > 0) kinetic += 0.5 * (before + now) / options.fps;
    if (state.frame == frames * substeps) last = now + elastic_energy(motion.particles, state);
    before = now;
    return true;
  });
  Dissipation out;
  if (!(kinetic > 0)) return out;
  out.whole = (first - last) / (4 * kinetic);
  out.transfers = out.whole - (options.damping_time > 0 ? 1 / options.damping_time : 0);
  return out;
}

double damping_time_beside_transfers(Motion<float> motion, double whole_time) {
  SimulateOptions& options = motion.options.simulate;
  if (options.substeps == 0) {  // those of the first frame for all
    SimulateOptions first = options;
    first.duration = 1 / options.fps;
    options.substeps =
        simulate<float>(first, motion.particles, motion.interactions, motion.start).summary.substeps_of_frame.at(0);
  }
  options.damping_time = whole_time;
  // Drag changes which motion lasts, and with it a little what the transfers take.
  for (int pass = 0; pass < 2; ++pass) {
    const double rest = 1 / whole_time - dissipation_of(motion).transfers;
    if (!(rest > 0)) return 0;
    options.damping_time = 1 / rest;
  }
  return options.damping_time;
}

}  // namespace pliant

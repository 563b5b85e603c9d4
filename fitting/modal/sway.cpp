#include "fitting/modal/sway.h"

#include <algorithm>
#include <cmath>

#include "gaussians/base/error.h"
#include "physics/laws/material.h"

namespace pliant {

std::optional<double> sway_frequency(const SwayOptions& options, const Particles& particles,
                                     const std::vector<Interaction>& interactions) {
  constexpr double kSpeed = 1e-3;  // of sound: small, so that the motion is linear
  constexpr int kSubsteps = 8;     // per look at the state
  std::vector<Interaction> pins;
  for (const Interaction& it : interactions)
    if (it.type == InteractionType::kPin && it.start <= 0) pins.push_back(it);
  if (pins.empty())
    throw usage_error("predict", "pins", "hold nothing, and a body that nothing holds does not sway", "pin a part");
  Particles body = particles;
  body.materials = {Material{}};  // all laws agree for small strains
  body.material_index.clear();
  double sound = 0;
  for (size_t i = 0; i < body.size(); ++i) {
    const Lame<double> law = lame<double>(body.young[i], body.poisson[i]);
    sound = std::max(sound, std::sqrt((law.lambda + 2 * law.mu) * body.volume[i] / body.mass[i]));
  }
  SimulateOptions simulation;
  simulation.gravity.setZero();
  simulation.grid = options.grid;
  simulation.substeps = kSubsteps;
  const double dt = simulation.courant * body.cell_size / sound;
  simulation.fps = 1 / (kSubsteps * dt);
  simulation.duration = options.max_substeps * dt;
  SimulationState start = initial_state(body);
  for (Vec3f& v : start.v) v = (kSpeed * sound * options.direction).cast<float>();

  double before = 0, time_before = 0;
  std::optional<double> back;
  simulate<float>(simulation, body, pins, start, [&](const SimulationState& state) {
    double along = 0;
    for (size_t i = 0; i < state.size(); ++i)
      along += body.mass[i] * options.direction.dot((state.x[i] - body.position[i]).cast<double>());
    if (state.frame > 1 && before > 0 && along <= 0)
      back = time_before + (state.time - time_before) * before / (before - along);
    before = along;
    time_before = state.time;
    return !back;
  });
  if (!back) return std::nullopt;
  return 0.5 / *back;
}

}  // namespace pliant

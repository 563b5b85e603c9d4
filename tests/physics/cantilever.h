#pragma once

#include <vector>

#include "physics/simulate/simulate.h"

namespace pliant::fixture {

/// First frequency [Hz] of a body that `wall` holds, by the time until it first turns round after gravity is switched
/// on; 0 when it does not within `duration`.  `weight` of the particles is near the shape of the first mode.
inline double first_frequency(const Particles& particles, const Interaction& wall, const Vec3d& gravity,
                              const std::vector<double>& weight, double duration) {
  constexpr double fps = 400;
  SimulateOptions options;
  options.fps = fps;
  options.duration = duration;
  options.gravity.setZero();
  Interaction load;
  load.type = InteractionType::kGravity;
  load.vector = gravity;
  std::vector<double> sag;
  simulate<float>(options, particles, {wall, load}, initial_state(particles), [&](const SimulationState& s) {
    double sum = 0;
    for (size_t i = 0; i < s.size(); ++i)
      sum += weight[i] * (s.x[i] - particles.position[i]).cast<double>().dot(gravity);
    sag.push_back(sum);
    return true;
  });
  for (size_t k = 1; k + 1 < sag.size(); ++k) {
    if (sag[k] < sag[k - 1] || sag[k] < sag[k + 1]) continue;
    const double slope = 0.5 * (sag[k + 1] - sag[k - 1]), bend = sag[k + 1] - 2 * sag[k] + sag[k - 1];
    return 0.5 * fps / (static_cast<double>(k) - slope / bend);
  }
  return 0;
}

}  // namespace pliant::fixture

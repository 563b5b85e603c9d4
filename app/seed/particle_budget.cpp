#include "app/seed/particle_budget.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "physics/laws/material.h"
#include "physics/simulate/simulate.h"

namespace pliant {
using nlohmann::json;

CoarseCost cost_of(const Particles& body, int asked) {
  double sound = 0;
  for (size_t i = 0; i < body.size(); ++i) {
    const Lame<double> law = lame<double>(body.young[i], body.poisson[i]);
    sound = std::max(sound, std::sqrt((law.lambda + 2 * law.mu) * body.volume[i] / body.mass[i]));
  }
  return {static_cast<double>(asked), static_cast<double>(body.size()),
          sound / (SimulateOptions().courant * body.cell_size)};
}

json to_json(const CoarseCost& cost) {
  return {{"asked", cost.asked}, {"particles", cost.particles}, {"steps_per_second", cost.steps_per_second}};
}

CoarseCost cost_from_json(const json& record) {
  return {record["asked"], record["particles"], record["steps_per_second"]};
}

double particle_steps(const CoarseCost& cost, int count) {
  const double finer = std::cbrt(count / cost.asked);  // cells
  const double of_thin = std::max(cost.particles - cost.asked, 0.0) * finer * finer;
  return (count + of_thin) * cost.steps_per_second * finer;
}

int affordable_count(const CoarseCost& cost, int usual) {
  if (particle_steps(cost, usual) <= kUsualParticleSteps) return usual;
  int low = kFewestParticles, high = usual;
  while (high - low > 1) {
    const int middle = (low + high) / 2;
    (particle_steps(cost, middle) <= kUsualParticleSteps ? low : high) = middle;
  }
  return low;
}

}  // namespace pliant

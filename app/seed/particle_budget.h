#pragma once

#include <nlohmann/json_fwd.hpp>

#include "app/simulate/clip_work.h"
#include "physics/mpm/particles.h"

namespace pliant {

/// What simulating an object costs, measured on a body of few particles.
struct CoarseCost {
  double asked = 0;             ///< particles that were asked for
  double particles = 0;         ///< that the body has: thin parts get more
  double steps_per_second = 0;  ///< of motion, as the fastest sound asks for
};
CoarseCost cost_of(const Particles& body, int asked);
nlohmann::json to_json(const CoarseCost& cost);
CoarseCost cost_from_json(const nlohmann::json& record);

/// Particles times time steps that a second of motion takes where `count` particles are asked for: cells half as wide
/// take twice as many steps, and thin parts four times the particles that they get besides.
double particle_steps(const CoarseCost& cost, int count);

/// Particles where even fewer would take more than kUsualParticleSteps.
constexpr int kFewestParticles = 2000;
/// `usual`, or as many as kUsualParticleSteps of a second of motion allow, where the user does not say how many.
int affordable_count(const CoarseCost& cost, int usual);

}  // namespace pliant

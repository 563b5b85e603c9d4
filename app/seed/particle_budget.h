#pragma once

#include <nlohmann/json_fwd.hpp>

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

/// Particles times time steps that a second of motion takes where `count` particles are asked for: halving the cells
/// halves the steps.
double particle_steps(const CoarseCost& cost, int count);

/// As many of them as a second of motion may take where the user does not say how many particles there are: a clip of
/// four seconds takes a minute on two cores.
constexpr double kUsualParticleSteps = 1e8;
/// Still so many particles where that is too few steps.
constexpr int kFewestParticles = 2000;
/// `usual`, or as many as these steps allow.
int affordable_count(const CoarseCost& cost, int usual);

}  // namespace pliant

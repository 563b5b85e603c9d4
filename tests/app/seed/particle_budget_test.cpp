// How many driving particles a material is simulated with where nobody says: as many as can be in good time.

#include "app/seed/particle_budget.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace pliant {
namespace {

TEST(ParticleBudget, CellsHalfAsWideTakeTwiceAsManySteps) {
  const CoarseCost bulk{1000, 1000, 5000};
  EXPECT_DOUBLE_EQ(particle_steps(bulk, 1000), 1000.0 * 5000);
  EXPECT_NEAR(particle_steps(bulk, 8000), 16 * particle_steps(bulk, 1000), 1e-3);
  // What thin parts get besides covers their area.
  const CoarseCost thin{1000, 3000, 5000};
  EXPECT_NEAR(particle_steps(thin, 8000), (8000.0 + 4 * 2000) * 2 * 5000, 1e-3);
}

TEST(ParticleBudget, IsTheUsualCountTheLargestThatFitsOrTheFewest) {
  EXPECT_EQ(affordable_count({1000, 1000, 1000}, 8000), 8000);
  const CoarseCost stiff{1000, 1000, 12000};
  const int count = affordable_count(stiff, 8000);
  EXPECT_GT(count, kFewestParticles);
  EXPECT_LT(count, 8000);
  EXPECT_LE(particle_steps(stiff, count), kUsualParticleSteps);
  EXPECT_GT(particle_steps(stiff, count + 1), kUsualParticleSteps);
  EXPECT_EQ(affordable_count({1000, 1000, 1e7}, 8000), kFewestParticles);
}

TEST(ParticleBudget, TheCostIsThatOfTheFastestSound) {
  Particles body;
  body.cell_size = 0.01;
  for (int i = 0; i < 2; ++i) {
    body.position.push_back(Eigen::Vector3f::Zero());
    body.young.push_back(i ? 4e6f : 1e6f);
    body.poisson.push_back(0);
    body.volume.push_back(1e-6f);
    body.mass.push_back(1e-3f);
  }
  // With nu = 0 the P-wave modulus is E: c = sqrt(4e6 / 1000).
  const CoarseCost cost = cost_of(body, 1000);
  EXPECT_EQ(cost.particles, 2);
  EXPECT_NEAR(cost.steps_per_second, std::sqrt(4000.0) / (0.4 * 0.01), 1);
  const CoarseCost back = cost_from_json(to_json(cost));
  EXPECT_EQ(back.steps_per_second, cost.steps_per_second);
  EXPECT_EQ(back.asked, 1000);
}

}  // namespace
}  // namespace pliant

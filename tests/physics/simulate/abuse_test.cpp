// Absurd input ends in finite frames or in a typed error after the last good one, never in anything else.

#include <gtest/gtest.h>

#include "gaussians/base/error.h"
#include "physics/simulate/simulate.h"
#include "tests/physics/shapes.h"

namespace pliant {
namespace {

struct Outcome {
  int frames = 0;  // delivered, all finite
  bool finished = false;
  std::string error;
};

Outcome outcome_of(const Particles& particles, const std::vector<Interaction>& script, SimulationState start,
                   const SimulateOptions& options) {
  Outcome out;
  const auto sink = [&](const SimulationState& s) {
    for (size_t i = 0; i < s.size(); ++i)
      EXPECT_TRUE(s.x[i].allFinite() && s.v[i].allFinite() && s.C[i].allFinite() && s.F[i].allFinite());
    EXPECT_EQ(s.frame, out.frames);
    ++out.frames;
    return true;
  };
  try {
    simulate<float>(options, particles, script, std::move(start), sink);
    out.finished = true;
  } catch (const Error& error) {
    EXPECT_TRUE(error.failure == Failure::kNumerical || error.failure == Failure::kUsage) << error.what();
    out.error = error.what();
  }
  return out;
}

SimulateOptions short_run(double fps = 50, int frames = 3) {
  SimulateOptions options;
  options.fps = fps;
  options.duration = frames / fps;
  return options;
}

Interaction of_type(InteractionType type, const Vec3d& vector = Vec3d::Zero()) {
  Interaction it;
  it.type = type;
  it.vector = vector;
  return it;
}

const Vec3d kSize(0.04, 0.03, 0.05);

TEST(Abuse, StiffBesideSoft) {
  auto p = fixture::block<float>(kSize, 0.01);
  for (size_t i = 0; i < p.size(); ++i) p.young[i] = p.position[i].z() > 0.025f ? 1e11f : 1e2f;
  const Outcome out =
      outcome_of(p, {of_type(InteractionType::kPointForce, Vec3d(0.1, 0, 0))}, initial_state(p), short_run(5000));
  EXPECT_TRUE(out.finished) << out.error;
}

TEST(Abuse, AForceOfABillionNewtons) {
  const auto p = fixture::block<float>(kSize, 0.01);
  Interaction blow = of_type(InteractionType::kPointForce, Vec3d(1e9, 0, 0));
  blow.start = 0.03;
  const Outcome out = outcome_of(p, {blow}, initial_state(p), short_run());
  EXPECT_TRUE(out.finished || out.frames >= 2) << out.error;  // what came before is kept
}

TEST(Abuse, DeformationsThatNoBodyHas) {
  const auto p = fixture::block<float>(kSize, 0.01);
  for (const float stretch : {-1.0f, 0.0f, 1e-8f, 1e8f, -0.3f}) {
    for (const bool all : {true, false}) {
      SimulationState start = initial_state(p);
      for (size_t i = 0; i < (all ? p.size() : 1); ++i) start.F[i].row(0) *= stretch;
      const Outcome out = outcome_of(p, {}, start, short_run());
      EXPECT_TRUE(out.finished || out.frames >= 1) << stretch << out.error;
    }
  }
}

TEST(Abuse, ParticlesFarAway) {
  const auto p = fixture::block<float>(kSize, 0.01);
  SimulationState start = initial_state(p);
  start.x[0] = Vec3f(1e6f, 0, 0);
  start.x[1] = Vec3f(0, -1e20f, 0);
  start.x[2] = Vec3f(0.3f, 0.3f, 0.3f);
  SimulateOptions options = short_run();
  options.grid = GridKind::kEulerian;
  EXPECT_TRUE(outcome_of(p, {}, start, options).finished);
  // On a Lagrangian grid they are tied to the rest of the body, which they tear away.
  const Outcome tied = outcome_of(p, {}, start, short_run());
  EXPECT_FALSE(tied.finished);
  EXPECT_NE(tied.error.find("unstable"), std::string::npos) << tied.error;
}

TEST(Abuse, ThreeParticles) {
  auto p = fixture::block<float>(kSize, 0.01);
  for (auto* v : {&p.volume, &p.mass, &p.young, &p.poisson}) v->resize(3);
  p.position.resize(3);
  Interaction ground = of_type(InteractionType::kGround);
  ground.region = Region::half_space(Vec3d::Zero(), Vec3d::UnitZ());
  EXPECT_TRUE(outcome_of(p, {ground}, initial_state(p), short_run()).finished);
}

TEST(Abuse, GravityOfZeroAndOfTenThousand) {
  const auto p = fixture::block<float>(kSize, 0.01);
  Interaction ground = of_type(InteractionType::kGround);
  ground.region = Region::half_space(Vec3d::Zero(), Vec3d::UnitZ());
  for (const double g : {0.0, 1e4}) {
    SimulateOptions options = short_run();
    options.gravity = Vec3d(0, 0, -g);
    const Outcome out = outcome_of(p, {ground}, initial_state(p), options);
    EXPECT_TRUE(out.finished || out.frames >= 1) << g << out.error;
    EXPECT_TRUE(out.finished || g > 0);
  }
}

TEST(Abuse, CollidersThatStartInsideOfTheBody) {
  const auto p = fixture::block<float>(kSize, 0.01);
  for (const ContactKind kind : {ContactKind::kSticky, ContactKind::kSlip, ContactKind::kSeparating}) {
    for (const bool container : {false, true}) {
      Interaction inside = of_type(InteractionType::kCollider, Vec3d(0.5, 0, 0));
      inside.region = Region::sphere(Vec3d(0.02, 0.015, 0.02), 0.015);
      inside.contact = kind;
      inside.container = container;
      inside.friction = 0.5;
      inside.angular_velocity = Vec3d(0, 0, 20);
      const Outcome out = outcome_of(p, {inside}, initial_state(p), short_run());
      EXPECT_TRUE(out.finished) << out.error;
    }
  }
}

TEST(Abuse, ObjectsThatStartInsideEachOther) {
  auto p = fixture::block<float>(kSize, 0.01);
  for (size_t i = 0; i < p.size(); ++i) p.object.push_back(i % 2);
  const Outcome out =
      outcome_of(p, {of_type(InteractionType::kImpulse, Vec3d(0.01, 0, 0))}, initial_state(p), short_run());
  EXPECT_TRUE(out.finished) << out.error;
}

}  // namespace
}  // namespace pliant

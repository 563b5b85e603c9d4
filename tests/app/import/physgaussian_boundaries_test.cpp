// Boundary conditions of PhysGaussian: each acts during its time, on what it names, and in the order of the released
// code; what is done otherwise is said.

#include <gtest/gtest.h>

#include "tests/app/import/physgaussian_fixture.h"

namespace pliant {
namespace {

using namespace fixture;

/// What a list of boundary conditions becomes, for a body of extent 1 about (1, 1, 1) in a clip of a second.
PhysGaussianWorld world_of(const std::string& conditions, Compatibility compatibility = Compatibility::kCorrected) {
  const PhysGaussianConfig config =
      parse(R"({"g": [0,0,0], "n_grid": 20, "boundary_conditions": [)" + conditions + "]}");
  std::vector<Vec3d> gaussians;
  const Particles p = stand_in(config, gaussians);
  return physgaussian_world(config, compatibility, p, gaussians);
}

std::string notes_of(const PhysGaussianWorld& world) {
  std::string all;
  for (const std::string& note : world.notes) all += note + "\n";
  return all;
}

bool freezes_all(const Interaction& it) {
  return it.contact == ContactKind::kSticky && it.vector.isZero() && it.region.contains(Vec3d::Zero()) &&
         it.region.contains(Vec3d::Constant(2));
}

TEST(PhysGaussianBoundaries, ActDuringTheirTime) {
  const std::string span = R"("start_time": 0.2, "end_time": 0.7)";
  for (const char* condition :
       {R"("type": "cuboid", "point": [1,1,1], "size": [1,1,0.2], "velocity": [1,0,0])",
        R"("type": "enforce_particle_translation", "point": [1,1,1], "size": [1,1,0.2], "velocity": [1,0,0])",
        R"("type": "enforce_particle_velocity_rotation", "point": [1,1,1], "normal": [0,0,1],
           "half_height_and_radius": [0.2, 1], "rotation_scale": 1, "translation_scale": 0)",
        R"("type": "surface_collider", "point": [1,1,1], "normal": [0,0,1], "surface": "slip")",
        R"("type": "bounding_box")"}) {
    const PhysGaussianWorld world = world_of("{" + std::string(condition) + ", " + span + "}");
    ASSERT_EQ(world.interactions.size(), 1u) << condition;
    EXPECT_NEAR(world.interactions[0].start, 0.2, 1e-12) << condition;
    EXPECT_NEAR(world.interactions[0].end(), 0.7, 1e-12) << condition;
  }
}

TEST(PhysGaussianBoundaries, ABoundingBoxLastsTheWholeTimeInTheReleasedCodeAlone) {
  const std::string timed = R"({"type": "bounding_box", "start_time": 0.2, "end_time": 0.7})";
  const PhysGaussianWorld compat = world_of(timed, Compatibility::kPhysGaussian);
  EXPECT_EQ(compat.interactions[0].start, 0);
  EXPECT_GT(compat.interactions[0].end(), 100);
  for (const PhysGaussianWorld& world : {compat, world_of(timed)})
    EXPECT_NE(notes_of(world).find("start_time and end_time"), std::string::npos) << notes_of(world);
  EXPECT_EQ(notes_of(world_of(R"({"type": "bounding_box"})")).find("bounding_box"), std::string::npos);
}

TEST(PhysGaussianBoundaries, ResetBringsTheBodyToRestAfterItsCuboid) {
  for (const Compatibility compatibility : {Compatibility::kCorrected, Compatibility::kPhysGaussian})
    for (const bool reset : {false, true}) {
      const PhysGaussianConfig config =
          parse(std::string(R"({"g": [0,0,0], "n_grid": 20, "E": 1e4, "frame_dt": 2e-2, "frame_num": 4,
            "boundary_conditions": [{"type": "cuboid", "point": [1,1,1], "size": [0.5,0.5,0.8], "velocity": [0.5,0,0],
            "end_time": 0.04, "reset": )") +
                (reset ? "1}]}" : "0}]}"));
      std::vector<Vec3d> gaussians;
      Particles p = stand_in(config, gaussians);
      set_physgaussian_material(config, compatibility, p);
      const PhysGaussianWorld world = physgaussian_world(config, compatibility, p, gaussians);
      const SimulateResult result = simulate<float>(world.options, p, world.interactions, initial_state(p));
      Vec3d velocity = Vec3d::Zero(), way = Vec3d::Zero();
      const double share = 1.0 / static_cast<double>(p.size());
      for (size_t i = 0; i < p.size(); ++i) {
        velocity += share * result.state.v[i].cast<double>();
        way += share * (result.state.x[i] - p.position[i]).cast<double>();
      }
      EXPECT_NEAR(velocity.x(), reset ? 0 : 0.5, 0.02) << reset;
      EXPECT_NEAR(way.x(), reset ? 0.02 : 0.04, 0.003) << reset;
    }
}

TEST(PhysGaussianBoundaries, ResetFreezesTheBodyBeforeItsCuboidInTheReleasedCodeAlone) {
  const std::string late = R"({"type": "cuboid", "point": [1,1,1], "size": [0.2,0.2,0.2], "velocity": [0,0,0],
    "start_time": 0.3, "end_time": 0.6, "reset": 1})";
  std::vector<std::pair<double, double>> frozen;
  const PhysGaussianWorld compat = world_of(late, Compatibility::kPhysGaussian), right = world_of(late);
  for (const Interaction& it : compat.interactions)
    if (freezes_all(it)) frozen.emplace_back(it.start, it.end());
  ASSERT_EQ(frozen.size(), 2u);
  EXPECT_EQ(frozen[0].first, 0);
  EXPECT_NEAR(frozen[0].second, 0.3, 1e-12);
  EXPECT_NEAR(frozen[1].first, 0.6, 1e-12);
  EXPECT_NEAR(frozen[1].second, 0.6 + 15e-4, 1e-12);
  ASSERT_EQ(right.interactions.size(), 2u);
  EXPECT_TRUE(freezes_all(right.interactions[1]));
  EXPECT_NEAR(right.interactions[1].start, 0.6, 1e-12);
  EXPECT_NE(notes_of(right).find("here the body is free"), std::string::npos) << notes_of(right);
  // A cuboid that outlasts the clip resets nothing.
  const PhysGaussianWorld lasting = world_of(R"({"type": "cuboid", "point": [1,1,1], "size": [0.2,0.2,0.2],
    "velocity": [0,0,0], "end_time": 1e3, "reset": 1})");
  EXPECT_EQ(lasting.interactions.size(), 1u);
  EXPECT_EQ(notes_of(lasting).find("reset"), std::string::npos) << notes_of(lasting);
}

TEST(PhysGaussianBoundaries, NodesObeyAfterParticles) {
  const PhysGaussianWorld world = world_of(
      R"({"type": "bounding_box"}, {"type": "enforce_particle_translation", "point": [1,1,1.4], "size": [1,1,0.1],
      "velocity": [0,0,1]}, {"type": "surface_collider", "point": [1,1,0.6], "normal": [0,0,1]})");
  ASSERT_EQ(world.interactions.size(), 3u);
  EXPECT_EQ(world.interactions[0].vector, Vec3d(0, 0, 1));
  EXPECT_TRUE(world.interactions[1].container);
  EXPECT_EQ(world.interactions[2].region.kind, Region::Kind::kHalfSpace);
}

TEST(PhysGaussianBoundaries, APartIsFoundWhereEarlierConditionsOfTheSamePartLeftIt) {
  const auto turn = [](const char* normal, const char* times) {
    return std::string(R"({"type": "enforce_particle_velocity_rotation", "point": [1,1,1], "normal": )") + normal +
           R"(, "half_height_and_radius": [0.2, 0.3], "rotation_scale": 1, "translation_scale": 0.5, )" + times + "}";
  };
  const std::string first = turn("[0,0,1]", R"("start_time": 0, "end_time": 0.4)");
  const PhysGaussianWorld same = world_of(first + "," + turn("[0,0,2]", R"("start_time": 0.4, "end_time": 0.8)")),
                          other = world_of(first + "," + turn("[1,0,0]", R"("start_time": 0.4, "end_time": 0.8)"));
  EXPECT_LT((same.interactions[1].pivot - Vec3d(1, 1, 1.2)).norm(), 1e-12);
  EXPECT_LT((other.interactions[1].pivot - Vec3d(1, 1, 1)).norm(), 1e-12);
  EXPECT_EQ(notes_of(same).find("from 0.4 s"), std::string::npos) << notes_of(same);
  EXPECT_NE(notes_of(other).find("from 0.4 s"), std::string::npos) << notes_of(other);
}

TEST(PhysGaussianBoundaries, LayersLieAlongAnAxisWhateverItsSign) {
  for (const char* normal : {"[0,0,1]", "[0,0,-3]"}) {
    const PhysGaussianWorld world =
        world_of(std::string(R"({"type": "release_particles_sequentially", "start_position": 0.5, "end_position": 1.5,
      "num_layers": 2, "start_time": 0, "end_time": 0.4, "normal": )") +
                 normal + "}");
    ASSERT_EQ(world.interactions.size(), 2u);
    EXPECT_TRUE(world.interactions[1].region.contains({1, 1, 1.01})) << normal;
    EXPECT_FALSE(world.interactions[1].region.contains({1, 1, 0.99})) << normal;
  }
}

TEST(PhysGaussianBoundaries, WhatDoesNothingIsRefusedOrSaid) {
  const auto refused = [](const std::string& condition, const std::vector<std::string>& words) {
    expect_refused(R"({"boundary_conditions": [)" + condition + "]}", words);
  };
  refused(R"({"type": "surface_collider", "point": [1,1,1], "normal": [0,0,1], "surface": "sticky", "friction": 0.3})",
          {"boundary_conditions[0]", "friction", "sticky"});
  refused(R"({"type": "release_particles_sequentially", "normal": [0,1,1], "start_position": 0, "end_position": 1})",
          {"boundary_conditions[0]", "normal", "axis"});
  refused(R"({"type": "release_particles_sequentially", "normal": [0,1,0], "start_position": 1, "end_position": 1})",
          {"boundary_conditions[0]", "end_position"});

  const PhysGaussianWorld slip = world_of(
      R"({"type": "surface_collider", "point": [1,1,1], "normal": [0,0,1], "surface": "slip", "friction": 0.3})");
  EXPECT_NE(notes_of(slip).find("friction, 0.3, is not used"), std::string::npos) << notes_of(slip);
  const PhysGaussianWorld empty = world_of(R"({"type": "enforce_particle_translation", "point": [0.2,1,1],
    "size": [0.1,0.1,0.1], "velocity": [0,0,1]})");
  EXPECT_TRUE(empty.interactions.empty());
  EXPECT_NE(notes_of(empty).find("does nothing"), std::string::npos) << notes_of(empty);
}

}  // namespace
}  // namespace pliant

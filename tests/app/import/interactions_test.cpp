// Interaction scripts: units, and a typed message with file, row, field and remedy for every kind of mistake.

#include "app/import/interactions.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "gaussians/base/error.h"

namespace pliant {
namespace {

const InteractionFrame kHalfMetre{0.5, {0, 0, 1}};

Error error_of(const std::string& text) {
  try {
    parse_interactions(text, kHalfMetre, "push.json");
  } catch (const Error& error) {
    return error;
  }
  ADD_FAILURE() << "accepted: " << text;
  return usage_error("", "", "", "");
}

TEST(Interactions, PositionsAreSceneUnitsAndForcesNewtons) {
  const auto rows = parse_interactions(
      R"([{"type": "point_force", "region": {"sphere": [2, 4, 6, 1]}, "force": [0, 3, 0], "start": 0.5, "duration": 0.2}])",
      kHalfMetre, "push.json");
  ASSERT_EQ(rows.size(), 1u);
  EXPECT_EQ(rows[0].type, InteractionType::kPointForce);
  EXPECT_EQ(rows[0].region.point, Vec3d(1, 2, 3));
  EXPECT_EQ(rows[0].region.radius, 0.5);
  EXPECT_EQ(rows[0].vector, Vec3d(0, 3, 0));
  EXPECT_EQ(rows[0].start, 0.5);
  EXPECT_EQ(rows[0].end(), 0.7);
}

TEST(Interactions, GrabPathAndBelowRegionAreScaled) {
  const auto rows = parse_interactions(
      R"([{"type": "grab", "region": "all", "path": [[0, 1, 0, 0], [1, 3, 0, 0]], "max_force": 2},
          {"type": "pin", "region": {"below": 0.4}}])",
      kHalfMetre, "push.json");
  EXPECT_EQ(rows[0].path[1].position, Vec3d(1.5, 0, 0));
  EXPECT_EQ(rows[0].max_force, 2);
  EXPECT_TRUE(rows[1].region.contains({7, 7, 0.19}));
  EXPECT_FALSE(rows[1].region.contains({7, 7, 0.21}));
}

TEST(Interactions, RegionsSurviveTheWayThroughJson) {
  for (const Region& region :
       {Region::all(), Region::sphere({1, 2, 3}, 4), Region::box({0, 0, 0}, {1, 2, 3}),
        Region::half_space({0, 0, 0.25}, {0, 0, 1}), Region::half_space({1, 0, 0.25}, {0.6, 0, 0.8}),
        Region::cylinder({0, 0.5, 0}, {1, 0.5, 0}, 0.3)}) {
    const Region back = parse_region(region_to_json(region), {1.0, {0, 0, 1}}, "test");
    for (const Vec3d& x : {Vec3d(0.5, 0.5, 0.2), Vec3d(0.5, 0.5, 0.3), Vec3d(9, 9, 9), Vec3d(1, 2, 6.9)})
      EXPECT_EQ(back.contains(x), region.contains(x));
  }
}

TEST(Interactions, CollidersAndFingersAreScaledAndMove) {
  const auto rows = parse_interactions(
      R"([{"type": "collider", "region": {"cylinder": [0, 0, 0, 0, 0, 2, 1]}, "contact": "slip", "container": true,
           "velocity": [1, 0, 0], "angular_velocity": [0, 0, 3], "pivot": [2, 0, 0], "start": 1},
          {"type": "poke", "radius": 0.4, "path": [[0, 2, 0, 0], [1, 4, 0, 0]], "friction": 0.1}])",
      kHalfMetre, "push.json");
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0].region.vector, Vec3d(0, 0, 1));
  EXPECT_EQ(rows[0].region.radius, 0.5);
  EXPECT_EQ(rows[0].contact, ContactKind::kSlip);
  EXPECT_TRUE(rows[0].container);
  EXPECT_EQ(rows[0].vector, Vec3d(1, 0, 0));
  EXPECT_EQ(rows[0].angular_velocity, Vec3d(0, 0, 3));
  EXPECT_EQ(rows[0].pivot, Vec3d(1, 0, 0));
  EXPECT_EQ(rows[1].region.radius, 0.2);
  EXPECT_EQ(rows[1].path[1].position, Vec3d(2, 0, 0));
  EXPECT_EQ(rows[1].friction, 0.1);
}

TEST(Interactions, AColliderTurnsAboutItsMiddleWhereNothingElseIsSaid) {
  const auto pivot = [](const std::string& keys) {
    return parse_interactions(R"([{"type": "collider", "angular_velocity": [0, 0, 1], )" + keys + "}]", kHalfMetre,
                              "x")[0]
        .pivot;
  };
  EXPECT_EQ(pivot(R"("region": {"sphere": [2, 4, 6, 1]})"), Vec3d(1, 2, 3));
  EXPECT_EQ(pivot(R"("region": {"box": [0, 0, 0, 2, 4, 8]})"), Vec3d(0.5, 1, 2));
  EXPECT_EQ(pivot(R"("region": {"cylinder": [0, 0, 0, 4, 0, 0, 1]})"), Vec3d(1, 0, 0));
  EXPECT_EQ(pivot(R"("region": {"sphere": [2, 4, 6, 1]}, "pivot": [0, 2, 0])"), Vec3d(0, 1, 0));
  EXPECT_EQ(pivot(R"("region": {"sphere": [2, 4, 6, 1]}, "path": [[0, 8, 0, 0]])"), Vec3d(4, 0, 0));
  EXPECT_EQ(pivot(R"("region": {"plane": [0, 0, 0, 0, 0, 1]}, "pivot": [2, 0, 0])"), Vec3d(1, 0, 0));
  const std::string plane = R"([{"type": "collider", "region": {"plane": [0, 0, 0, 0, 0, 1]})";
  EXPECT_EQ(error_of(plane + R"(, "angular_velocity": [0, 0, 1]}])").field, "pivot");
  EXPECT_NO_THROW(parse_interactions(plane + R"(, "velocity": [0, 0, 1]}])", kHalfMetre, "x"));
}

TEST(Interactions, TorqueAndWindAreSi) {
  const auto rows = parse_interactions(
      R"([{"type": "torque", "region": "all", "torque": [0, 0, 0.2], "duration": 1},
          {"type": "wind", "wind": [3, 0, 0], "drag_coefficient": 0.5}])",
      kHalfMetre, "push.json");
  EXPECT_EQ(rows[0].vector, Vec3d(0, 0, 0.2));
  EXPECT_EQ(rows[1].vector, Vec3d(3, 0, 0));
  EXPECT_EQ(rows[1].drag_coefficient, 0.5);
  EXPECT_EQ(rows[1].air_density, 1.2);
  EXPECT_EQ(error_of(R"([{"type": "torque", "region": "all"}])").field, "torque");
  EXPECT_EQ(error_of(R"([{"type": "wind", "wind": [1, 0, 0], "drag": 2}])").field, "drag");
}

TEST(Interactions, AnImpulseHasNoDuration) {
  const Error error = error_of(R"([{"type": "impulse", "region": "all", "impulse": [1, 0, 0], "duration": 0.2}])");
  EXPECT_EQ(error.failure, Failure::kUsage);
  EXPECT_EQ(error.field, "duration");
  EXPECT_NE(error.remedy.find("point_force"), std::string::npos);
}

TEST(Interactions, WhatDoesNothingInItsRowIsRefused) {
  const Error drag = error_of(R"([{"type": "gust", "acceleration": [3, 0, 0], "drag": 2}])");
  EXPECT_EQ(drag.failure, Failure::kUsage);
  EXPECT_EQ(drag.field, "drag");
  EXPECT_NE(drag.remedy.find("wind"), std::string::npos);
  EXPECT_EQ(parse_interactions(R"([{"type": "gust", "wind": [3, 0, 0], "drag": 2}])", kHalfMetre, "x")[0].rate, 2);
  const std::string wall = R"([{"type": "collider", "region": {"sphere": [2, 4, 6, 1]}, "friction": 0.8)";
  for (const char* contact : {"sticky", "slip"}) {
    const Error friction = error_of(wall + R"(, "contact": ")" + contact + R"("}])");
    EXPECT_EQ(friction.failure, Failure::kUsage);
    EXPECT_EQ(friction.field, "friction");
    EXPECT_NE(friction.remedy.find("separating"), std::string::npos);
  }
  for (const char* contact : {"", R"(, "contact": "separating")"})
    EXPECT_EQ(parse_interactions(wall + contact + "}]", kHalfMetre, "x")[0].friction, 0.8);
}

TEST(Interactions, AWeightHasKilogramsAndHangsAllTheTime) {
  const auto rows =
      parse_interactions(R"([{"type": "weight", "region": {"sphere": [0, 0, 2, 1]}, "mass": 0.052}])", kHalfMetre, "x");
  EXPECT_EQ(rows[0].type, InteractionType::kWeight);
  EXPECT_EQ(rows[0].mass, 0.052);
  EXPECT_EQ(rows[0].region.radius, 0.5);
  EXPECT_EQ(error_of(R"([{"type": "weight", "mass": 1}])").field, "region");
  EXPECT_EQ(error_of(R"([{"type": "weight", "region": "all"}])").field, "mass");
  for (const char* mass : {"0", "-1", "1e999", "\"1\"", "null"})
    EXPECT_EQ(error_of(R"([{"type": "weight", "region": "all", "mass": )" + std::string(mass) + "}]").failure,
              Failure::kUsage)
        << mass;
  EXPECT_EQ(error_of(R"([{"type": "weight", "region": "all", "mass": 1, "start": 1}])").field, "start");
  EXPECT_EQ(error_of(R"([{"type": "weight", "region": "all", "mass": 1, "duration": 1}])").field, "duration");
}

TEST(Interactions, MistakesNameFileRowFieldAndRemedy) {
  const Error unknown_type = error_of(R"([{"type": "gravty"}])");
  EXPECT_EQ(unknown_type.failure, Failure::kUsage);
  EXPECT_EQ(unknown_type.where, "push.json[0]");
  EXPECT_NE(unknown_type.remedy.find("gravity"), std::string::npos);

  const Error unknown_key = error_of(R"([{"type": "pin", "region": "all", "strat": 1}])");
  EXPECT_EQ(unknown_key.field, "strat");
  EXPECT_NE(unknown_key.remedy.find("start"), std::string::npos);

  EXPECT_EQ(error_of(R"([{"type": "point_force", "force": [1, 0, 0]}])").field, "region");
  EXPECT_EQ(error_of(R"([{"type": "point_force", "region": "all", "force": [1, 0]}])").field, "force");
  EXPECT_EQ(error_of(R"([{"type": "pin", "region": {"sphere": [0, 0, 0, -1]}}])").field, "region.sphere");
  EXPECT_EQ(error_of(R"([{"type": "pin", "region": {"box": [1, 0, 0, 0, 1, 1]}}])").field, "region.box");
  EXPECT_EQ(error_of(R"([{"type": "gust", "wind": [1, 0, 0], "acceleration": [1, 0, 0]}])").field, "wind");
  EXPECT_EQ(error_of(R"([{"type": "collider"}])").field, "region");
  EXPECT_EQ(error_of(R"([{"type": "collider", "region": "all"}])").field, "region");
  EXPECT_NE(
      error_of(R"([{"type": "collider", "region": {"sphere": [0, 0, 0, 1]}, "contact": "slipp"}])").remedy.find("slip"),
      std::string::npos);
  EXPECT_EQ(error_of(R"([{"type": "poke", "path": [[0, 0, 0, 0]]}])").field, "radius");
  EXPECT_EQ(error_of(R"([{"type": "poke", "radius": 1, "path": [[1, 0, 0, 0], [0, 0, 0, 0]]}])").field, "path");
  EXPECT_EQ(error_of(R"([{"type": "pin", "region": {"cylinder": [0, 0, 0, 0, 0, 0, 1]}}])").field, "region.cylinder");
  EXPECT_EQ(error_of("{}").failure, Failure::kUsage);
  EXPECT_EQ(error_of("[").failure, Failure::kUsage);
}

}  // namespace
}  // namespace pliant

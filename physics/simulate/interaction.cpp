#include "physics/simulate/interaction.h"

#include <cmath>
#include <cstdio>

#include "gaussians/base/error.h"

namespace pliant {
namespace {

constexpr const char* kNames[] = {"gravity", "pin",      "point_force", "impulse", "grab", "gust",
                                  "ground",  "collider", "poke",        "torque",  "wind", "weight"};

}  // namespace

const char* interaction_name(InteractionType type) { return kNames[static_cast<int>(type)]; }

std::vector<std::string> interaction_names() { return {std::begin(kNames), std::end(kNames)}; }

void validate_interaction(const Interaction& interaction, size_t index) {
  const std::string where = "interaction " + std::to_string(index) + " (" + interaction_name(interaction.type) + ")";
  const auto require = [&](bool good, const char* field, double value, const char* remedy) {
    if (!good) throw usage_error(where, field, "is " + std::to_string(value), remedy);
  };
  const auto non_negative = [&](const char* field, double value, bool may_be_infinite) {
    require(value >= 0 && (may_be_infinite || std::isfinite(value)), field, value,
            "give a number that is not negative");
  };
  const auto finite = [&](const char* field, const Vec3d& value) {
    for (int a = 0; a < 3; ++a) require(std::isfinite(value[a]), field, value[a], "give three finite numbers");
  };
  non_negative("start", interaction.start, false);
  non_negative("duration", interaction.duration, true);
  finite("vector", interaction.vector);
  non_negative("stiffness", interaction.stiffness, false);
  non_negative("damping", interaction.damping, false);
  non_negative("max_force", interaction.max_force, true);
  non_negative("rate", interaction.rate, false);
  non_negative("drag_coefficient", interaction.drag_coefficient, false);
  non_negative("air_density", interaction.air_density, false);
  non_negative("friction", interaction.friction, true);
  finite("angular_velocity", interaction.angular_velocity);
  finite("pivot", interaction.pivot);

  const Region& region = interaction.region;
  switch (region.kind) {
    case Region::Kind::kAll:
      break;
    case Region::Kind::kSphere:
      finite("region", region.point);
      require(region.radius > 0 && std::isfinite(region.radius), "radius", region.radius, "give a positive radius");
      break;
    case Region::Kind::kBox:
      for (int a = 0; a < 3; ++a)
        require(region.point[a] < region.vector[a], "region", region.point[a],
                "the low corner must lie below the high one");
      break;
    case Region::Kind::kHalfSpace:
      finite("region", region.point);
      require(region.vector.norm() > 0 && region.vector.allFinite(), "normal", region.vector.norm(),
              "give a normal that is not zero");
      break;
    case Region::Kind::kCylinder:
      finite("region", region.point);
      finite("region", region.vector);
      require(region.radius > 0 && std::isfinite(region.radius), "radius", region.radius, "give a positive radius");
      require((region.vector - region.point).norm() > 0, "region", 0, "the ends of the cylinder must differ");
      break;
  }
  if (interaction.type == InteractionType::kGround && region.kind != Region::Kind::kHalfSpace)
    throw usage_error(where, "region", "is not a plane", "give a point and a normal");
  if (interaction.type == InteractionType::kCollider && region.kind == Region::Kind::kAll && !interaction.distance)
    throw usage_error(where, "region", "is everything", "give the shape of the collider");
  if (interaction.type == InteractionType::kWeight) {
    require(interaction.mass > 0 && std::isfinite(interaction.mass), "mass", interaction.mass, "give kilograms");
    require(interaction.start == 0, "start", interaction.start, "a weight hangs from the beginning on: leave it out");
    require(std::isinf(interaction.duration), "duration", interaction.duration,
            "a weight hangs to the end: leave it out, or use point_force for a load that ends");
  }
  if (interaction.type == InteractionType::kPoke && region.kind != Region::Kind::kSphere)
    throw usage_error(where, "radius", "is missing", "give the radius of the probe");
  const bool needs_path = interaction.type == InteractionType::kGrab || interaction.type == InteractionType::kPoke;
  if (needs_path && interaction.path.empty()) throw usage_error(where, "path", "is empty", "give time-stamped points");
  double last = -1;
  for (const auto& point : interaction.path) {
    require(std::isfinite(point.time) && point.time >= 0 && point.time > last, "path", point.time,
            "times must be finite, not negative and ascending");
    finite("path", point.position);
    last = point.time;
  }
}

std::string why_idle(const Interaction& interaction, double seconds) {
  char line[128] = "";
  if (interaction.start > (1 - 1e-9) * seconds)
    std::snprintf(line, sizeof line, "it starts at %.6g s, and the clip ends at %.6g s", interaction.start, seconds);
  else if (interaction.duration == 0 && interaction.type != InteractionType::kImpulse)
    std::snprintf(line, sizeof line, "it starts at %.6g s and lasts 0 s", interaction.start);
  return line;
}

}  // namespace pliant

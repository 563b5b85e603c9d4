#include "app/import/physgaussian_boundary.h"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/import/physgaussian_keys.h"
#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"

namespace pliant {
namespace {

using Boundary = PhysGaussianConfig::Boundary;
using BoundaryType = PhysGaussianConfig::BoundaryType;

struct BoundaryForm {
  BoundaryType type;
  std::vector<std::string> needed, optional;
};
const std::map<std::string, BoundaryForm>& boundary_forms() {
  static const std::map<std::string, BoundaryForm> forms = {
      {"cuboid", {BoundaryType::kCuboid, {"point", "size", "velocity"}, {"start_time", "end_time", "reset"}}},
      {"particle_impulse", {BoundaryType::kImpulse, {"force"}, {"num_dt", "start_time", "point", "size"}}},
      {"bounding_box", {BoundaryType::kBoundingBox, {}, {"start_time", "end_time"}}},
      {"enforce_particle_translation",
       {BoundaryType::kTranslation, {"point", "size", "velocity"}, {"start_time", "end_time"}}},
      {"enforce_particle_velocity_rotation",
       {BoundaryType::kRotation,
        {"point", "normal", "half_height_and_radius", "rotation_scale", "translation_scale"},
        {"start_time", "end_time"}}},
      {"surface_collider",
       {BoundaryType::kSurface, {"point", "normal"}, {"surface", "friction", "start_time", "end_time"}}},
      {"release_particles_sequentially",
       {BoundaryType::kReleaseSequentially,
        {"normal", "start_position", "end_position"},
        {"num_layers", "start_time", "end_time"}}}};
  return forms;
}

/// Layers lie across one axis, along which positions count, and have a thickness.
void check_layers(const JsonObject& object, const Boundary& b) {
  if (b.normal.cwiseAbs().maxCoeff() < 1)
    throw object.complaint("normal", "lies between the axes", "give an axis, such as [0, 0, 1]");
  if (b.start_position == b.end_position)
    throw object.complaint("end_position", "is the start_position", "give two different positions");
}

}  // namespace

PhysGaussianConfig::Boundary read_physgaussian_boundary(const JsonObject& object, const nlohmann::json& row) {
  std::vector<std::string> names;
  for (const auto& [name, form] : boundary_forms()) names.push_back(name);
  const std::string type = object.text("type");
  const auto found = boundary_forms().find(type);
  if (found == boundary_forms().end())
    throw object.complaint("type", "'" + type + "' is unknown", "did you mean '" + nearest_name(type, names) + "'?");
  const BoundaryForm& form = found->second;
  std::vector<std::string> known = {"type"};
  known.insert(known.end(), form.needed.begin(), form.needed.end());
  known.insert(known.end(), form.optional.begin(), form.optional.end());
  object.refuse_unknown(known);
  for (const std::string& key : form.needed)
    if (!object.has(key)) throw object.complaint(key, "is missing", "a boundary condition '" + type + "' needs it");

  const PhysGaussianKeys keys(object);
  Boundary b;
  b.type = form.type;
  keys.number("start_time", b.start, 0);
  keys.number("end_time", b.end, b.start);
  keys.vector("point", b.point);
  keys.half_extent("size", b.half);
  keys.vector("velocity", b.velocity);
  keys.vector("force", b.force);
  keys.flag("reset", b.reset, row);
  keys.whole("num_dt", b.num_dt, 1, 1 << 30);
  keys.whole("num_layers", b.num_layers, 1, 1 << 20);
  if (object.has("normal")) {
    keys.vector("normal", b.normal);
    if (!(b.normal.norm() > 0)) throw object.complaint("normal", "has no length", "give a direction such as [0, 0, 1]");
    b.normal.normalize();
  }
  if (object.has("surface")) {
    b.surface = object.text("surface");
    const std::vector<std::string> surfaces = {"sticky", "slip", "separate", "cut"};
    // PhysGaussian takes every other word for a separating surface.
    if (std::find(surfaces.begin(), surfaces.end(), b.surface) == surfaces.end()) b.surface = "separate";
  }
  keys.number("friction", b.friction, 0);
  if (b.type == BoundaryType::kSurface && b.surface == "sticky" && b.friction > 0)
    throw object.complaint("friction", "is " + std::to_string(b.friction) + " on a sticky surface",
                           "leave it out, or give surface 'separate'");
  if (object.has("half_height_and_radius")) {
    const std::vector<double> v = object.numbers("half_height_and_radius", 2);
    b.half_height = v[0];
    b.radius = v[1];
    if (!(v[0] > 0 && v[1] > 0))
      throw object.complaint("half_height_and_radius", "is not positive", "give [half height, radius]");
  }
  keys.number("rotation_scale", b.rotation);
  keys.number("translation_scale", b.translation);
  keys.number("start_position", b.start_position);
  keys.number("end_position", b.end_position);
  if (b.type == BoundaryType::kReleaseSequentially) check_layers(object, b);
  return b;
}

}  // namespace pliant

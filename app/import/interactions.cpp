#include "app/import/interactions.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"

namespace pliant {
using nlohmann::json;

namespace {

std::vector<double> numbers(const json& value, size_t count, const std::string& where, const std::string& field) {
  bool good = value.is_array() && value.size() == count;
  for (size_t i = 0; good && i < count; ++i) good = value[i].is_number();
  if (!good) throw usage_error(where, field, "is " + value.dump(), fmt::format("give a list of {} numbers", count));
  return value.get<std::vector<double>>();
}

Vec3d vector_of(const json& value, const std::string& where, const std::string& field) {
  const std::vector<double> v = numbers(value, 3, where, field);
  return {v[0], v[1], v[2]};
}

double number(const json& row, const std::string& key, double otherwise, const std::string& where) {
  if (!row.contains(key)) return otherwise;
  if (!row[key].is_number()) throw usage_error(where, key, "is " + row[key].dump(), "give a number");
  return row[key].get<double>();
}

const json& required(const json& row, const std::string& key, const std::string& where) {
  if (!row.contains(key)) throw usage_error(where, key, "is missing", "add \"" + key + "\"");
  return row[key];
}

/// Keys that each type understands, besides type, start and duration.
const std::map<std::string, std::vector<std::string>>& keys_of_type() {
  static const std::map<std::string, std::vector<std::string>> keys = {
      {"gravity", {"acceleration"}},
      {"pin", {"region"}},
      {"point_force", {"region", "force"}},
      {"impulse", {"region", "impulse"}},
      {"grab", {"region", "path", "stiffness", "damping", "max_force"}},
      {"gust", {"region", "wind", "drag", "acceleration"}},
      {"ground", {"point", "normal", "friction"}},
      {"collider", {"region", "contact", "friction", "container", "velocity", "angular_velocity", "pivot", "path"}},
      {"poke", {"radius", "path", "friction"}},
      {"torque", {"region", "torque"}},
      {"wind", {"region", "wind", "drag_coefficient", "air_density"}},
      {"weight", {"region", "mass"}}};
  return keys;
}

void refuse_unknown_keys(const json& row, std::vector<std::string> known, const std::string& where) {
  known.insert(known.end(), {"type", "start", "duration"});
  for (const auto& [key, value] : row.items())
    if (std::find(known.begin(), known.end(), key) == known.end())
      throw usage_error(where, key, "is not a key of this type", "did you mean '" + nearest_name(key, known) + "'?");
}

std::vector<Interaction::PathPoint> parse_path(const json& path, double metres, const std::string& where) {
  if (!path.is_array() || path.empty())
    throw usage_error(where, "path", "is " + path.dump(), "give [[t, x, y, z], ...]");
  std::vector<Interaction::PathPoint> out;
  for (const json& point : path) {
    const std::vector<double> p = numbers(point, 4, where, "path");
    out.push_back({p[0], metres * Vec3d(p[1], p[2], p[3])});
  }
  return out;
}

ContactKind parse_contact(const json& value, const std::string& where) {
  const std::vector<std::string> names = {"sticky", "slip", "separating"};
  const std::string name = value.is_string() ? value.get<std::string>() : value.dump();
  const auto at = std::find(names.begin(), names.end(), name);
  if (at == names.end())
    throw usage_error(where, "contact", "'" + name + "' is unknown",
                      "did you mean '" + nearest_name(name, names) + "'?");
  return static_cast<ContactKind>(at - names.begin());
}

Interaction parse_row(const json& row, const InteractionFrame& frame, const std::string& where) {
  if (!row.is_object() || !row.contains("type") || !row["type"].is_string())
    throw usage_error(where, "type", "is missing",
                      "give one of " + fmt::format("{}", fmt::join(interaction_names(), ", ")));
  const std::string type = row["type"];
  const std::vector<std::string> names = interaction_names();
  const auto at = std::find(names.begin(), names.end(), type);
  if (at == names.end())
    throw usage_error(where, "type", "'" + type + "' is unknown", "did you mean '" + nearest_name(type, names) + "'?");
  refuse_unknown_keys(row, keys_of_type().at(type), where);

  Interaction out;
  out.type = static_cast<InteractionType>(at - names.begin());
  out.start = number(row, "start", 0, where);
  out.duration = number(row, "duration", INFINITY, where);
  const double metres = frame.metres_per_unit;
  if (row.contains("region")) out.region = parse_region(row["region"], frame, where).scaled(metres);
  switch (out.type) {
    case InteractionType::kGravity:
      out.vector = vector_of(required(row, "acceleration", where), where, "acceleration");
      break;
    case InteractionType::kPin:
      required(row, "region", where);
      break;
    case InteractionType::kPointForce:
      required(row, "region", where);
      out.vector = vector_of(required(row, "force", where), where, "force");
      break;
    case InteractionType::kImpulse:
      required(row, "region", where);
      out.vector = vector_of(required(row, "impulse", where), where, "impulse");
      if (row.contains("duration"))
        throw usage_error(where, "duration", "does nothing: an impulse acts at once",
                          "leave it out, or give a point_force");
      break;
    case InteractionType::kGrab: {
      required(row, "region", where);
      out.path = parse_path(required(row, "path", where), metres, where);
      out.stiffness = number(row, "stiffness", 0, where);
      out.damping = number(row, "damping", 0, where);
      out.max_force = number(row, "max_force", 0, where);
      break;
    }
    case InteractionType::kGust:
      if (row.contains("wind") == row.contains("acceleration"))
        throw usage_error(where, "wind", "needs exactly one of wind and acceleration",
                          "give \"wind\": [m/s] and \"drag\", or \"acceleration\": [m/s^2]");
      out.vector = row.contains("wind") ? vector_of(row["wind"], where, "wind")
                                        : vector_of(row["acceleration"], where, "acceleration");
      if (row.contains("acceleration") && row.contains("drag"))
        throw usage_error(where, "drag", "does nothing with acceleration",
                          "leave it out, or give \"wind\": [m/s] instead of acceleration");
      out.rate = row.contains("wind") ? number(row, "drag", 1.0, where) : 0.0;
      if (row.contains("wind") && !(out.rate > 0))
        throw usage_error(where, "drag", "is not positive", "give a rate in 1/s");
      break;
    case InteractionType::kGround: {
      const Vec3d point =
          row.contains("point") ? Vec3d(metres * vector_of(row["point"], where, "point")) : Vec3d::Zero();
      const Vec3d normal = row.contains("normal") ? vector_of(row["normal"], where, "normal") : frame.up;
      if (!(normal.norm() > 0))
        throw usage_error(where, "normal", "has no length", "give a direction such as [0, 0, 1]");
      out.region = Region::half_space(point, normal.normalized());
      out.friction = number(row, "friction", 0.5, where);
      break;
    }
    case InteractionType::kCollider:
      required(row, "region", where);
      out.contact = row.contains("contact") ? parse_contact(row["contact"], where) : ContactKind::kSeparating;
      if (out.contact != ContactKind::kSeparating && row.contains("friction"))
        throw usage_error(where, "friction", "does nothing where contact is " + row["contact"].get<std::string>(),
                          "leave it out, or give \"contact\": \"separating\"");
      out.friction = number(row, "friction", out.contact == ContactKind::kSeparating ? 0.5 : 0.0, where);
      if (row.contains("container")) {
        if (!row["container"].is_boolean())
          throw usage_error(where, "container", "is " + row["container"].dump(), "give true or false");
        out.container = row["container"].get<bool>();
      }
      if (row.contains("velocity") && row.contains("path"))
        throw usage_error(where, "path", "is given together with velocity", "give one of them");
      if (row.contains("velocity")) out.vector = vector_of(row["velocity"], where, "velocity");
      if (row.contains("angular_velocity"))
        out.angular_velocity = vector_of(row["angular_velocity"], where, "angular_velocity");
      if (row.contains("path")) {
        out.path = parse_path(row["path"], metres, where);
        out.pivot = out.path.front().position;
      } else if (out.region.bounded())
        out.pivot = out.region.middle();
      else if (!out.angular_velocity.isZero())
        required(row, "pivot", where);
      if (row.contains("pivot")) out.pivot = metres * vector_of(row["pivot"], where, "pivot");
      break;
    case InteractionType::kPoke:
      required(row, "radius", where);
      out.path = parse_path(required(row, "path", where), metres, where);
      out.region.kind = Region::Kind::kSphere;
      out.region.point = out.path.front().position;
      out.region.radius = metres * number(row, "radius", 0, where);
      out.friction = number(row, "friction", 0.5, where);
      break;
    case InteractionType::kTorque:
      required(row, "region", where);
      out.vector = vector_of(required(row, "torque", where), where, "torque");
      break;
    case InteractionType::kWind:
      out.vector = vector_of(required(row, "wind", where), where, "wind");
      out.drag_coefficient = number(row, "drag_coefficient", 1.0, where);
      out.air_density = number(row, "air_density", 1.2, where);
      break;
    case InteractionType::kWeight:
      required(row, "region", where);
      required(row, "mass", where);
      out.mass = number(row, "mass", 0, where);
      break;
  }
  return out;
}

}  // namespace

Region parse_region(const json& value, const InteractionFrame& frame, const std::string& where) {
  if (value == "all") return Region::all();
  if (!value.is_object() || value.size() != 1)
    throw usage_error(where, "region", "is " + value.dump(),
                      "give {\"sphere\": [x,y,z,r]}, {\"box\": [...]}, {\"below\": h}, {\"plane\": [...]}, "
                      "{\"cylinder\": [...]} or \"all\"");
  const std::string kind = value.begin().key();
  const json& data = value.begin().value();
  if (kind == "sphere") {
    const std::vector<double> s = numbers(data, 4, where, "region.sphere");
    if (!(s[3] > 0))
      throw usage_error(where, "region.sphere", "has radius " + std::to_string(s[3]), "give a positive radius");
    return Region::sphere({s[0], s[1], s[2]}, s[3]);
  }
  if (kind == "box") {
    const std::vector<double> b = numbers(data, 6, where, "region.box");
    for (int k = 0; k < 3; ++k)
      if (!(b[k] < b[k + 3]))
        throw usage_error(where, "region.box", data.dump() + " is empty", "give x0,y0,z0 below x1,y1,z1");
    return Region::box({b[0], b[1], b[2]}, {b[3], b[4], b[5]});
  }
  if (kind == "below") {
    if (!data.is_number()) throw usage_error(where, "region.below", "is " + data.dump(), "give a height along up");
    return Region::half_space(frame.up * data.get<double>(), frame.up);
  }
  if (kind == "plane") {
    const std::vector<double> p = numbers(data, 6, where, "region.plane");
    const Vec3d normal(p[3], p[4], p[5]);
    if (!(normal.norm() > 0))
      throw usage_error(where, "region.plane", "has a normal of no length", "give x,y,z of a point and of a normal");
    return Region::half_space({p[0], p[1], p[2]}, normal);
  }
  if (kind == "cylinder") {
    const std::vector<double> c = numbers(data, 7, where, "region.cylinder");
    const Vec3d end(c[0], c[1], c[2]), other(c[3], c[4], c[5]);
    if (!(c[6] > 0) || !((other - end).norm() > 0))
      throw usage_error(where, "region.cylinder", data.dump() + " is empty", "give the two ends and a positive radius");
    return Region::cylinder(end, other, c[6]);
  }
  throw usage_error(where, "region", "'" + kind + "' is unknown",
                    "did you mean '" + nearest_name(kind, {"sphere", "box", "below", "plane", "cylinder"}) + "'?");
}

json region_to_json(const Region& region) {
  const Vec3d& p = region.point;
  const Vec3d& v = region.vector;
  switch (region.kind) {
    case Region::Kind::kSphere:
      return {{"sphere", {p.x(), p.y(), p.z(), region.radius}}};
    case Region::Kind::kBox:
      return {{"box", {p.x(), p.y(), p.z(), v.x(), v.y(), v.z()}}};
    case Region::Kind::kHalfSpace:
      return {{"plane", {p.x(), p.y(), p.z(), v.x(), v.y(), v.z()}}};
    case Region::Kind::kCylinder:
      return {{"cylinder", {p.x(), p.y(), p.z(), v.x(), v.y(), v.z(), region.radius}}};
    case Region::Kind::kAll:
      break;
  }
  return "all";
}

std::vector<Interaction> parse_interactions(const std::string& text, const InteractionFrame& frame,
                                            const std::string& file) {
  const json rows = json::parse(text, nullptr, false);
  if (rows.is_discarded()) throw usage_error(file, "", "is not valid JSON", "write an array of {\"type\": ...}");
  if (rows.contains("physgaussian"))
    throw usage_error(file, "", "is of a run with --physgaussian, not an array of interactions",
                      "give the configuration of that run with --physgaussian instead");
  if (!rows.is_array()) throw usage_error(file, "", "is not an array", "write [{\"type\": ...}, ...]");
  std::vector<Interaction> out;
  for (size_t i = 0; i < rows.size(); ++i) {
    out.push_back(parse_row(rows[i], frame, fmt::format("{}[{}]", file, i)));
    validate_interaction(out.back(), i);
  }
  return out;
}

}  // namespace pliant

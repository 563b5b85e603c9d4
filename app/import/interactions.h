#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "physics/simulate/interaction.h"

namespace pliant {

/// What positions, radii and directions in an interaction file are measured in.
struct InteractionFrame {
  double metres_per_unit = 1;
  Vec3d up = {0, 0, 1};
};

/// Region from JSON: {"sphere": [x,y,z,r]}, {"box": [x0,y0,z0,x1,y1,z1]}, {"below": h} (height along up),
/// {"plane": [x,y,z,nx,ny,nz]} (what lies behind it), {"cylinder": [x0,y0,z0,x1,y1,z1,r]}, or "all"; in scene units.
/// `where` names the file and the row in messages.
Region parse_region(const nlohmann::json& value, const InteractionFrame& frame, const std::string& where);
nlohmann::json region_to_json(const Region& region);

/// interactions.json: an array of rows, in scene units and SI:
///   {type: gravity, acceleration: [m/s^2]}
///   {type: pin, region}
///   {type: point_force, region, force: [N], start, duration}
///   {type: impulse, region, impulse: [N s], start}
///   {type: grab, region, path: [[t, x, y, z], ...], start, duration, stiffness N/m, damping N s/m, max_force N}
///   {type: gust, region, wind: [m/s], drag 1/s | acceleration: [m/s^2], start, duration}
///   {type: ground, point, normal, friction}
///   {type: collider, region, contact: sticky|slip|separating, friction, container: matter is inside the shape,
///    velocity: [m/s] | path of `pivot`, angular_velocity: [rad/s] about `pivot` (default: the start of the path, else
///    the middle of the region; a plane needs one), start, duration}
///   {type: poke, radius, path of the finger's centre, friction, start}
///   {type: torque, region, torque: [N m] about the centre of the touched mass, start, duration}
///   {type: wind, wind: [m/s], region, drag_coefficient, air_density kg/m^3, start, duration}
/// Positions come back in metres.  Unknown types and keys are usage errors with the nearest known name.
std::vector<Interaction> parse_interactions(const std::string& text, const InteractionFrame& frame,
                                            const std::string& file);

}  // namespace pliant

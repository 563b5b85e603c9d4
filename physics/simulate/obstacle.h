#pragma once

#include <vector>

#include "physics/loads/collider.h"
#include "physics/simulate/interaction.h"

namespace pliant {

/// Whether nothing passes through it: a ground, a collider or a finger.
bool is_obstacle(InteractionType type);

/// Such an interaction at time t [s], with the velocity that takes it to its place at t + dt.
Collider obstacle_at(const Interaction& interaction, double t, double dt);

/// Adds what the grid sees of it to `colliders`: itself, or the six walls of a box with the matter inside.
void add_obstacle(Collider obstacle, std::vector<Collider>& colliders);

/// Speed [m/s] during [t, t + dt] of its fastest point near a body of this size [m] about `middle` at rest.
double obstacle_speed(const Interaction& interaction, double t, double dt, const Vec3d& body_middle, double body_size);

/// Distance [m] of x from a path, whose points are joined by straight lines; infinite where it has no points.
double distance_to_path(const std::vector<Interaction::PathPoint>& path, const Vec3d& x);

}  // namespace pliant

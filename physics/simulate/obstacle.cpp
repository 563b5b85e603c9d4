#include "physics/simulate/obstacle.h"

#include <algorithm>
#include <cmath>

#include "physics/simulate/grab_spring.h"

namespace pliant {

bool is_obstacle(InteractionType type) {
  return type == InteractionType::kGround || type == InteractionType::kCollider || type == InteractionType::kPoke;
}

Collider obstacle_at(const Interaction& it, double t, double dt) {
  Collider collider;
  collider.kind = it.contact;
  collider.friction = it.friction;
  collider.container = it.container;
  collider.shape = it.region;
  collider.grid = it.distance;
  if (it.type == InteractionType::kGround) return collider;
  Vec3d pivot = it.pivot;
  if (it.type == InteractionType::kPoke) collider.shape.point = pivot = it.path.front().position;
  const double now = t - it.start, next = now + dt;
  Vec3d way = now * it.vector;
  collider.velocity = it.vector;
  if (!it.path.empty()) {
    way = path_position(it.path, now) - pivot;
    collider.velocity = (path_position(it.path, next) - path_position(it.path, now)) / dt;
  }
  collider.angular_velocity = it.angular_velocity;
  collider.move(pivot, way, now);
  return collider;
}

/// The inside of a box is bounded by six walls, each with a normal of its own: its corners hold as well.
void add_obstacle(Collider collider, std::vector<Collider>& colliders) {
  if (!collider.container || collider.grid || collider.shape.kind != Region::Kind::kBox) {
    colliders.push_back(collider);
    return;
  }
  const Region box = collider.shape;
  collider.container = false;
  for (int a = 0; a < 3; ++a) {
    collider.shape = Region::half_space(box.point, Vec3d::Unit(a));
    colliders.push_back(collider);
    collider.shape = Region::half_space(box.vector, -Vec3d::Unit(a));
    colliders.push_back(collider);
  }
}

double obstacle_speed(const Interaction& it, double t, double dt, const Vec3d& body_middle, double body_size) {
  double speed = it.vector.norm();
  for (size_t k = 1; k < it.path.size(); ++k) {
    if (it.start + it.path[k].time < t || it.start + it.path[k - 1].time > t + dt) continue;
    speed = std::max(speed,
                     (it.path[k].position - it.path[k - 1].position).norm() / (it.path[k].time - it.path[k - 1].time));
  }
  const double spin = it.angular_velocity.norm();
  if (spin > 0) {
    // The farthest from the pivot of what is both in the collider, as far as it is bounded, and near the body.
    const Vec3d moved =
        it.path.empty() ? Vec3d((t - it.start) * it.vector) : Vec3d(path_position(it.path, t - it.start) - it.pivot);
    const double own = it.distance ? INFINITY : it.region.farthest(it.pivot);
    speed += spin * std::min(own, (it.pivot + moved - body_middle).norm() + body_size);
  }
  return speed;
}

double distance_to_path(const std::vector<Interaction::PathPoint>& path, const Vec3d& x) {
  double nearest = INFINITY;
  for (size_t k = 0; k < path.size(); ++k) {
    const Vec3d from = path[k].position, way = path[std::min(k + 1, path.size() - 1)].position - from;
    const double s = way.squaredNorm() > 0 ? std::clamp((x - from).dot(way) / way.squaredNorm(), 0.0, 1.0) : 0.0;
    nearest = std::min(nearest, (x - from - s * way).norm());
  }
  return nearest;
}

}  // namespace pliant

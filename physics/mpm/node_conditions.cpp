#include "physics/mpm/node_conditions.h"

#include <algorithm>
#include <cmath>

namespace pliant {
namespace {

constexpr double kTolerance = 1e-3;  // cells; a node on the surface counts as inside
// Cells between the surfaces at which contact starts, which allows for edges and for the body's own compression.
constexpr double kGap = 0.25;
constexpr double kHeldShare = 0.25;  // of what hangs on a node at first contact, down to which it sticks or slips
constexpr double kReachOfBlock = 0.5 * (BlockGrid::kSide - 1) * 1.7320508075688772;  // cells from its middle

template <class T>
Vec3d middle(const NodeBlock<T>& block) {
  return block.first + Vec3d::Constant(0.5 * (BlockGrid::kSide - 1) * block.dx);
}

/// Around all nodes of a block, where they are now.
struct Ball {
  Vec3d centre;
  double radius;
};
template <class T>
Ball ball_around(const NodeBlock<T>& block) {
  Ball ball{middle(block), kReachOfBlock * block.dx};
  if (!block.displacement) return ball;
  if (block.low) {
    const Vec3d low(block.low[0], block.low[1], block.low[2]), high(block.high[0], block.high[1], block.high[2]);
    ball.centre += 0.5 * (low + high);
    ball.radius += 0.5 * (high - low).norm();
    return ball;
  }
  ball.centre.setZero();
  for (int k = 0; k < BlockGrid::kNodes; ++k) ball.centre += block.position(k) / BlockGrid::kNodes;
  ball.radius = 0;
  for (int k = 0; k < BlockGrid::kNodes; ++k)
    ball.radius = std::max(ball.radius, (block.position(k) - ball.centre).norm());
  return ball;
}

/// Cells outside the surface up to which nodes are held.
double reach(const Collider& collider) { return collider.kind == ContactKind::kSeparating ? kTolerance : kPinReach; }

/// Calls visit(k, normal, velocity of the surface) for the nodes that the collider holds or pushes.
template <class T, class Visit>
void for_touched_nodes(const StepLoads<T>& loads, const NodeBlock<T>& block, const Collider& collider, Visit&& visit) {
  const double dx = block.dx;
  if (block.low && block.low[0] > block.high[0]) return;  // no node has mass
  const Ball ball = ball_around(block);
  if (collider.surface(ball.centre).distance > reach(collider) * dx + ball.radius) return;
  const size_t object = static_cast<size_t>(block.object);
  const double full = object < loads.density.size() ? loads.density[object] * dx * dx * dx : 0;
  const double share = collider.kind == ContactKind::kSeparating ? 1 : kHeldShare;
  for (int k = 0; k < BlockGrid::kNodes; ++k) {
    const double mass = block.node[k].lane[3];
    if (!(mass > 0)) continue;
    const Vec3d x = block.position(k);
    const SignedDistanceGrid::Sample at = collider.surface(x);
    if (at.distance > reach(collider) * dx) continue;
    if (block.filled || full > 0) {
      // What could hang on the node at first contact; where two walls meet, a quarter of a node is room.
      double room = 1;
      for (const Collider& other : loads.colliders) room *= filled_share(other.surface(x).distance / dx - kGap);
      if ((block.filled ? block.filled[k] : mass / full) < share * room) continue;
    }
    visit(k, at.normal, collider.velocity_at(x));
  }
}

template <class T, class Visit>
void for_pinned_nodes(const NodeBlock<T>& block, const Pin& pin, Visit&& visit) {
  const double reach = kPinReach * block.dx, half = kReachOfBlock * block.dx;
  const double distance = pin.signed_distance(middle(block));
  if (distance - half > reach) return;
  const bool whole = distance + half <= reach;
  for (int k = 0; k < BlockGrid::kNodes; ++k)
    if (whole || pin.signed_distance(block.rest_position(k)) <= reach) visit(k);
}

}  // namespace

double filled_share(double distance) {
  // Integral of the quadratic B-spline from -distance to infinity.
  const double s = std::abs(distance);
  const double beyond = s >= 1.5   ? 0.0
                        : s >= 0.5 ? (1.5 - s) * (1.5 - s) * (1.5 - s) / 6
                                   : 0.5 - s * (0.75 - s * s / 3);
  return distance > 0 ? 1 - beyond : beyond;
}

template <class T>
void apply_node_conditions(const StepLoads<T>& loads, const NodeBlock<T>& block, Vec3d* impulse) {
  for (size_t c = 0; c < loads.colliders.size(); ++c) {
    const Collider& collider = loads.colliders[c];
    for_touched_nodes(loads, block, collider, [&](int k, const Vec3d& normal, const Vec3d& w) {
      const Vec3d v = velocity_of(block.node[k]), after = velocity_after_contact(collider, normal, w, v);
      set_velocity(block.node[k], after);
      if (impulse) impulse[c] += block.node[k].lane[3] * (after - v);
    });
  }
  for (size_t p = 0; p < loads.pins.size(); ++p) {
    for_pinned_nodes(block, loads.pins[p], [&](int k) {
      if (impulse) impulse[loads.colliders.size() + p] -= block.node[k].lane[3] * velocity_of(block.node[k]);
      set_velocity(block.node[k], Vec3d::Zero());
    });
  }
}

template <class T>
void apply_node_conditions_adjoint(const StepLoads<T>& loads, const NodeBlock<T>& block, Node<T>* adj,
                                   Vec3<T>* by_displacement) {
  for (const Pin& pin : loads.pins) for_pinned_nodes(block, pin, [&](int k) { set_velocity(adj[k], Vec3d::Zero()); });
  // The velocities that each collider met, then backwards through them.
  std::vector<std::array<Node<T>, BlockGrid::kNodes>> met(loads.colliders.size());
  std::array<Node<T>, BlockGrid::kNodes> now;
  std::copy_n(block.node, BlockGrid::kNodes, now.begin());
  const NodeBlock<T> moving{now.data(), block.first, block.dx, block.object, block.displacement, block.filled};
  for (size_t c = 0; c < met.size(); ++c) {
    const Collider& collider = loads.colliders[c];
    met[c] = now;
    for_touched_nodes(loads, moving, collider, [&](int k, const Vec3d& normal, const Vec3d& w) {
      set_velocity(now[k], velocity_after_contact(collider, normal, w, velocity_of(now[k])));
    });
  }
  for (size_t c = met.size(); c-- > 0;) {
    const Collider& collider = loads.colliders[c];
    for_touched_nodes(loads, moving, collider, [&](int k, const Vec3d& normal, const Vec3d& w) {
      const SurfaceContactGradient by =
          velocity_after_contact_adjoint(collider, normal, w, velocity_of(met[c][k]), velocity_of(adj[k]));
      set_velocity(adj[k], by.v);
      if (by_displacement)
        by_displacement[k] += collider.surface_adjoint(block.position(k), by.normal, by.w).template cast<T>();
    });
  }
}

template void apply_node_conditions(const StepLoads<float>&, const NodeBlock<float>&, Vec3d*);
template void apply_node_conditions(const StepLoads<double>&, const NodeBlock<double>&, Vec3d*);
template void apply_node_conditions_adjoint(const StepLoads<float>&, const NodeBlock<float>&, Node<float>*,
                                            Vec3<float>*);
template void apply_node_conditions_adjoint(const StepLoads<double>&, const NodeBlock<double>&, Node<double>*,
                                            Vec3<double>*);

}  // namespace pliant

#include "physics/mpm/node_update_adjoint.h"

#include <algorithm>
#include <array>

#include "physics/laws/pack.h"

namespace pliant {
namespace {

/// Coulomb's law on one plane backwards: v before, g by v after; returns g by v before.
Vec3d reverse_ground(const GroundPlane& plane, const Vec3d& v, const Vec3d& g) {
  const double approach = -v.dot(plane.normal);
  if (!(approach > 0)) return g;
  const Vec3d slide = v + approach * plane.normal;
  const double speed = slide.norm();
  const double kept = speed > 0 ? 1 - plane.friction * approach / speed : 0.0;
  if (!(kept > 0)) return Vec3d::Zero();
  const double by_kept = g.dot(slide);
  const Vec3d by_slide = kept * g + (by_kept * plane.friction * approach / (speed * speed * speed)) * slide;
  const double by_approach = by_slide.dot(plane.normal) - by_kept * plane.friction / speed;
  return by_slide - by_approach * plane.normal;
}

Vec3d after_ground(const GroundPlane& plane, const Vec3d& v) {
  const double approach = -v.dot(plane.normal);
  if (!(approach > 0)) return v;
  const Vec3d slide = v + approach * plane.normal;
  const double speed = slide.norm();
  return (speed > 0 ? std::max(0.0, 1 - plane.friction * approach / speed) : 0.0) * slide;
}

/// The conditions of `apply_node_conditions` backwards, given the velocities before them.
template <class T>
void reverse_node_conditions(const StepLoads<T>& loads, const Node<T>* before, const NodeBlock<T>& adj) {
  if (loads.grounds.empty() && loads.pins.empty()) return;
  for (int k = 0; k < BlockGrid::kNodes; ++k) {
    T* g = adj.node[k].lane;
    const Vec3d x = adj.position(k);
    const bool pinned = std::any_of(loads.pins.begin(), loads.pins.end(), [&](const Region& pin) {
      return pin.signed_distance(x) <= kPinReach * adj.dx;
    });
    if (pinned) {
      g[0] = g[1] = g[2] = 0;
      continue;
    }
    Vec3d v(before[k].lane[0], before[k].lane[1], before[k].lane[2]), gradient(g[0], g[1], g[2]);
    std::array<std::pair<const GroundPlane*, Vec3d>, 8> met;
    size_t count = 0;
    for (const GroundPlane& plane : loads.grounds) {
      if ((x - plane.point).dot(plane.normal) > 1e-3 * adj.dx || count == met.size()) continue;
      met[count++] = {&plane, v};
      v = after_ground(plane, v);
    }
    while (count-- > 0) gradient = reverse_ground(*met[count].first, met[count].second, gradient);
    for (int a = 0; a < 3; ++a) g[a] = static_cast<T>(gradient[a]);
  }
}

}  // namespace

template <class T>
void node_velocities(T dt, const StepLoads<T>& loads, const Node<T>* sums, Node<T>* velocity) {
  const Pack<T> fall = {dt * loads.gravity[0], dt * loads.gravity[1], dt * loads.gravity[2], 0};
  for (int k = 0; k < BlockGrid::kNodes; ++k) {
    const T mass = sums[k].lane[3];
    velocity[k] = sums[k];
    if (!(mass > T(0))) continue;
    Pack<T>& v = reinterpret_cast<Pack<T>&>(velocity[k].lane);
    v = (v * (1 / mass) + fall) * loads.velocity_scale;
    velocity[k].lane[3] = mass;
  }
}

template <class T>
void reverse_node_update(T dt, const StepLoads<T>& loads, const NodeBlock<T>& adj, const Node<T>* sums,
                         StepLoadsGradient& by_loads) {
  if (!loads.grounds.empty() || !loads.pins.empty()) {
    Node<T> before[BlockGrid::kNodes];
    node_velocities(dt, loads, sums, before);
    reverse_node_conditions(loads, before, adj);
  }
  const T scale = loads.velocity_scale;
  Vec3d by_gravity = Vec3d::Zero();
  double by_scale = 0;
  for (int k = 0; k < BlockGrid::kNodes; ++k) {
    const T mass = sums[k].lane[3];
    T* g = adj.node[k].lane;
    if (!(mass > T(0))) {
      g[0] = g[1] = g[2] = g[3] = 0;
      continue;
    }
    const T inverse = 1 / mass;
    T by_mass = 0;
    for (int a = 0; a < 3; ++a) {
      const T v = sums[k].lane[a] * inverse;
      by_scale += g[a] * (v + dt * loads.gravity[a]);
      g[a] *= scale;
      by_gravity[a] += g[a];
      g[a] *= inverse;
      by_mass -= g[a] * v;
    }
    g[3] = by_mass;
  }
  by_loads.gravity += static_cast<double>(dt) * by_gravity;
  by_loads.velocity_scale += by_scale;
}

template void node_velocities(float, const StepLoads<float>&, const Node<float>*, Node<float>*);
template void node_velocities(double, const StepLoads<double>&, const Node<double>*, Node<double>*);
template void reverse_node_update(float, const StepLoads<float>&, const NodeBlock<float>&, const Node<float>*,
                                  StepLoadsGradient&);
template void reverse_node_update(double, const StepLoads<double>&, const NodeBlock<double>&, const Node<double>*,
                                  StepLoadsGradient&);

}  // namespace pliant

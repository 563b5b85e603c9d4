#include "physics/mpm/node_conditions.h"

#include <algorithm>

namespace pliant {

template <class T>
void apply_node_conditions(const StepLoads<T>& loads, const NodeBlock<T>& block) {
  if (loads.grounds.empty() && loads.pins.empty()) return;
  constexpr int kSide = BlockGrid::kSide;
  const double dx = block.dx, half = 0.5 * (kSide - 1) * dx * 1.7320508075688772;
  const Vec3d middle = block.first + Vec3d::Constant(0.5 * (kSide - 1) * dx);

  for (const GroundPlane& plane : loads.grounds) {
    const double tolerance = 1e-3 * dx;
    if ((middle - plane.point).dot(plane.normal) - half > tolerance) continue;
    for (int k = 0; k < BlockGrid::kNodes; ++k) {
      if ((block.position(k) - plane.point).dot(plane.normal) > tolerance) continue;
      T* v = block.node[k].lane;
      const Vec3d velocity(v[0], v[1], v[2]);
      const double approach = -velocity.dot(plane.normal);
      if (!(approach > 0)) continue;
      const Vec3d slide = velocity + approach * plane.normal;
      const double speed = slide.norm();
      const double kept = speed > 0 ? std::max(0.0, 1 - plane.friction * approach / speed) : 0.0;
      for (int a = 0; a < 3; ++a) v[a] = static_cast<T>(kept * slide[a]);
    }
  }
  for (const Region& pin : loads.pins) {
    const double reach = kPinReach * dx, distance = pin.signed_distance(middle);
    if (distance - half > reach) continue;
    const bool whole = distance + half <= reach;
    for (int k = 0; k < BlockGrid::kNodes; ++k) {
      T* v = block.node[k].lane;
      if (whole || pin.signed_distance(block.position(k)) <= reach) v[0] = v[1] = v[2] = 0;
    }
  }
}

template void apply_node_conditions(const StepLoads<float>&, const NodeBlock<float>&);
template void apply_node_conditions(const StepLoads<double>&, const NodeBlock<double>&);

}  // namespace pliant

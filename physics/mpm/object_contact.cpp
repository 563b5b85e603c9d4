#include "physics/mpm/object_contact.h"

#include <algorithm>
#include <cmath>

namespace pliant {
namespace {

constexpr int kSide = BlockGrid::kSide;
constexpr double kFullShare = 0.85;  // of a node's space that two touching bodies fill together

/// What both directions of `exchange_impulse` compute from a pair.
struct Meeting {
  Vec3d normal, relative, along;  // from body 0 to body 1; v0 - v1; its part across the normal
  double steepness, approach, sliding, reduced_mass;
  double across;  // impulse across the normal per `along`, 0 .. reduced_mass
  bool sticks;

  bool touching() const { return steepness > 0 && approach > 0; }
  Meeting(double friction, const NodePair& pair) {
    const Vec3d g = pair.gradient[1] - pair.gradient[0];
    steepness = g.norm();
    normal = steepness > 0 ? Vec3d(g / steepness) : Vec3d::Zero();
    relative = pair.velocity[0] - pair.velocity[1];
    approach = relative.dot(normal);
    along = relative - approach * normal;
    sliding = along.norm();
    reduced_mass = pair.mass[0] * pair.mass[1] / (pair.mass[0] + pair.mass[1]);
    sticks = !(friction * approach < sliding);
    across = sticks ? reduced_mass : reduced_mass * friction * approach / sliding;
  }
};

}  // namespace

void exchange_impulse(double friction, NodePair& pair) {
  const Meeting meet(friction, pair);
  if (!meet.touching()) return;
  const Vec3d impulse = meet.reduced_mass * meet.approach * meet.normal + meet.across * meet.along;
  pair.velocity[0] -= impulse / pair.mass[0];
  pair.velocity[1] += impulse / pair.mass[1];
}

void exchange_impulse_adjoint(double friction, const NodePair& pair, NodePair& adj) {
  const Meeting meet(friction, pair);
  if (!meet.touching()) return;
  const double m0 = pair.mass[0], m1 = pair.mass[1], total = m0 + m1;
  // v0' = v0 - J / m0, v1' = v1 + J / m1 with J = m (a n + s t): m reduced mass, a approach, t along; s = 1 when they
  // stick, else mu a / |t|.
  const double s = meet.across / meet.reduced_mass;
  const Vec3d unit_impulse = meet.approach * meet.normal + s * meet.along, impulse = meet.reduced_mass * unit_impulse;
  const Vec3d adj_impulse = adj.velocity[1] / m1 - adj.velocity[0] / m0;
  adj.mass[0] = adj.velocity[0].dot(impulse) / (m0 * m0);
  adj.mass[1] = -adj.velocity[1].dot(impulse) / (m1 * m1);
  const double adj_reduced = adj_impulse.dot(unit_impulse);
  adj.mass[0] += adj_reduced * m1 * m1 / (total * total);
  adj.mass[1] += adj_reduced * m0 * m0 / (total * total);
  const Vec3d adj_unit = meet.reduced_mass * adj_impulse;
  double adj_approach = adj_unit.dot(meet.normal);
  Vec3d adj_normal = meet.approach * adj_unit, adj_along = s * adj_unit;
  if (!meet.sticks) {
    const double adj_s = adj_unit.dot(meet.along);
    adj_approach += adj_s * friction / meet.sliding;
    adj_along -= adj_s * s / (meet.sliding * meet.sliding) * meet.along;
  }
  // t = u - a n, a = u . n
  Vec3d adj_relative = adj_along;
  adj_approach -= adj_along.dot(meet.normal);
  adj_normal -= meet.approach * adj_along;
  adj_relative += adj_approach * meet.normal;
  adj_normal += adj_approach * meet.relative;
  adj.velocity[0] += adj_relative;
  adj.velocity[1] -= adj_relative;
  const Vec3d adj_g = (adj_normal - adj_normal.dot(meet.normal) * meet.normal) / meet.steepness;
  adj.gradient[1] = adj_g, adj.gradient[0] = -adj_g;
}

namespace {

/// Slope of the share of a node's space that a half space fills, per cell, where that share is `share`; see
/// `filled_share`.
double flat_slope(double share) {
  const double s = std::min(share, 1 - share);
  if (!(s > 0)) return 0;
  if (s < 1.0 / 6) return 0.5 * std::cbrt(36 * s * s);
  double distance = (0.5 - s) / 0.75;
  distance = (0.5 - s + distance * distance * distance / 3) / 0.75;
  return 0.75 - distance * distance;
}

/// The gradient of a body's share, weighted down where the body has an edge or corner: there the slope is less than
/// that of a flat face, and the other body, if it is flat, knows the normal better.
Vec3d trusted(const Vec3d& gradient, double share) {
  const double slope = gradient.norm(), flat = flat_slope(share);
  if (!(slope > 0) || !(flat > 0)) return gradient;
  return std::pow(std::min(1.0, slope / flat), 16) * gradient;
}

/// Masses of one object's nodes in a block and one node around it.
template <class T>
class MassPatch {
 public:
  MassPatch(const MpmData<T>& data, int n) {
    const BlockGrid::Coordinates& at = data.grid.node_block(n);
    for (int o = 0; o < 27; ++o) {
      const int d[3] = {o / 9 - 1, o / 3 % 3 - 1, o % 3 - 1};
      const int neighbour = data.grid.find_node_block({at.x + d[0], at.y + d[1], at.z + d[2], at.object});
      block_[o] = neighbour < 0 ? nullptr : data.node.data() + static_cast<size_t>(neighbour) * BlockGrid::kNodes;
    }
    block_[13] = data.node.data() + static_cast<size_t>(n) * BlockGrid::kNodes;
  }
  /// Of node (i, j, k), one of which may lie one outside of 0 .. 3.
  double at(int i, int j, int k) const {
    const int o = ((i + kSide) / kSide * 3 + (j + kSide) / kSide) * 3 + (k + kSide) / kSide;
    const Node<T>* block = block_[o];
    return block ? block[((i & 3) * kSide + (j & 3)) * kSide + (k & 3)].lane[3] : 0.0;
  }
  /// Of the node's mass, per cell; averaged across, or the places of single particles would make a surface bumpy.
  Vec3d gradient(int k) const {
    const int x = k / (kSide * kSide), y = k / kSide % kSide, z = k % kSide;
    constexpr double kAcross[3] = {0.25, 0.5, 0.25}, kAlong[3] = {-0.5, 0, 0.5};
    Vec3d sum = Vec3d::Zero();
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b)
        for (int c = 0; c < 3; ++c)
          sum += at(x + a - 1, y + b - 1, z + c - 1) * Vec3d(kAlong[a] * kAcross[b] * kAcross[c],
                                                             kAcross[a] * kAlong[b] * kAcross[c],
                                                             kAcross[a] * kAcross[b] * kAlong[c]);
    return sum;
  }

 private:
  const Node<T>* block_[27] = {};
};

}  // namespace

template <class T>
void apply_object_contact(const StepLoads<T>& loads, MpmData<T>& data, int n) {
  std::vector<int> ring = {n};
  for (int s = data.grid.sibling(n); s != n; s = data.grid.sibling(s)) {
    if (s < n) return;
    ring.push_back(s);
  }
  if (ring.size() < 2) return;
  const auto object = [&](int s) { return data.grid.node_block(s).object; };
  std::sort(ring.begin(), ring.end(), [&](int a, int b) { return object(a) < object(b); });
  const double cell = static_cast<double>(data.dx) * data.dx * data.dx;
  std::vector<double> full;  // mass of a node in the middle of each body; 0 = not known
  for (const int s : ring) {
    const size_t o = static_cast<size_t>(object(s));
    full.push_back(o < loads.density.size() ? loads.density[o] * cell : 0.0);
  }
  for (size_t a = 0; a < ring.size(); ++a) {
    for (size_t b = a + 1; b < ring.size(); ++b) {
      Node<T>* node[2] = {data.node.data() + static_cast<size_t>(ring[a]) * BlockGrid::kNodes,
                          data.node.data() + static_cast<size_t>(ring[b]) * BlockGrid::kNodes};
      const MassPatch<T> patch[2] = {{data, ring[a]}, {data, ring[b]}};
      const bool known = full[a] > 0 && full[b] > 0;
      const double unit[2] = {known ? full[a] : 1, known ? full[b] : 1};
      for (int k = 0; k < BlockGrid::kNodes; ++k) {
        NodePair pair;
        for (int i = 0; i < 2; ++i) pair.mass[i] = node[i][k].lane[3];
        if (!(pair.mass[0] > 0 && pair.mass[1] > 0)) continue;
        if (known && pair.mass[0] / unit[0] + pair.mass[1] / unit[1] < kFullShare) continue;
        for (int i = 0; i < 2; ++i) {
          pair.velocity[i] = Vec3d(node[i][k].lane[0], node[i][k].lane[1], node[i][k].lane[2]);
          pair.gradient[i] = patch[i].gradient(k) / unit[i];
          if (known) pair.gradient[i] = trusted(pair.gradient[i], pair.mass[i] / unit[i]);
        }
        exchange_impulse(loads.object_friction, pair);
        for (int i = 0; i < 2; ++i)
          for (int c = 0; c < 3; ++c) node[i][k].lane[c] = static_cast<T>(pair.velocity[i][c]);
      }
    }
  }
}

template void apply_object_contact(const StepLoads<float>&, MpmData<float>&, int);
template void apply_object_contact(const StepLoads<double>&, MpmData<double>&, int);

}  // namespace pliant

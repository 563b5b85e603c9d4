#include "physics/mpm/contact_ring.h"

#include <algorithm>
#include <cmath>

namespace pliant {
namespace {

constexpr int kSide = BlockGrid::kSide;
constexpr double kFullShare = 0.85;  // of a node's space that two touching bodies fill together
constexpr int kTrust = 16;

/// Slope of the share of a node's space that a half space fills, per cell, where that share is `share`, and its
/// derivative by the share; see `filled_share`.
struct FlatSlope {
  double value = 0, by_share = 0;

  explicit FlatSlope(double share) {
    const double s = std::min(share, 1 - share), sign = share < 0.5 ? 1 : -1;
    if (!(s > 0)) return;
    if (s < 1.0 / 6) {
      value = 0.5 * std::cbrt(36 * s * s);
      by_share = sign * value / (1.5 * s);
      return;
    }
    const double first = (0.5 - s) / 0.75, distance = (0.5 - s + first * first * first / 3) / 0.75;
    value = 0.75 - distance * distance;
    by_share = sign * 2 * distance * (1 + first * first / 0.75) / 0.75;
  }
};

/// The gradient of a body's share, weighted down where the body has an edge or corner: there the slope is less than
/// that of a flat face, and the other body, if it is flat, knows the normal better.
Vec3d trusted(const Vec3d& gradient, double share) {
  const double slope = gradient.norm();
  const FlatSlope flat(share);
  if (!(slope > 0) || !(flat.value > 0)) return gradient;
  return std::pow(std::min(1.0, slope / flat.value), kTrust) * gradient;
}

/// Turns the derivative `adj` by what is trusted into that by the gradient, and adds that by the share.
void trusted_adjoint(const Vec3d& gradient, double share, Vec3d& adj, double& by_share) {
  const double slope = gradient.norm();
  const FlatSlope flat(share);
  if (!(slope > 0) || !(flat.value > 0) || slope >= flat.value) return;
  const double trust = std::pow(slope / flat.value, kTrust), along = kTrust * trust * adj.dot(gradient);
  by_share -= along / flat.value * flat.by_share;
  adj = trust * adj + along / (slope * slope) * gradient;
}

}  // namespace

template <class T>
NodePatch<T>::NodePatch(const BlockGrid& grid, const std::vector<Node<T>>& nodes, int n) {
  const BlockGrid::Coordinates& at = grid.node_block(n);
  for (int o = 0; o < 27; ++o) {
    const int d[3] = {o / 9 - 1, o / 3 % 3 - 1, o % 3 - 1};
    const int neighbour = o == 13 ? n : grid.find_node_block({at.x + d[0], at.y + d[1], at.z + d[2], at.object});
    if (neighbour >= 0) block_[o] = nodes.data() + static_cast<size_t>(neighbour) * BlockGrid::kNodes;
  }
}

/// visit(neighbour, its weight in the gradient at k).
template <class T>
template <class Visit>
void NodePatch<T>::for_neighbours(int k, Visit&& visit) const {
  constexpr double kAcross[3] = {0.25, 0.5, 0.25}, kAlong[3] = {-0.5, 0, 0.5};
  const int x = k / (kSide * kSide), y = k / kSide % kSide, z = k % kSide;
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b)
      for (int c = 0; c < 3; ++c) {
        const int i = x + a - 1, j = y + b - 1, l = z + c - 1;  // one of which may lie one outside of 0 .. 3
        const Node<T>* block = block_[((i + kSide) / kSide * 3 + (j + kSide) / kSide) * 3 + (l + kSide) / kSide];
        if (block)
          visit(block[((i & 3) * kSide + (j & 3)) * kSide + (l & 3)],
                Vec3d(kAlong[a] * kAcross[b] * kAcross[c], kAcross[a] * kAlong[b] * kAcross[c],
                      kAcross[a] * kAcross[b] * kAlong[c]));
      }
}

template <class T>
Vec3d NodePatch<T>::gradient(int k) const {
  Vec3d sum = Vec3d::Zero();
  for_neighbours(k,
                 [&](const Node<T>& node, const Vec3d& weight) { sum += static_cast<double>(node.lane[3]) * weight; });
  return sum;
}

template <class T>
double NodePatch<T>::gradient_adjoint(int k) const {
  double sum = 0;  // what k is to a neighbour, the neighbour is to k with the other sign
  for_neighbours(k, [&](const Node<T>& node, const Vec3d& weight) {
    sum -= weight.dot(Vec3d(node.lane[0], node.lane[1], node.lane[2]));
  });
  return sum;
}

template <class T>
ContactRing<T>::ContactRing(const StepLoads<T>& loads, const BlockGrid& grid, T dx, const std::vector<Node<T>>& nodes,
                            int n)
    : cell_(static_cast<double>(dx) * dx * dx) {
  if (grid.sibling(n) == n) return;
  for (int s = grid.sibling(n); s != n; s = grid.sibling(s))
    if (s < n) return;
  block_.push_back(n);
  for (int s = grid.sibling(n); s != n; s = grid.sibling(s)) block_.push_back(s);
  const auto object = [&](int s) { return grid.node_block(s).object; };
  std::sort(block_.begin(), block_.end(), [&](int a, int b) { return object(a) < object(b); });
  for (const int s : block_) {
    const size_t o = static_cast<size_t>(object(s));
    full_.push_back(o < loads.density.size() ? loads.density[o] * cell_ : 0.0);
    patch_.emplace_back(grid, nodes, s);
  }
}

template <class T>
bool ContactRing<T>::meet(int a, int b, int k, NodePair& pair) const {
  const int of[2] = {a, b};
  for (int i = 0; i < 2; ++i) pair.mass[i] = patch_[of[i]].node(k).lane[3];
  if (!(pair.mass[0] > 0 && pair.mass[1] > 0)) return false;
  const bool known = full_[a] > 0 && full_[b] > 0;
  if (known && pair.mass[0] / full_[a] + pair.mass[1] / full_[b] < kFullShare) return false;
  for (int i = 0; i < 2; ++i) {
    const double unit = known ? full_[of[i]] : 1;
    pair.gradient[i] = patch_[of[i]].gradient(k) / unit;
    if (known) pair.gradient[i] = trusted(pair.gradient[i], pair.mass[i] / unit);
  }
  return true;
}

template <class T>
void ContactRing<T>::meet_adjoint(int a, int b, int k, const NodePair& adj, Node<T>* const* by_node,
                                  double* const* by_density) const {
  const int of[2] = {a, b};
  const bool known = full_[a] > 0 && full_[b] > 0;
  for (int i = 0; i < 2; ++i) {
    const double unit = known ? full_[of[i]] : 1, share = patch_[of[i]].node(k).lane[3] / unit;
    const Vec3d gradient = patch_[of[i]].gradient(k) / unit;
    Vec3d by_gradient = adj.gradient[i];
    double by_share = 0;
    if (known) {
      trusted_adjoint(gradient, share, by_gradient, by_share);
      *by_density[i] -= (by_gradient.dot(gradient) + by_share * share) / unit * cell_;
    }
    for (int c = 0; c < 3; ++c) by_node[i]->lane[c] += static_cast<T>(by_gradient[c] / unit);
    by_node[i]->lane[3] += static_cast<T>(adj.mass[i] + by_share / unit);
  }
}

template class NodePatch<float>;
template class NodePatch<double>;
template class ContactRing<float>;
template class ContactRing<double>;

}  // namespace pliant

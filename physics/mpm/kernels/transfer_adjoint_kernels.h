#pragma once

#include "physics/mpm/kernels/record_packs.h"

// Transfers of one particle in the reverse direction: gather and scatter change places, and the weights have slopes.

namespace pliant::PLIANT_ISA {

/// Splines of a pack of particles laid out for one lane at a time: weights along x, y, z, then their slopes per cell.
template <class T>
struct StencilLanes {
  alignas(64) T weight[9][kLanes];
  alignas(64) T slope[9][kLanes];
  int corner[kLanes];
  Pack<T> from_middle[3];  ///< particle minus middle node of its stencil, cells

  INLINE void set(const Pack<T>* x, const T* origin, T inverse_dx) {
    Mask<T> base[3];
    for (int a = 0; a < 3; ++a) {
      const SplinePack<T> s((x[a] - origin[a]) * inverse_dx);
      base[a] = s.base;
      from_middle[a] = s.offset - T(1);
      for (int i = 0; i < 3; ++i) store(weight[3 * a + i], s.weight[i]);
      store(slope[3 * a], s.offset - T(1.5));
      store(slope[3 * a + 1], T(-2) * from_middle[a]);
      store(slope[3 * a + 2], s.offset - T(0.5));
    }
    corners<T>(base[0], base[1], base[2], corner);
  }
};

/// The nodes of one row along z, as two and one.
template <class T>
struct NodeRow {
  TwoNodes<T> two{};
  OneNode<T> one{};

  INLINE static NodeRow from(const T* node) { return {load<TwoNodes<T>>(node), load<OneNode<T>>(node + 8)}; }
  INLINE NodeRow times(T w) const { return {two * w, one * w}; }
  INLINE NodeRow times(const NodeRow& b) const { return {two * b.two, one * b.one}; }
  INLINE void add(const NodeRow& b) {
    two += b.two;
    one += b.one;
  }
  INLINE void add_scaled(const NodeRow& b, T w) {
    two = fma(b.two, all<TwoNodes<T>>(w), two);
    one = fma(b.one, all<OneNode<T>>(w), one);
  }
  INLINE void add_product(const NodeRow& a, const NodeRow& b) {
    two = fma(a.two, b.two, two);
    one = fma(a.one, b.one, one);
  }
  INLINE NodeRow minus(const NodeRow& b) const { return {two - b.two, one - b.one}; }
  /// Sum of the three nodes.
  INLINE OneNode<T> sum() const { return low_node<T>(two) + high_node<T>(two) + one; }
};

/// Three numbers along z, one per node of a row.
template <class T>
INLINE NodeRow<T> along_z(const T (*number)[kLanes], int lane) {
  return {join<T>(all<OneNode<T>>(number[6][lane]), all<OneNode<T>>(number[7][lane])),
          all<OneNode<T>>(number[8][lane])};
}

/// Node values that are affine in space: value[0..3] at the lowest node of the stencil, then their steps along x, y, z.
template <class T>
struct AffineRows {
  NodeRow<T> plane, along_x, along_y;

  INLINE explicit AffineRows(const T* value) {
    using One = OneNode<T>;
    const One base = load<One>(value), X = load<One>(value + 4), Y = load<One>(value + 8), Z = load<One>(value + 12);
    plane = {join<T>(base, base + Z), base + (Z + Z)};
    along_x = {join<T>(X, X), X};
    along_y = {join<T>(Y, Y), Y};
  }
};

/// Sums of node products p over a stencil with a slope in place of one of the three weights.
template <class T>
struct SlopeSums {
  NodeRow<T> by_x, by_y, by_z;  // by_z waits for the slopes along z
  NodeRow<T> weighted, sloped;  // of the present plane

  INLINE void add_row(const NodeRow<T>& p, T weight_y, T slope_y, bool first) {
    if (first) {
      weighted = p.times(weight_y);
      sloped = p.times(slope_y);
      return;
    }
    weighted.add_scaled(p, weight_y);
    sloped.add_scaled(p, slope_y);
  }
  INLINE void end_plane(T weight_x, T slope_x) {
    by_x.add_scaled(weighted, slope_x);
    by_y.add_scaled(sloped, weight_x);
    by_z.add_scaled(weighted, weight_x);
  }
  /// Writes four numbers each, whose sums are the slopes along x, y, z.
  INLINE void finish(const NodeRow<T>& weight_z, const NodeRow<T>& slope_z, T* out) const {
    store(out, by_x.times(weight_z).sum());
    store(out + 4, by_y.times(weight_z).sum());
    store(out + 8, by_z.times(slope_z).sum());
  }
};

/// patch_i += w_i h_i for an affine h, and the slopes of sum w u . h by the particle's position in cells, through w
/// only; u the node values at `u_corner`.
template <class T>
INLINE void scatter_with_slopes(const StencilLanes<T>& s, int lane, const T* h, const T* u_corner, T* patch_corner,
                                T* slopes) {
  AffineRows<T> rows(h);
  const NodeRow<T> weight_z = along_z<T>(s.weight, lane), slope_z = along_z<T>(s.slope, lane);
  SlopeSums<T> sums;
  for (int i = 0; i < 3; ++i) {
    NodeRow<T> row = rows.plane;
    const T weight_x = s.weight[i][lane];
    for (int j = 0; j < 3; ++j) {
      const int at = i * kPlane + j * kRow;
      NodeRow<T> node = NodeRow<T>::from(patch_corner + at);
      node.add_product(row, weight_z.times(weight_x * s.weight[3 + j][lane]));
      store(patch_corner + at, node.two);
      store(patch_corner + at + 8, node.one);
      sums.add_row(row.times(NodeRow<T>::from(u_corner + at)), s.weight[3 + j][lane], s.slope[3 + j][lane], j == 0);
      row.add(rows.along_y);
    }
    sums.end_plane(weight_x, s.slope[i][lane]);
    rows.plane.add(rows.along_x);
  }
  sums.finish(weight_z, slope_z, slopes);
}

/// Moments of the node values a at `corner` about the middle node: sum w a, sum w (i - 1) a, sum w (j - 1) a,
/// sum w (k - 1) a to out[0..15], and the slopes of sum w a . q by the particle's position in cells, through w only, to
/// out[16..27].
template <class T>
INLINE void gather_with_slopes(const StencilLanes<T>& s, int lane, const T* q, const T* corner, T* out) {
  AffineRows<T> rows(q);
  const NodeRow<T> weight_z = along_z<T>(s.weight, lane), slope_z = along_z<T>(s.slope, lane);
  SlopeSums<T> sums;
  NodeRow<T> value, along_x, along_y;
  const T wy0 = s.weight[3][lane], wy1 = s.weight[4][lane], wy2 = s.weight[5][lane];
  for (int i = 0; i < 3; ++i) {
    NodeRow<T> row = rows.plane, plane, low;
    for (int j = 0; j < 3; ++j) {
      const NodeRow<T> a = NodeRow<T>::from(corner + i * kPlane + j * kRow);
      const T weight = j == 0 ? wy0 : j == 1 ? wy1 : wy2;
      sums.add_row(row.times(a), weight, s.slope[3 + j][lane], j == 0);
      if (j == 0) plane = low = a.times(weight);
      if (j == 1) plane.add_scaled(a, weight);
      if (j == 2) {
        const NodeRow<T> high = a.times(weight);
        plane.add(high);
        low = high.minus(low);
      }
      row.add(rows.along_y);
    }
    const T weight_x = s.weight[i][lane];
    sums.end_plane(weight_x, s.slope[i][lane]);
    const NodeRow<T> part = plane.times(weight_x);
    value.add(part);
    if (i == 0) along_x = along_x.minus(part);
    if (i == 2) along_x.add(part);
    along_y.add_scaled(low, weight_x);
    rows.plane.add(rows.along_x);
  }
  const NodeRow<T> weighted = value.times(weight_z);
  store(out, weighted.sum());
  store(out + 4, along_x.times(weight_z).sum());
  store(out + 8, along_y.times(weight_z).sum());
  store(out + 12, weighted.one - low_node<T>(weighted.two));
  sums.finish(weight_z, slope_z, out + 16);
}

/// sum w u.
template <class T>
INLINE OneNode<T> value_at_particle(const StencilLanes<T>& s, int lane, const T* u_corner) {
  NodeRow<T> sum;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      sum.add_scaled(NodeRow<T>::from(u_corner + i * kPlane + j * kRow), s.weight[i][lane] * s.weight[3 + j][lane]);
  return sum.times(along_z<T>(s.weight, lane)).sum();
}

}  // namespace pliant::PLIANT_ISA

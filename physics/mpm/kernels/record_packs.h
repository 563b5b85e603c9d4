#pragma once

#include "gaussians/simd/pack_math.h"
#include "physics/mpm/kernels/kernels.h"

// Records as packs of particles, and what both transfers need of them.

namespace pliant::PLIANT_ISA {

/// The four numbers of one node, and those of two neighbours.
template <class T>
struct NodeLanes;
template <>
struct NodeLanes<float> {
  typedef float One __attribute__((vector_size(16)));
  typedef float Two __attribute__((vector_size(32)));
};
template <>
struct NodeLanes<double> {
  typedef double One __attribute__((vector_size(32)));
  typedef double Two __attribute__((vector_size(64)));
};
template <class T>
using OneNode = typename NodeLanes<T>::One;
template <class T>
using TwoNodes = typename NodeLanes<T>::Two;

template <class V, class T>
INLINE V load(const T* from) {
  V v;
  __builtin_memcpy(&v, from, sizeof v);
  return v;
}
template <class V, class T>
INLINE void store(T* to, V v) {
  __builtin_memcpy(to, &v, sizeof v);
}
template <class T>
INLINE TwoNodes<T> join(OneNode<T> low, OneNode<T> high) {
  return __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7);
}
template <class T>
INLINE OneNode<T> low_node(TwoNodes<T> v) {
  return __builtin_shufflevector(v, v, 0, 1, 2, 3);
}
template <class T>
INLINE OneNode<T> high_node(TwoNodes<T> v) {
  return __builtin_shufflevector(v, v, 4, 5, 6, 7);
}
#if defined(__AVX2__)
INLINE OneNode<float> fma(OneNode<float> a, OneNode<float> b, OneNode<float> c) { return _mm_fmadd_ps(a, b, c); }
#endif

/// 4 x 4 blocks along the diagonal of packs, transposed.
template <class V>
INLINE void transpose4(V* a) {
#if defined(__AVX2__)
  const V t0 = __builtin_shufflevector(a[0], a[1], 0, 8, 1, 9, 4, 12, 5, 13);
  const V t1 = __builtin_shufflevector(a[0], a[1], 2, 10, 3, 11, 6, 14, 7, 15);
  const V t2 = __builtin_shufflevector(a[2], a[3], 0, 8, 1, 9, 4, 12, 5, 13);
  const V t3 = __builtin_shufflevector(a[2], a[3], 2, 10, 3, 11, 6, 14, 7, 15);
  a[0] = __builtin_shufflevector(t0, t2, 0, 1, 8, 9, 4, 5, 12, 13);
  a[1] = __builtin_shufflevector(t0, t2, 2, 3, 10, 11, 6, 7, 14, 15);
  a[2] = __builtin_shufflevector(t1, t3, 0, 1, 8, 9, 4, 5, 12, 13);
  a[3] = __builtin_shufflevector(t1, t3, 2, 3, 10, 11, 6, 7, 14, 15);
#else
  const V t0 = __builtin_shufflevector(a[0], a[1], 0, 4, 1, 5);
  const V t1 = __builtin_shufflevector(a[0], a[1], 2, 6, 3, 7);
  const V t2 = __builtin_shufflevector(a[2], a[3], 0, 4, 1, 5);
  const V t3 = __builtin_shufflevector(a[2], a[3], 2, 6, 3, 7);
  a[0] = __builtin_shufflevector(t0, t2, 0, 1, 4, 5);
  a[1] = __builtin_shufflevector(t0, t2, 2, 3, 6, 7);
  a[2] = __builtin_shufflevector(t1, t3, 0, 1, 4, 5);
  a[3] = __builtin_shufflevector(t1, t3, 2, 3, 6, 7);
#endif
}

/// out[k][l] = at[l][offset + k] for k < 4: one group of every particle of a pack.
template <class T>
INLINE void load_group(const T* const* at, int offset, Pack<T>* out) {
  using One = OneNode<T>;
  for (int k = 0; k < 4; ++k) {
#if defined(__AVX2__)
    out[k] = join<T>(load<One>(at[k] + offset), load<One>(at[k + 4] + offset));
#else
    out[k] = load<One>(at[k] + offset);
#endif
  }
  transpose4(out);
}
/// The reverse: at[l][offset + k] = a, b, c, d [l].
template <class T>
INLINE void store_group(T* const* at, int offset, Pack<T> a, Pack<T> b, Pack<T> c, Pack<T> d) {
  Pack<T> in[4] = {a, b, c, d};
  transpose4(in);
  for (int k = 0; k < 4; ++k) {
#if defined(__AVX2__)
    store(at[k] + offset, low_node<T>(in[k]));
    store(at[k + 4] + offset, high_node<T>(in[k]));
#else
    store(at[k] + offset, in[k]);
#endif
  }
}

/// The records of up to a pack's worth of particles from `first` on; spare lanes repeat the last one, so that what
/// they compute and store is the same.
template <class T>
INLINE int point_at(const ParticleRun<T>& run, int first, T** at) {
  const int left = run.count - first, lanes = left < kLanes ? left : kLanes;
  for (int l = 0; l < kLanes; ++l)
    at[l] = reinterpret_cast<T*>(run.record + run.order[first + (l < lanes ? l : lanes - 1)]);
  return lanes;
}
/// Fetches the first `lines` cache lines of the records of the pack after next.
template <class T>
INLINE void prefetch(const ParticleRun<T>& run, int first, int lines) {
  constexpr int kAhead = 16;
  if (first + kAhead + kLanes > run.count) return;
  for (int l = 0; l < kLanes; ++l) {
    const char* r = reinterpret_cast<const char*>(run.record + run.order[first + kAhead + l]);
    for (int k = 0; k < lines; ++k) __builtin_prefetch(r + 64 * k);
  }
}

/// Lowest node of the stencil of coordinate x along one axis, in cells: floor((x - origin) / dx - 1/2).
template <class T>
INLINE Mask<T> stencil_base(Pack<T> grid_x) {
  const Pack<T> t = grid_x - T(0.5);
  const Mask<T> cut = whole(t);
  return cut + (__builtin_convertvector(cut, Pack<T>) > t);
}

/// Quadratic B-spline along one axis, see `Spline`.
template <class T>
struct SplinePack {
  Mask<T> base;
  Pack<T> offset, weight[3];

  INLINE explicit SplinePack(Pack<T> grid_x) : base(stencil_base<T>(grid_x)) {
    offset = grid_x - __builtin_convertvector(base, Pack<T>);
    const Pack<T> a = T(1.5) - offset, b = offset - T(1), c = offset - T(0.5);
    weight[0] = T(0.5) * a * a;
    weight[1] = T(0.75) - b * b;
    weight[2] = T(0.5) * c * c;
  }
};

/// Index of the lowest stencil node in the patch, times the four numbers of a node.
template <class T>
INLINE void corners(const Mask<T>& x, const Mask<T>& y, const Mask<T>& z, int* corner) {
  const Mask<T> index = (((x & 3) * 6 + (y & 3)) * 6 + (z & 3)) * 4;
  for (int l = 0; l < kLanes; ++l) corner[l] = static_cast<int>(index[l]);
}

constexpr int kPlane = 6 * 6 * 4, kRow = 6 * 4;  // steps in a patch, in numbers

}  // namespace pliant::PLIANT_ISA

#pragma once

// Transfers of one particle in the reverse direction.  Included with PLIANT_ISA set to the namespace of the code.

#include "physics/laws/pack.h"
#include "physics/mpm/block_grid.h"
#include "physics/mpm/bspline.h"

namespace pliant::PLIANT_ISA {

#define PLIANT_INLINE inline __attribute__((always_inline))

/// Splines under a particle in a patch of 6 x 6 x 6 nodes, and the number of its lowest node.
template <class T>
struct Stencil {
  SplineWithSlope<T> x, y, z;
  int corner;

  PLIANT_INLINE Stencil(const T* position, const T* origin, T inverse_dx)
      : x((position[0] - origin[0]) * inverse_dx),
        y((position[1] - origin[1]) * inverse_dx),
        z((position[2] - origin[2]) * inverse_dx),
        corner(((x.base & 3) * BlockGrid::kPatch + (y.base & 3)) * BlockGrid::kPatch + (z.base & 3)) {}
};

/// Node values that are affine in space: at the particle, and their change per cell.  As the result of a gather: the
/// moments sum w a and sum w a (x_i - x_p) [cells].
template <class T>
struct Affine {
  Pack<T> value, along[3];
};

template <class T>
PLIANT_INLINE T sum_of_lanes(const Pack<T>& p) {
  return (p[0] + p[1]) + (p[2] + p[3]);
}

/// Derivative of sum_i w_i p_i by the particle's position [cells], through the weights.
template <class T>
struct Slopes {
  Pack<T> x{}, y{}, z{};
  Pack<T> plane, plane_y, plane_z;

  PLIANT_INLINE void begin_plane() { plane = plane_y = plane_z = Pack<T>{}; }
  PLIANT_INLINE void add_row(const Stencil<T>& s, int j, const Pack<T>& p0, const Pack<T>& p1, const Pack<T>& p2) {
    const Pack<T> row = p0 * s.z.weight[0] + p1 * s.z.weight[1] + p2 * s.z.weight[2];
    plane += row * s.y.weight[j];
    plane_y += row * s.y.slope[j];
    plane_z += (p0 * s.z.slope[0] + p1 * s.z.slope[1] + p2 * s.z.slope[2]) * s.y.weight[j];
  }
  PLIANT_INLINE void end_plane(const Stencil<T>& s, int i) {
    x += plane * s.x.slope[i];
    y += plane_y * s.x.weight[i];
    z += plane_z * s.x.weight[i];
  }
};

/// sum w u.
template <class T>
PLIANT_INLINE Pack<T> value_at_particle(const Stencil<T>& s, const Pack<T>* u) {
  Pack<T> sum{};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      for (int k = 0; k < 3; ++k)
        sum += u[s.corner + (i * BlockGrid::kPatch + j) * BlockGrid::kPatch + k] *
               (s.x.weight[i] * s.y.weight[j] * s.z.weight[k]);
  return sum;
}

/// patch_i += w_i h_i for an affine h.  `by_position` becomes the derivative of sum w u . h by the particle's position
/// [cells] through w and h, u the values of nodes and u_p = sum w u.
template <class T>
PLIANT_INLINE void scatter_with_slopes(const Stencil<T>& s, const Affine<T>& h, const Pack<T>* u, const Pack<T>& u_p,
                                       Pack<T>* patch, T* by_position) {
  using P = Pack<T>;
  constexpr int kPatch = BlockGrid::kPatch;
  const P base = h.value - h.along[0] * s.x.offset - h.along[1] * s.y.offset - h.along[2] * s.z.offset;
  Slopes<T> slopes;
  for (int i = 0; i < 3; ++i) {
    const P start = base + h.along[0] * T(i);
    slopes.begin_plane();
    for (int j = 0; j < 3; ++j) {
      const P h0 = start + h.along[1] * T(j), h1 = h0 + h.along[2], h2 = h1 + h.along[2];
      const int at = s.corner + (i * kPatch + j) * kPatch;
      const T w = s.x.weight[i] * s.y.weight[j];
      patch[at] += h0 * (w * s.z.weight[0]);
      patch[at + 1] += h1 * (w * s.z.weight[1]);
      patch[at + 2] += h2 * (w * s.z.weight[2]);
      slopes.add_row(s, j, u[at] * h0, u[at + 1] * h1, u[at + 2] * h2);
    }
    slopes.end_plane(s, i);
  }
  by_position[0] = sum_of_lanes<T>(slopes.x - h.along[0] * u_p);
  by_position[1] = sum_of_lanes<T>(slopes.y - h.along[1] * u_p);
  by_position[2] = sum_of_lanes<T>(slopes.z - h.along[2] * u_p);
}

/// Moments of the node values a.  `by_position` becomes the derivative of sum w a . q by the particle's position
/// [cells] through w and q, for an affine q.
template <class T>
PLIANT_INLINE Affine<T> gather_with_slopes(const Stencil<T>& s, const Affine<T>& q, const Pack<T>* patch,
                                           T* by_position) {
  using P = Pack<T>;
  constexpr int kPatch = BlockGrid::kPatch;
  const P base = q.value - q.along[0] * s.x.offset - q.along[1] * s.y.offset - q.along[2] * s.z.offset;
  const T z0 = -s.z.offset * s.z.weight[0], z1 = (1 - s.z.offset) * s.z.weight[1], z2 = (2 - s.z.offset) * s.z.weight[2];
  Slopes<T> slopes;
  Affine<T> moments{};
  for (int i = 0; i < 3; ++i) {
    const P start = base + q.along[0] * T(i);
    P plane{}, along_y{}, along_z{};
    slopes.begin_plane();
    for (int j = 0; j < 3; ++j) {
      const P q0 = start + q.along[1] * T(j), q1 = q0 + q.along[2], q2 = q1 + q.along[2];
      const P* a = patch + s.corner + (i * kPatch + j) * kPatch;
      slopes.add_row(s, j, a[0] * q0, a[1] * q1, a[2] * q2);
      const P row = a[0] * s.z.weight[0] + a[1] * s.z.weight[1] + a[2] * s.z.weight[2];
      plane += row * s.y.weight[j];
      along_y += row * (s.y.weight[j] * (T(j) - s.y.offset));
      along_z += (a[0] * z0 + a[1] * z1 + a[2] * z2) * s.y.weight[j];
    }
    slopes.end_plane(s, i);
    moments.value += plane * s.x.weight[i];
    moments.along[0] += plane * (s.x.weight[i] * (T(i) - s.x.offset));
    moments.along[1] += along_y * s.x.weight[i];
    moments.along[2] += along_z * s.x.weight[i];
  }
  by_position[0] = sum_of_lanes<T>(slopes.x - q.along[0] * moments.value);
  by_position[1] = sum_of_lanes<T>(slopes.y - q.along[1] * moments.value);
  by_position[2] = sum_of_lanes<T>(slopes.z - q.along[2] * moments.value);
  return moments;
}

}  // namespace pliant::PLIANT_ISA

#pragma once

#include "gaussians/base/portable.h"

namespace pliant {

constexpr int kMaxShCount = 16;

// Formulas for numbers and for packs of numbers alike: V is T, or a vector of T.  Inlined in any case, so that code for
// an instruction set leaves no function that others share.
#define SH_INLINE __attribute__((always_inline)) inline HOST_DEVICE

/// Real spherical harmonics of degree 0..3 at the unit direction (x, y, z), [(degree + 1)^2], in the order and with the
/// signs of 3DGS files.
template <class T, class V>
SH_INLINE void sh_basis(int degree, V x, V y, V z, V* basis) {
  basis[0] = V{} + T(0.28209479177387814);
  if (degree < 1) return;
  const T k1 = T(0.4886025119029199);
  basis[1] = -k1 * y;
  basis[2] = k1 * z;
  basis[3] = -k1 * x;
  if (degree < 2) return;
  const V xx = x * x, yy = y * y, zz = z * z;
  const T k2 = T(1.0925484305920792);
  basis[4] = k2 * x * y;
  basis[5] = -k2 * y * z;
  basis[6] = T(0.31539156525252005) * (2 * zz - xx - yy);
  basis[7] = -k2 * x * z;
  basis[8] = T(0.5462742152960396) * (xx - yy);
  if (degree < 3) return;
  const T k3 = T(0.5900435899266435), k4 = T(0.4570457994644658);
  basis[9] = -k3 * y * (3 * xx - yy);
  basis[10] = T(2.890611442640554) * x * y * z;
  basis[11] = -k4 * y * (4 * zz - xx - yy);
  basis[12] = T(0.3731763325901154) * z * (2 * zz - 3 * xx - 3 * yy);
  basis[13] = -k4 * x * (4 * zz - xx - yy);
  basis[14] = T(1.445305721320277) * z * (xx - yy);
  basis[15] = -k3 * x * (xx - 3 * yy);
}

/// adj_d[i] = sum of adj_basis[k] d basis[k] / d d_i, with the three components of d = (x, y, z) taken as independent.
template <class T, class V>
SH_INLINE void sh_basis_adjoint(int degree, V x, V y, V z, const V* adj_basis, V* adj_d) {
  const V* b = adj_basis;
  adj_d[0] = adj_d[1] = adj_d[2] = V{};
  if (degree < 1) return;
  const T k1 = T(0.4886025119029199);
  adj_d[0] = -k1 * b[3];
  adj_d[1] = -k1 * b[1];
  adj_d[2] = k1 * b[2];
  if (degree < 2) return;
  const V xx = x * x, yy = y * y, zz = z * z;
  const T k2 = T(1.0925484305920792);
  const V zonal = T(0.31539156525252005) * b[6], k8 = T(0.5462742152960396) * b[8];
  adj_d[0] += k2 * (y * b[4] - z * b[7]) + 2 * x * (k8 - zonal);
  adj_d[1] += k2 * (x * b[4] - z * b[5]) - 2 * y * (k8 + zonal);
  adj_d[2] += -k2 * (y * b[5] + x * b[7]) + 4 * z * zonal;
  if (degree < 3) return;
  const T k3 = T(0.5900435899266435), k4 = T(0.4570457994644658);
  const V k10 = T(2.890611442640554) * b[10], k12 = T(0.3731763325901154) * b[12], k14 = T(1.445305721320277) * b[14];
  adj_d[0] += -6 * k3 * x * y * b[9] + k10 * y * z + 2 * k4 * x * y * b[11] - 6 * k12 * x * z -
              k4 * (4 * zz - 3 * xx - yy) * b[13] + 2 * k14 * x * z - 3 * k3 * (xx - yy) * b[15];
  adj_d[1] += -3 * k3 * (xx - yy) * b[9] + k10 * x * z - k4 * (4 * zz - xx - 3 * yy) * b[11] - 6 * k12 * y * z +
              2 * k4 * x * y * b[13] - 2 * k14 * y * z + 6 * k3 * x * y * b[15];
  adj_d[2] +=
      k10 * x * y - 8 * k4 * y * z * b[11] + 3 * k12 * (2 * zz - xx - yy) - 8 * k4 * x * z * b[13] + k14 * (xx - yy);
}

/// Colour seen along the unit direction (x, y, z) from the camera to the Gaussian: max(0, 0.5 + sum of basis * sh),
/// [3].  sh [(degree + 1)^2, 3].
template <class T, class V, class S>
SH_INLINE void sh_color(int degree, const S* sh, V x, V y, V z, V* color) {
  V basis[kMaxShCount];
  sh_basis<T>(degree, x, y, z, basis);
  color[0] = color[1] = color[2] = V{} + T(0.5);
  for (int k = 0; k < (degree + 1) * (degree + 1); ++k)
    for (int c = 0; c < 3; ++c) color[c] += basis[k] * sh[3 * k + c];
  // NaN stays NaN.
  for (int c = 0; c < 3; ++c) color[c] = V{} > color[c] ? V{} : color[c];
}

/// Writes adj_sh [(degree + 1)^2, 3] and adj_d [3], the derivatives with respect to the coefficients and to the
/// direction (its three components taken as independent).  Nothing flows through a colour that is clamped at 0.
template <class T, class V, class S>
SH_INLINE void sh_color_adjoint(int degree, const S* sh, V x, V y, V z, const V* adj_color, V* adj_sh, V* adj_d) {
  V basis[kMaxShCount], adj_basis[kMaxShCount] = {}, flow[3];
  sh_basis<T>(degree, x, y, z, basis);
  sh_color<T>(degree, sh, x, y, z, flow);
  for (int c = 0; c < 3; ++c) flow[c] = flow[c] > V{} ? adj_color[c] : V{};
  for (int k = 0; k < (degree + 1) * (degree + 1); ++k) {
    for (int c = 0; c < 3; ++c) {
      adj_sh[3 * k + c] = basis[k] * flow[c];
      adj_basis[k] += sh[3 * k + c] * flow[c];
    }
  }
  sh_basis_adjoint<T>(degree, x, y, z, adj_basis, adj_d);
}

}  // namespace pliant

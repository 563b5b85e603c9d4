#pragma once

#include "gaussians/render/project_kernels.h"

// Reverse of project_kernels.h: from the derivatives of splats to those of Gaussians and of the camera.

namespace pliant::PLIANT_ISA {

/// Derivatives with respect to a footprint.
template <class T>
struct FootprintGradient {
  Pack<T> u, v, depth;
  Pack<T> xx, yy, xy, sharp;  ///< to |mx|^2, |my|^2, mx . my and |mx x my|^2
};

/// From the sums over pixels (see PairSlot): ln(alpha) = ln(opacity) - h_x e^2 - h_y d^2, h_x = yy / (2 determinant),
/// h_y = 1 / (2 yy), slope = xy / yy, determinant = sharp + blur (|mx|^2 + |my|^2) + blur^2; with antialiasing opacity
/// carries the factor sqrt(sharp / determinant).
template <class T>
INLINE FootprintGradient<T> footprint_gradient(const Footprint<T>& f, const Pack<T>& blur, const Pack<T>* sums,
                                               bool antialiased) {
  using V = Pack<T>;
  const V inverse_yy = T(1) / f.yy, half_inverse = T(0.5) / f.determinant;
  const V slope = f.xy * inverse_yy, hx = f.yy * half_inverse, hy = T(0.5) * inverse_yy;
  const V adj_slope = 2 * hx * sums[kMomentED];
  const V adj_yy = 2 * hy * hy * sums[kMomentDD] - adj_slope * slope * inverse_yy - sums[kMomentEE] * half_inverse;
  V adj_sharp{}, adj_determinant = 2 * sums[kMomentEE] * hx * half_inverse;
  if (antialiased) {
    const Mask<T> free = f.sharp / f.determinant > V{} + T(splat::kMinCompensation);
    adj_sharp = where(free, T(0.5) * sums[kMoment] / f.sharp);
    adj_determinant -= where(free, sums[kMoment] * half_inverse);
  }
  FootprintGradient<T> out;
  out.u = 2 * hx * sums[kMomentE];
  out.v = 2 * (hy * sums[kMomentD] - slope * hx * sums[kMomentE]);
  out.depth = sums[kAdjDepth];
  out.xx = blur * adj_determinant;
  out.yy = adj_yy + out.xx;
  out.xy = adj_slope * inverse_yy;
  out.sharp = adj_sharp + adj_determinant;
  return out;
}

/// Derivatives with respect to the camera as free entries, summed lane by lane.
template <class T>
struct WideViewGradient {
  PackMatrix<T> R;
  Pack3<T> t, centre;
};

/// Through the projection of the mean and the Jacobian, whose derivatives adj_jx and adj_jy are given; returns those of
/// the position.
template <class T>
INLINE Pack3<T> mean_adjoint(const WideView<T>& view, const Footprint<T>& f, const Pack3<T>& position,
                             const FootprintGradient<T>& adj, const Pack3<T>& adj_jx, const Pack3<T>& adj_jy,
                             WideViewGradient<T>& adj_view) {
  const Pack3<T> jx = f.scale_x * adj_jx, jy = f.scale_y * adj_jy;
  const Pack<T> adj_x = view.fx * adj.u - where(f.inside_x, dot(view.R.row[2], jx));
  const Pack<T> adj_y = view.fy * adj.v - where(f.inside_y, dot(view.R.row[2], jy));
  const Pack<T> inverse_z = T(1) / f.p.z;
  const Pack<T> sum = dot(adj_jx, f.jx) + dot(adj_jy, f.jy) + adj_x * f.x + adj_y * f.y;
  const Pack3<T> adj_p = {adj_x * inverse_z, adj_y * inverse_z, adj.depth - sum * inverse_z};
  PackMatrix<T>& R = adj_view.R;
  R.row[0] = R.row[0] + fma(adj_p.x, position, jx);
  R.row[1] = R.row[1] + fma(adj_p.y, position, jy);
  R.row[2] = R.row[2] + fma(-f.held_x, jx, fma(-f.held_y, jy, adj_p.z * position));
  adj_view.t = adj_view.t + adj_p;
  return transposed(view.R, adj_p);
}

/// Adds the derivatives with respect to the covariance in the world, as a symmetric matrix.
template <class T>
INLINE void add_covariance(const Footprint<T>& f, const FootprintGradient<T>& adj, const Rows& rows, T* to) {
  // |mx x my|^2 = |mx|^2 |my|^2 - (mx . my)^2.
  const Pack<T> xx = adj.xx + adj.sharp * dot(f.my, f.my), yy = adj.yy + adj.sharp * dot(f.mx, f.mx);
  const Pack<T> xy = T(0.5) * adj.xy - adj.sharp * f.xy;
  const Pack3<T> a = fma(xx, f.jx, xy * f.jy), b = fma(xy, f.jx, yy * f.jy);
  const auto entry = [](Pack<T> x, Pack<T> a, Pack<T> y, Pack<T> b) { return fma(x, a, y * b); };
  const Pack<T> xy_of = entry(f.jx.x, a.y, f.jy.x, b.y), xz_of = entry(f.jx.x, a.z, f.jy.x, b.z);
  const Pack<T> yz_of = entry(f.jx.y, a.z, f.jy.y, b.z);
  const Pack<T> all[9] = {entry(f.jx.x, a.x, f.jy.x, b.x), xy_of, xz_of, xy_of,
                          entry(f.jx.y, a.y, f.jy.y, b.y), yz_of, xz_of, yz_of,
                          entry(f.jx.z, a.z, f.jy.z, b.z)};
  add_rows(all, rows, 9, to);
}

/// Through the colour: adds to the coefficients, returns the derivative of the position.
template <class T>
INLINE Pack3<T> color_adjoint(const CloudInput<T>& cloud, const Rows& rows, const Pack3<T>& ray,
                              const Pack<T>* adj_color, T* to_sh) {
  const int width = 3 * (cloud.sh_degree + 1) * (cloud.sh_degree + 1);
  Pack<T> sh[3 * kMaxShCount], adj_sh[3 * kMaxShCount], adj_d[3];
  load_rows(cloud.sh, rows, width, sh);
  const Direction<T> to = direction(ray);
  sh_color_adjoint<T>(cloud.sh_degree, sh, to.d.x, to.d.y, to.d.z, adj_color, adj_sh, adj_d);
  add_rows(adj_sh, rows, width, to_sh);
  const Pack3<T> adj = {adj_d[0], adj_d[1], adj_d[2]};
  return to.inverse_length * fma(-dot(to.d, adj), to.d, adj);
}

template <class T>
INLINE void add_vectors(const Pack3<T>& v, const Rows& rows, T* to) {
  const Pack<T> columns[3] = {v.x, v.y, v.z};
  add_rows(columns, rows, 3, to);
}

template <class T>
INLINE void project_adjoint_lanes(const ProjectAdjointInput<T>& in, const WideView<T>& view, const Rows& rows,
                                  const Pack<T>* sums, const CloudGradient<T>& out, WideViewGradient<T>& adj_view) {
  // Forward again.
  const Pack3<T> position = load_vectors(in.cloud.position, rows);
  const Pack3<T> log_scale = load_vectors(in.cloud.log_scale, rows);
  const Pack3<T> scale = {exponential(log_scale.x), exponential(log_scale.y), exponential(log_scale.z)};
  const Rotation<T> rotation = load_rotation(in.cloud.rotation, rows);
  const Footprint<T> f = footprint(view, view.R * position + view.t, rotation.R, scale);

  // mx = diag(scale) R^T jx, so that scale_j dL/dscale_j = mx_j dL/dmx_j + my_j dL/dmy_j.
  const FootprintGradient<T> adj = footprint_gradient(f, view.blur, sums, in.antialiased);
  const Pack<T> twice = 2 * adj.sharp;
  const Pack3<T> adj_mx = fma(2 * adj.xx, f.mx, fma(adj.xy, f.my, twice * cross(f.my, f.normal)));
  const Pack3<T> adj_my = fma(2 * adj.yy, f.my, fma(adj.xy, f.mx, twice * cross(f.normal, f.mx)));
  add_vectors(product(f.mx, adj_mx) + product(f.my, adj_my), rows, out.log_scale);
  const Pack3<T> ax = product(scale, adj_mx), ay = product(scale, adj_my);
  const PackMatrix<T> adj_R = {
      {fma(f.jx.x, ax, f.jy.x * ay), fma(f.jx.y, ax, f.jy.y * ay), fma(f.jx.z, ax, f.jy.z * ay)}};
  Pack<T> adj_wxyz[4];
  rotation_adjoint(rotation, adj_R, adj_wxyz);
  add_rows(adj_wxyz, rows, 4, out.rotation);
  if (out.covariance) add_covariance(f, adj, rows, out.covariance);

  Pack<T> logit;
  load_rows(in.cloud.opacity_logit, rows, 1, &logit);
  const Pack<T> adj_logit = sums[kMoment] / (T(1) + exponential(logit));
  add_rows(&adj_logit, rows, 1, out.opacity_logit);

  const Pack3<T> adj_ray = color_adjoint(in.cloud, rows, position - view.centre, sums + kAdjColor, out.sh);
  adj_view.centre = adj_view.centre - adj_ray;
  add_vectors(adj_ray + mean_adjoint(view, f, position, adj, rotation.R * ax, rotation.R * ay, adj_view), rows,
              out.position);
}

template <class T>
void project_adjoint(const ProjectAdjointInput<T>& in, const CloudGradient<T>& out, ViewGradient<T>& adj_view) {
  const WideView<T> view(in.view);
  WideViewGradient<T> wide{};
  for (size_t first = 0; first < in.count; first += kLanes) {
    const Rows rows = rows_from(first, in.count, [&](size_t i) { return in.index[i]; });
    const Rows places = rows_from(first, in.count, [&](size_t i) { return static_cast<uint32_t>(i); });
    Pack<T> sums[kPairSlots];
    load_rows(in.sums, places, kPairSlots, sums);
    for (Pack<T>& sum : sums) sum = where(used_lanes<T>(rows), sum);
    project_adjoint_lanes(in, view, rows, sums, out, wide);
  }
  Pack<T> entries[15];
  T total[15];
  __builtin_memcpy(entries, &wide, sizeof entries);
  sum_lanes(entries, 15, total);
  for (int k = 0; k < 9; ++k) adj_view.R[k / 3][k % 3] += total[k];
  for (int k = 0; k < 3; ++k) {
    adj_view.t[k] += total[9 + k];
    adj_view.centre[k] += total[12 + k];
  }
}

}  // namespace pliant::PLIANT_ISA

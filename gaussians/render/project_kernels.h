#pragma once

#include "gaussians/render/blend.h"
#include "gaussians/render/pack_rows.h"
#include "gaussians/render/sh_basis.h"
#include "gaussians/simd/pack_math.h"

// From Gaussians to splats.  Here the lanes of a pack are Gaussians.

namespace pliant::PLIANT_ISA {

/// A camera, each number in all lanes.
template <class T>
struct WideView {
  PackMatrix<T> R;
  Pack3<T> t, centre;
  Pack<T> fx, fy, cx, cy, low_x, high_x, low_y, high_y, blur;

  INLINE explicit WideView(const View<T>& v) {
    for (int i = 0; i < 3; ++i) R.row[i] = everywhere(v.R[i]);
    t = everywhere(v.t);
    centre = everywhere(v.centre);
    const Pack<T> zero{};
    fx = zero + v.fx;
    fy = zero + v.fy;
    cx = zero + v.cx;
    cy = zero + v.cy;
    low_x = zero + v.low_x;
    high_x = zero + v.high_x;
    low_y = zero + v.low_y;
    high_y = zero + v.high_y;
    blur = zero + v.blur;
  }
};

template <class T>
INLINE Pack3<T> load_vectors(const T* from, const Rows& rows) {
  Pack<T> v[3];
  load_rows(from, rows, 3, v);
  return {v[0], v[1], v[2]};
}

/// Rotation of a quaternion of any length; a zero one means no rotation.
template <class T>
struct Rotation {
  Pack<T> w, x, y, z;    ///< of length 1
  Pack<T> inverse_norm;  ///< of the quaternion as it is stored; 0 for a zero one
  PackMatrix<T> R;
};

template <class T>
INLINE Rotation<T> load_rotation(const T* from, const Rows& rows) {
  Pack<T> wxyz[4];
  load_rows(from, rows, 4, wxyz);
  Rotation<T> out;
  const Pack<T> squared = fma(wxyz[3], wxyz[3], fma(wxyz[2], wxyz[2], fma(wxyz[1], wxyz[1], wxyz[0] * wxyz[0])));
  const Mask<T> turned = squared != Pack<T>{};
  out.inverse_norm = where(turned, T(1) / square_root(squared));
  const Pack<T> w = turned ? wxyz[0] * out.inverse_norm : Pack<T>{} + T(1);
  const Pack<T> x = wxyz[1] * out.inverse_norm, y = wxyz[2] * out.inverse_norm, z = wxyz[3] * out.inverse_norm;
  out.w = w;
  out.x = x;
  out.y = y;
  out.z = z;
  out.R.row[0] = {1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)};
  out.R.row[1] = {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)};
  out.R.row[2] = {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)};
  return out;
}

/// Derivatives with respect to the stored quaternion from those, G, with respect to the entries of R.
template <class T>
INLINE void rotation_adjoint(const Rotation<T>& at, const PackMatrix<T>& G, Pack<T>* adj_wxyz) {
  const Pack<T> w = at.w, x = at.x, y = at.y, z = at.z;
  const Pack3<T>&r0 = G.row[0], &r1 = G.row[1], &r2 = G.row[2];
  const Pack3<T> turn = {r2.y - r1.z, r0.z - r2.x, r1.x - r0.y}, mixed = {r2.y + r1.z, r0.z + r2.x, r1.x + r0.y};
  const Pack<T> aw = x * turn.x + y * turn.y + z * turn.z;
  const Pack<T> ax = y * mixed.z + z * mixed.y + w * turn.x - 2 * x * (r1.y + r2.z);
  const Pack<T> ay = x * mixed.z + z * mixed.x + w * turn.y - 2 * y * (r0.x + r2.z);
  const Pack<T> az = x * mixed.y + y * mixed.x + w * turn.z - 2 * z * (r0.x + r1.y);
  // 2 dR/dq is tangent already up to the part along q, which the normalisation takes away.
  const Pack<T> along = w * aw + x * ax + y * ay + z * az, scale = 2 * at.inverse_norm;
  adj_wxyz[0] = scale * (aw - along * w);
  adj_wxyz[1] = scale * (ax - along * x);
  adj_wxyz[2] = scale * (ay - along * y);
  adj_wxyz[3] = scale * (az - along * z);
}

/// Projected Gaussian: mean in pixels (the centre of pixel (i, j) is (i + 0.5, j + 0.5)), and 2D covariance.
template <class T>
struct Footprint {
  Pack3<T> p;                  ///< in the camera frame
  Pack<T> x, y, u, v;          ///< p_x / p_z, p_y / p_z, and in pixels
  Mask<T> inside_x, inside_y;  ///< whether x and y lie in the widened frustum
  Pack<T> held_x, held_y;      ///< held inside it
  Pack<T> scale_x, scale_y;    ///< fx / p_z, fy / p_z
  Pack3<T> jx, jy;             ///< du/dposition, dv/dposition in world axes, at held_x and held_y
  Pack3<T> mx, my, normal;     ///< A^T jx, A^T jy with covariance A A^T, and their cross product
  Pack<T> xx, xy, yy;          ///< covariance including the low-pass filter (px^2)
  Pack<T> sharp, determinant;  ///< determinant without and with the filter
};

/// Elliptical weighted average projection (Zwicker et al. 2001, eq. 31) with A = R diag(scale) and the Jacobian of the
/// pinhole projection at the mean.  Determinants are summed from non-negative terms (Binet and Cauchy), so that thin
/// splats keep theirs.
template <class T>
INLINE Footprint<T> footprint(const WideView<T>& view, const Pack3<T>& p, const PackMatrix<T>& R,
                              const Pack3<T>& scale) {
  Footprint<T> f;
  f.p = p;
  f.x = p.x / p.z;
  f.y = p.y / p.z;
  f.u = fma(view.fx, f.x, view.cx);
  f.v = fma(view.fy, f.y, view.cy);
  f.inside_x = (f.x >= view.low_x) & (f.x <= view.high_x);
  f.inside_y = (f.y >= view.low_y) & (f.y <= view.high_y);
  f.held_x = lower(higher(f.x, view.low_x), view.high_x);
  f.held_y = lower(higher(f.y, view.low_y), view.high_y);
  f.scale_x = view.fx / p.z;
  f.scale_y = view.fy / p.z;
  f.jx = f.scale_x * fma(-f.held_x, view.R.row[2], view.R.row[0]);
  f.jy = f.scale_y * fma(-f.held_y, view.R.row[2], view.R.row[1]);
  f.mx = product(scale, transposed(R, f.jx));
  f.my = product(scale, transposed(R, f.jy));
  f.normal = cross(f.mx, f.my);
  const Pack<T> blur = view.blur;
  const Pack<T> xx = dot(f.mx, f.mx), yy = dot(f.my, f.my);
  f.xx = xx + blur;
  f.yy = yy + blur;
  f.xy = dot(f.mx, f.my);
  f.sharp = dot(f.normal, f.normal);
  f.determinant = f.sharp + blur * (xx + yy) + blur * blur;
  return f;
}

/// Unit direction from the camera to a Gaussian, and 1 / distance; zero at the camera itself.
template <class T>
struct Direction {
  Pack3<T> d;
  Pack<T> inverse_length;
};
template <class T>
INLINE Direction<T> direction(const Pack3<T>& ray) {
  const Pack<T> squared = dot(ray, ray), inverse = where(squared > Pack<T>{}, T(1) / square_root(squared));
  return {inverse * ray, inverse};
}

/// Tiles [first, last] along one axis of pixels low..high, held to the `tiles` of the picture.
template <class T>
INLINE void tile_range(Pack<T> low, Pack<T> high, int tiles, Mask<T>& first, Mask<T>& last) {
  const Pack<T> zero{}, end = zero + T(tiles * kTileSize);
  const Mask<T> most = Mask<T>{} + (tiles - 1);
  first = lower(whole(lower(higher(low, zero), end)) / kTileSize, most);
  last = lower(whole(lower(higher(high, zero), end)) / kTileSize, most);
}

/// Appends the splats of the Gaussians in the lanes that can be seen; returns the end.
template <class T, bool kCutOffs>
INLINE Splat<T>* project_lanes(const ProjectInput<T>& in, const WideView<T>& view, const Rows& rows, Splat<T>* out) {
  using V = Pack<T>;
  constexpr T kMargin = T(0.02), kReachMargin = T(2e-3);
  constexpr T kLog2Of255 = T(7.994353436858858), kLog2E = T(1.4426950408889634);
  const Pack3<T> position = load_vectors(in.cloud.position, rows), p = view.R * position + view.t;
  Mask<T> seen = used_lanes<T>(rows) & (p.z > V{} + T(splat::kNear));
  if (!lane_bits(seen)) return out;

  const Pack3<T> log_scale = load_vectors(in.cloud.log_scale, rows);
  const Pack3<T> scale = {exponential(log_scale.x), exponential(log_scale.y), exponential(log_scale.z)};
  const Footprint<T> f = footprint(view, p, load_rotation(in.cloud.rotation, rows).R, scale);
  // One sum that is infinite or NaN if anything in the footprint is.
  seen &= finite(f.u + f.v + p.z + f.determinant / f.yy);
  V opacity;
  load_rows(in.cloud.opacity_logit, rows, 1, &opacity);
  opacity = T(1) / (T(1) + exponential(-opacity));
  if (in.antialiased) opacity *= square_root(higher(f.sharp / f.determinant, V{} + T(splat::kMinCompensation)));
  seen &= opacity >= V{} + (kCutOffs ? T(splat::kMinAlpha) : T(0));

  const V log2_opacity = logarithm2(opacity);
  const T width = T(in.view.width), height = T(in.view.height);
  V low_x{}, high_x = V{} + width, low_y{}, high_y = V{} + height;
  if (kCutOffs) {
    const V reach = (2 / kLog2E) * (log2_opacity + (kLog2Of255 + kReachMargin));
    const V half_x = square_root(reach * f.xx) + kMargin, half_y = square_root(reach * f.yy) + kMargin;
    low_x = f.u - half_x;
    high_x = f.u + half_x;
    low_y = f.v - half_y;
    high_y = f.v + half_y;
    seen &= (high_x >= V{}) & (low_x <= V{} + width) & (high_y >= V{}) & (low_y <= V{} + height);
  }
  if (!lane_bits(seen)) return out;

  V sh[3 * kMaxShCount], color[3];
  load_rows(in.cloud.sh, rows, 3 * (in.cloud.sh_degree + 1) * (in.cloud.sh_degree + 1), sh);
  const Pack3<T> d = direction(position - view.centre).d;
  sh_color<T>(in.cloud.sh_degree, sh, d.x, d.y, d.z, color);
  seen &= finite(color[0] + color[1] + color[2]);

  const V inverse_yy = T(1) / f.yy, half = V{} + kLog2E / 2;
  const V field[10] = {
      f.u,          f.v,      p.z,      f.xy * inverse_yy, half * (f.yy / f.determinant), half * inverse_yy,
      log2_opacity, color[0], color[1], color[2]};
  Mask<T> tile[4];
  tile_range<T>(low_x, high_x, (in.view.width + kTileSize - 1) / kTileSize, tile[0], tile[1]);
  tile_range<T>(low_y, high_y, (in.view.height + kTileSize - 1) / kTileSize, tile[2], tile[3]);
  for (uint32_t left = lane_bits(seen); left; left &= left - 1, ++out) {
    const int i = __builtin_ctz(left);
    const auto at = [&](int k) { return static_cast<uint16_t>(tile[k][i]); };
    *out = {field[0][i], field[1][i], field[2][i], field[3][i],
            field[4][i], field[5][i], field[6][i], {field[7][i], field[8][i], field[9][i]},
            rows.of[i],  at(0),       at(1),       at(2),
            at(3)};
  }
  return out;
}

template <class T, bool kCutOffs>
size_t project(const ProjectInput<T>& in, Splat<T>* out) {
  const WideView<T> view(in.view);
  Splat<T>* next = out;
  for (size_t first = in.begin; first < in.end; first += kLanes) {
    const Rows rows = rows_from(first, in.end, [](size_t i) { return static_cast<uint32_t>(i); });
    next = project_lanes<T, kCutOffs>(in, view, rows, next);
  }
  return static_cast<size_t>(next - out);
}

}  // namespace pliant::PLIANT_ISA

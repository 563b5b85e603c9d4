#pragma once

#include "gaussians/render/spherical_harmonics.h"
#include "gaussians/render/splat_kernels.h"

namespace pliant {

constexpr double kLog2E = 1.4426950408889634;

/// The splat of Gaussian i.  False when it cannot be seen: behind the camera, outside the picture, fainter than the
/// smallest alpha, or not finite.  Its tiles are those of the box around the ellipse alpha >= 1/255; without cut-offs
/// all tiles.
template <class T, bool kCutOffs>
bool gaussian_splat(const CloudOf<T>& cloud, uint32_t i, const View<T>& view, bool antialiased, Splat<T>& out) {
  constexpr T kMargin = T(0.02), kReachMargin = T(2e-3), kLog2Of255 = T(7.994353436858858);
  Footprint<T> f;
  if (!project(view, cloud.position[i], covariance_factor<T>(cloud.rotation[i], cloud.log_scale[i]), f)) return false;
  T opacity = 1 / (1 + std::exp(-cloud.opacity_logit[i]));
  if (antialiased) opacity *= f.compensation;
  if (!(opacity >= (kCutOffs ? T(splat::kMinAlpha) : T(0)))) return false;
  out.u = f.u, out.v = f.v, out.depth = f.depth;
  out.slope = f.xy / f.yy;
  out.precision_x = T(0.5 * kLog2E) * (f.yy / f.determinant);
  out.precision_y = T(0.5 * kLog2E) / f.yy;
  out.log2_opacity = std::log2(opacity);
  out.index = i;
  const int tiles_x = (view.width + kTileSize - 1) / kTileSize, tiles_y = (view.height + kTileSize - 1) / kTileSize;
  T low_x = 0, high_x = T(view.width), low_y = 0, high_y = T(view.height);
  if (kCutOffs) {
    const T reach = T(2 / kLog2E) * (out.log2_opacity + kLog2Of255 + kReachMargin);
    const T half_x = std::sqrt(reach * f.xx) + kMargin, half_y = std::sqrt(reach * f.yy) + kMargin;
    low_x = out.u - half_x, high_x = out.u + half_x, low_y = out.v - half_y, high_y = out.v + half_y;
    if (!(high_x >= 0 && low_x <= T(view.width) && high_y >= 0 && low_y <= T(view.height))) return false;
  }
  const auto tile = [](T at, int tiles) {
    const T held = at < 0 ? T(0) : at > T(tiles * kTileSize) ? T(tiles * kTileSize) : at;
    return static_cast<uint16_t>(std::min(static_cast<int>(held) / kTileSize, tiles - 1));
  };
  out.first_column = tile(low_x, tiles_x), out.last_column = tile(high_x, tiles_x);
  out.first_row = tile(low_y, tiles_y), out.last_row = tile(high_y, tiles_y);
  const Vec3<T> color = sh_color<T>(cloud.sh_degree, cloud.sh_of(i), (cloud.position[i] - view.centre).normalized());
  for (int c = 0; c < 3; ++c) out.color[c] = color[c];
  return std::isfinite(color.sum());
}

/// Derivatives with respect to one Gaussian and, as free entries, to the camera.
template <class T>
struct GaussianGradient {
  Vec3<T> position = Vec3<T>::Zero();
  Eigen::Matrix<T, 4, 1> rotation = Eigen::Matrix<T, 4, 1>::Zero();
  Vec3<T> log_scale = Vec3<T>::Zero();
  T opacity_logit = 0;
  T sh[3 * kMaxShCount] = {};
  Mat3<T> covariance = Mat3<T>::Zero();  ///< the same information as rotation and log_scale, as a symmetric matrix
  ViewGradient<T> view;
};

/// Derivatives for those of its splat, which come as sums over its pixels (see PairSlot).
template <class T>
GaussianGradient<T> gaussian_splat_adjoint(const CloudOf<T>& cloud, uint32_t i, const View<T>& view, bool antialiased,
                                           const T* sums) {
  GaussianGradient<T> out;
  Footprint<T> f, adj{};
  const Mat3<T> A = covariance_factor<T>(cloud.rotation[i], cloud.log_scale[i]);
  if (!project(view, cloud.position[i], A, f)) return out;

  // ln(alpha) = ln(opacity) - h_x e^2 - h_y d^2, h_x = yy / (2 determinant), h_y = 1 / (2 yy), slope = xy / yy.
  const T slope = f.xy / f.yy, hx = T(0.5) * (f.yy / f.determinant), hy = T(0.5) / f.yy;
  adj.u = 2 * hx * sums[kMomentE];
  adj.v = 2 * (hy * sums[kMomentD] - slope * hx * sums[kMomentE]);
  const T adj_slope = 2 * hx * sums[kMomentED];
  adj.xy = adj_slope / f.yy;
  adj.yy = (2 * hy * hy * sums[kMomentDD] - adj_slope * slope / f.yy) - sums[kMomentEE] * (T(0.5) / f.determinant);
  adj.determinant = sums[kMomentEE] * hx / f.determinant;
  adj.depth = sums[kAdjDepth];
  if (antialiased) adj.compensation = sums[kMoment] / f.compensation;
  const T sigmoid_of_negative = 1 / (1 + std::exp(cloud.opacity_logit[i]));
  out.opacity_logit = sums[kMoment] * sigmoid_of_negative;

  Mat3<T> adj_A = Mat3<T>::Zero();
  project_adjoint(view, cloud.position[i], A, f, adj, out.position, adj_A, out.view);
  covariance_factor_adjoint<T>(cloud.rotation[i], cloud.log_scale[i], A, adj_A, out.rotation, out.log_scale);
  out.covariance = project_adjoint_covariance(view, cloud.position[i], A, f, adj);

  const Vec3<T> ray = cloud.position[i] - view.centre;
  const T length = ray.norm();
  const Vec3<T> d = ray.normalized(), adj_color(sums[kAdjColor], sums[kAdjColor + 1], sums[kAdjColor + 2]);
  Vec3<T> adj_d;
  sh_color_adjoint<T>(cloud.sh_degree, cloud.sh_of(i), d, adj_color, out.sh, adj_d);
  if (length > T(0)) {
    const Vec3<T> adj_ray = (adj_d - d * d.dot(adj_d)) / length;
    out.position += adj_ray;
    out.view.centre -= adj_ray;
  }
  return out;
}

}  // namespace pliant

#pragma once

#include <span>
#include <vector>

#include "gaussians/base/types.h"

namespace pliant {

/// N Gaussians with the parameters of 3DGS (Kerbl et al. 2023) in their stored spaces, in scene units.  The derivative
/// of a scalar with respect to a cloud has the same shape and is kept in the same type.
template <class T>
struct CloudOf {
  std::vector<Vec3<T>> position;                 ///< [N, 3]
  std::vector<Eigen::Matrix<T, 4, 1>> rotation;  ///< [N, 4] quaternion w, x, y, z; need not be normalised
  std::vector<Vec3<T>> log_scale;                ///< [N, 3] natural logarithm of the standard deviations
  std::vector<T> opacity_logit;                  ///< [N]
  std::vector<T> sh;                             ///< [N, K, 3], K = (sh_degree + 1)^2; colour = 0.5 + sum of basis * sh
  int sh_degree = 0;                             ///< 0..3

  size_t size() const { return position.size(); }
  int sh_count() const { return (sh_degree + 1) * (sh_degree + 1); }
  T* sh_of(size_t i) { return sh.data() + i * sh_count() * 3; }
  const T* sh_of(size_t i) const { return sh.data() + i * sh_count() * 3; }

  /// New Gaussians lie at the origin, unrotated, with all other parameters zero.
  void resize(size_t n) {
    position.resize(n, Vec3<T>::Zero());
    rotation.resize(n, Eigen::Matrix<T, 4, 1>(1, 0, 0, 0));
    log_scale.resize(n, Vec3<T>::Zero());
    opacity_logit.resize(n, T(0));
    sh.resize(n * sh_count() * 3, T(0));
  }
};

/// The cloud as it is kept, read and written.
struct GaussianCloud : CloudOf<float> {
  /// Gaussians at `indices`, in that order.
  GaussianCloud select(std::span<const int> indices) const;
  /// Appends `other`; the lower SH degree is padded with zeros.
  void append(const GaussianCloud& other);
  Box bounds() const;
};

/// The cloud with spherical harmonics cut or padded with zeros to `degree`.
GaussianCloud with_sh_degree(const GaussianCloud& cloud, int degree);

constexpr float kSh0 = 0.28209479177387814f;

/// Colour that a DC coefficient of the spherical harmonics gives alone, not clamped to 0..1, and the reverse.
inline float dc_color(float sh) { return 0.5f + kSh0 * sh; }
inline float sh_of_color(float color) { return (color - 0.5f) / kSh0; }
/// Of the three coefficients at `sh`: red, green, blue.
inline Vec3f dc_color(const float* sh) { return {dc_color(sh[0]), dc_color(sh[1]), dc_color(sh[2])}; }

inline float sigmoid(float x) { return 1.0f / (1.0f + std::exp(-x)); }
inline float logit(float p) { return std::log(p / (1.0f - p)); }

/// Rotation matrix of a quaternion w, x, y, z of any length.
template <class T>
Mat3<T> rotation_matrix(const Eigen::Matrix<T, 4, 1>& wxyz) {
  const Eigen::Matrix<T, 4, 1> q = wxyz / wxyz.norm();
  const T w = q[0], x = q[1], y = q[2], z = q[3];
  Mat3<T> R;
  R << 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y), 2 * (x * y + w * z), 1 - 2 * (x * x + z * z),
      2 * (y * z - w * x), 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y);
  return R;
}

/// Unit quaternion w, x, y, z of a rotation matrix; the only place where Eigen's x, y, z, w order is met.
Vec4f quaternion_wxyz(const Mat3f& rotation);
Eigen::Vector4d quaternion_wxyz(const Mat3d& rotation);

}  // namespace pliant

#pragma once

#include "gaussians/base/polar.h"

namespace pliant {

/// Rotation and translation carried by a Gaussian's drivers: x = R (x_rest - rest) + now.
template <class T>
struct RigidFit {
  Mat3<T> R;
  Vec3<T> rest, now;  ///< weighted means of the drivers
  Mat3<T> F;          ///< weighted mean of their deformation gradients
};

/// Share of the drivers' own rotation in the fit; it decides what the positions leave open (the twist of a cord).
constexpr double kTwistShare = 0.1;

/// Weighted rigid fit of `count` drivers (weights sum to 1): R is the polar factor of
/// H = sum w (x - c)(x0 - c0)^T + kTwistShare l^2 sum w F, with l^2 = sum w |x0 - c0|^2 in the place of dx^2.
template <class T>
HOST_DEVICE RigidFit<T> fit_rigid(int count, const T* weight, const Vec3<T>* rest, const Vec3<T>* now,
                                  const Mat3<T>* F) {
  RigidFit<T> fit{Mat3<T>::Zero(), Vec3<T>::Zero(), Vec3<T>::Zero(), Mat3<T>::Zero()};
  for (int j = 0; j < count; ++j) {
    fit.rest += weight[j] * rest[j], fit.now += weight[j] * now[j];
    fit.F += weight[j] * F[j];
  }
  Mat3<T> H = Mat3<T>::Zero();
  T spread = 0;
  for (int j = 0; j < count; ++j) {
    const Vec3<T> from = rest[j] - fit.rest;
    H += weight[j] * (now[j] - fit.now) * from.transpose();
    spread += weight[j] * from.squaredNorm();
  }
  fit.R = spread > T(0) ? polar_rotation<T>(H / spread + T(kTwistShare) * fit.F) : polar_rotation<T>(fit.F);
  return fit;
}

/// F with its principal stretches kept within [1 / limit, limit] and inversions undone.
template <class T>
HOST_DEVICE Mat3<T> limit_stretch(const Mat3<T>& F, T limit) {
  // Every singular value lies within the limits when |F|^2 and |F^-1|^2 are at most limit^2.
  const Mat3<T> C = cofactor(F);
  const T determinant = F.col(0).dot(C.col(0));
  const T most = limit * limit;
  if (determinant > T(0) && F.squaredNorm() <= most && C.squaredNorm() <= most * determinant * determinant) return F;
  const Svd<T> s = svd(F);
  Vec3<T> sigma;
  for (int i = 0; i < 3; ++i) sigma[i] = s.sigma[i] < 1 / limit ? 1 / limit : s.sigma[i] > limit ? limit : s.sigma[i];
  return s.U * sigma.asDiagonal() * s.V.transpose();
}

/// Refactors A into axes (a rotation) and lengths with A A^T = axes diag(lengths)^2 axes^T, by rotating pairs of
/// columns until they are orthogonal (one-sided Jacobi, Hestenes 1958), which keeps the relative precision of small
/// lengths. Columns that are orthogonal already keep their order and direction.
template <class T>
HOST_DEVICE void principal_axes(Mat3<T> A, Mat3<T>& axes, Vec3<T>& length) {
  for (int sweep = 0; sweep < 10; ++sweep) {
    bool turned = false;
    for (int p = 0; p < 2; ++p) {
      for (int q = p + 1; q < 3; ++q) {
        const T a = A.col(p).squaredNorm(), b = A.col(q).squaredNorm(), c = A.col(p).dot(A.col(q));
        if (!(std::abs(c) > 4 * Eigen::NumTraits<T>::epsilon() * std::sqrt(a) * std::sqrt(b))) continue;
        turned = true;
        const T zeta = (b - a) / (2 * c);
        const T t = (zeta >= T(0) ? T(1) : T(-1)) / (std::abs(zeta) + std::sqrt(zeta * zeta + 1));
        const T cosine = 1 / std::sqrt(t * t + 1), sine = t * cosine;
        const Vec3<T> x = A.col(p), y = A.col(q);
        A.col(p) = cosine * x - sine * y, A.col(q) = sine * x + cosine * y;
      }
    }
    if (!turned) break;
  }
  int longest = 0;
  for (int i = 0; i < 3; ++i) {
    length[i] = A.col(i).norm();
    if (length[i] > length[longest]) longest = i;
  }
  // The two longer columns give directions, the third one closes a right-handed frame.
  const int i = (longest + 1) % 3, j = (longest + 2) % 3, second = length[i] >= length[j] ? i : j;
  if (!(length[second] > T(0))) {
    axes.setIdentity();
    return;
  }
  axes.col(longest) = A.col(longest) / length[longest], axes.col(second) = A.col(second) / length[second];
  const int third = 3 - longest - second;
  axes.col(third) = axes.col((third + 1) % 3).cross(axes.col((third + 2) % 3));
}

}  // namespace pliant

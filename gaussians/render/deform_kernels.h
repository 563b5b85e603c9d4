#pragma once

#include "gaussians/base/spectral.h"
#include "gaussians/render/deform.h"

namespace pliant {

/// Rotation and translation carried by a Gaussian's drivers: x = R (x_rest - rest) + now.
template <class T>
struct RigidFit {
  Mat3<T> R;
  Vec3<T> rest, now;  ///< weighted means of the drivers
  Mat3<T> F;          ///< weighted mean of their deformation gradients
  Mat3<T> H;          ///< R is the polar factor of this
  T spread;           ///< weighted mean squared distance of the drivers from `rest`
};

/// Share of the drivers' own rotation in the fit; it decides what the positions leave open (the twist of a cord).
constexpr double kTwistShare = 0.1;

/// Weighted rigid fit of `count` drivers (weights sum to 1): R is the polar factor of
/// H = sum w (x - c)(x0 - c0)^T + kTwistShare l^2 sum w F, with l^2 = sum w |x0 - c0|^2 in the place of dx^2.
template <class T>
HOST_DEVICE RigidFit<T> fit_rigid(int count, const T* weight, const Vec3<T>* rest, const Vec3<T>* now,
                                  const Mat3<T>* F) {
  RigidFit<T> fit{Mat3<T>::Zero(), Vec3<T>::Zero(), Vec3<T>::Zero(), Mat3<T>::Zero(), Mat3<T>::Zero(), T(0)};
  for (int j = 0; j < count; ++j) {
    fit.rest += weight[j] * rest[j];
    fit.now += weight[j] * now[j];
    fit.F += weight[j] * F[j];
  }
  for (int j = 0; j < count; ++j) {
    const Vec3<T> from = rest[j] - fit.rest;
    fit.H += weight[j] * (now[j] - fit.now) * from.transpose();
    fit.spread += weight[j] * from.squaredNorm();
  }
  if (fit.spread > T(0))
    fit.H = fit.H / fit.spread + T(kTwistShare) * fit.F;
  else
    fit.H = fit.F;
  fit.R = polar_rotation<T>(fit.H);
  return fit;
}

/// The drivers of one Gaussian, or of another point that is bound to them, gathered.
template <class T>
struct GatheredDrivers {
  int count = 0;
  T weight[Binding::kCount];
  Vec3<T> rest[Binding::kCount], now[Binding::kCount];
  Mat3<T> F[Binding::kCount];

  GatheredDrivers(const Binding& binding, std::ptrdiff_t g, std::span<const Vec3<T>> drivers_rest,
                  std::span<const Vec3<T>> drivers_now, std::span<const Mat3<T>> gradients) {
    for (; count < Binding::kCount; ++count) {
      const int d = binding.driver[g * Binding::kCount + count];
      if (d < 0) break;
      weight[count] = T(binding.weight[g * Binding::kCount + count]);
      rest[count] = drivers_rest[d];
      now[count] = drivers_now[d];
      F[count] = gradients[d];
    }
  }
  RigidFit<T> fit() const { return fit_rigid<T>(count, weight, rest, now, F); }
};

/// Derivatives with respect to the drivers of a fit: weight_j (moment (rest_j - fit.rest) + now) for the position of
/// driver j, weight_j F for its deformation gradient.
template <class T>
struct RigidFitAdjoint {
  Mat3<T> moment, F;
  Vec3<T> now;
};

/// From derivatives with respect to R, now and F of the fit.
template <class T>
HOST_DEVICE RigidFitAdjoint<T> fit_rigid_adjoint(int count, const T* weight, const Vec3<T>* rest,
                                                 const RigidFit<T>& fit, const Mat3<T>& adj_R, const Vec3<T>& adj_now,
                                                 const Mat3<T>& adj_F) {
  // The map from a change of H to one of R is its own adjoint.
  const Mat3<T> RtH = fit.R.transpose() * fit.H;
  const Mat3<T> adj_H = polar_rotation_derivative<T>({fit.R, T(0.5) * (RtH + RtH.transpose())}, adj_R);
  if (!(fit.spread > T(0))) return {Mat3<T>::Zero(), adj_F + adj_H, adj_now};
  RigidFitAdjoint<T> adj{adj_H / fit.spread, adj_F + T(kTwistShare) * adj_H, adj_now};
  // What `now` does in H; it vanishes up to rounding, because the weights sum to 1.
  for (int j = 0; j < count; ++j) adj.now -= weight[j] * (adj.moment * (rest[j] - fit.rest));
  return adj;
}

/// Whether the principal stretches of F surely lie within [1 / limit, limit], without an SVD: |F|^2 and |F^-1|^2 are
/// at most limit^2.
template <class T>
HOST_DEVICE bool stretch_is_moderate(const Mat3<T>& F, T limit) {
  const Mat3<T> C = cofactor(F);
  const T determinant = F.col(0).dot(C.col(0)), most = limit * limit;
  return determinant > T(0) && F.squaredNorm() <= most && C.squaredNorm() <= most * determinant * determinant;
}

/// F with its principal stretches kept within [1 / limit, limit] and inversions undone.
template <class T>
HOST_DEVICE Mat3<T> limit_stretch(const Mat3<T>& F, T limit) {
  if (stretch_is_moderate(F, limit)) return F;
  const Svd<T> s = svd(F);
  return s.U * s.sigma.cwiseMax(1 / limit).cwiseMin(limit).asDiagonal() * s.V.transpose();
}

/// Derivative with respect to F; stretches beyond the limits take none.
template <class T>
HOST_DEVICE Mat3<T> limit_stretch_adjoint(const Mat3<T>& F, T limit, const Mat3<T>& adj_limited) {
  if (stretch_is_moderate(F, limit)) return adj_limited;
  const Svd<T> s = svd(F);
  const Vec3<T> limited = s.sigma.cwiseMax(1 / limit).cwiseMin(limit);
  Vec3<T> slope;
  for (int i = 0; i < 3; ++i) slope[i] = T(limited[i] == s.sigma[i]);
  return spectral_adjoint<T>(s, limited, slope.asDiagonal(), adj_limited);
}

/// A Gaussian grows or shrinks at most by this factor along an axis; beyond it, the picture would show the solver's
/// strain at single particles as needles.
constexpr double kStretchLimit = 4;

/// Position of a Gaussian that lies at x at rest.
template <class T>
HOST_DEVICE Vec3<T> carried_position(const DeformOptions& options, const RigidFit<T>& fit, const Vec3<T>& x) {
  if (options.mean_displacement) return x + (fit.now - fit.rest);
  return fit.R * (x - fit.rest) + fit.now;
}

/// Matrix that takes the covariance at rest along: covariance = M covariance_rest M^T.
template <class T>
HOST_DEVICE Mat3<T> carried_frame(const DeformOptions& options, const RigidFit<T>& fit) {
  return options.stretch ? limit_stretch<T>(fit.F, T(kStretchLimit)) : fit.R;
}

/// Derivatives with respect to a fit of the carried position and covariance; adj_R is taken as it comes, which is where
/// that of rotated spherical harmonics goes, and added to.  adj_covariance: d L / d covariance, entry by entry.
template <class T>
HOST_DEVICE void carried_adjoint(const DeformOptions& options, const RigidFit<T>& fit, const Vec3<T>& x,
                                 const Mat3<T>& covariance_rest, const Vec3<T>& adj_position,
                                 const Mat3<T>& adj_covariance, Mat3<T>& adj_R, Vec3<T>& adj_now, Mat3<T>& adj_F) {
  adj_now = adj_position;
  if (!options.mean_displacement) adj_R += adj_position * (x - fit.rest).transpose();
  const Mat3<T> M = carried_frame(options, fit);
  const Mat3<T> adj_M = (adj_covariance + adj_covariance.transpose()) * M * covariance_rest;
  adj_F.setZero();
  if (options.stretch)
    adj_F = limit_stretch_adjoint<T>(fit.F, T(kStretchLimit), adj_M);
  else
    adj_R += adj_M;
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
        A.col(p) = cosine * x - sine * y;
        A.col(q) = sine * x + cosine * y;
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
  axes.col(longest) = A.col(longest) / length[longest];
  axes.col(second) = A.col(second) / length[second];
  const int third = 3 - longest - second;
  axes.col(third) = axes.col((third + 1) % 3).cross(axes.col((third + 2) % 3));
}

}  // namespace pliant

#pragma once

#include "gaussians/base/random.h"
#include "gaussians/render/deform.h"
#include "gaussians/render/deform_kernels.h"
#include "gaussians/render/spherical_harmonics.h"
#include "gaussians/render/splat_kernels.h"

namespace pliant::made_motion {

using Values = std::vector<double>;

template <class M>
void append(Values& out, const M& m) {
  out.insert(out.end(), m.data(), m.data() + m.size());
}

inline Mat3d random_matrix(Random& random) {
  Mat3d M;
  for (int k = 0; k < 9; ++k) M.data()[k] = random.normal();
  return M;
}

inline Mat3d random_rotation(Random& random) { return polar_rotation<double>(random_matrix(random)); }

/// Drivers at rest, and where they are now.
struct Motion {
  const char* name;
  std::vector<Vec3d> rest, now;
  std::vector<Mat3d> F;

  /// drivers_now, then F.
  Values values() const {
    Values x;
    for (const Vec3d& v : now) append(x, v);
    for (const Mat3d& M : F) append(x, M);
    return x;
  }
  void set(const Values& x) {
    for (size_t d = 0; d < rest.size(); ++d) {
      now[d] = Eigen::Map<const Vec3d>(x.data() + 3 * d);
      F[d] = Eigen::Map<const Mat3d>(x.data() + 3 * rest.size() + 9 * d);
    }
  }
};

inline Motion make_motion(const char* name, int count, bool on_a_line, const Mat3d& A, double noise) {
  Motion m{name, {}, {}, {}};
  for (int d = 0; d < count; ++d) {
    Random random(21, d);
    const Vec3d x(0.1 * d, random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3));
    m.rest.push_back(on_a_line ? Vec3d(x[0], 0, 0) : x);
    m.now.push_back(A * m.rest.back() + Vec3d(0.2, -0.1, 0.3) +
                    noise * Vec3d(random.normal(), random.normal(), random.normal()));
    m.F.push_back(A + noise * random_matrix(random));
  }
  return m;
}

inline std::vector<Motion> motions(int count) {
  Random random(22);
  const Mat3d R = random_rotation(random), S = random_rotation(random);
  const Mat3d beyond = R * Vec3d(0.1, 1.3, 7).asDiagonal() * S.transpose();
  const Mat3d blown = R * Vec3d(6, 6, 6).asDiagonal(), one_long = R * Vec3d(1, 1, 6).asDiagonal() * S.transpose();
  const Mat3d inverted = R * Vec3d(-0.4, 1.2, 1.8).asDiagonal() * S.transpose();
  return {make_motion("at rest", count, false, Mat3d::Identity(), 0),
          make_motion("turned", count, false, R, 0),
          make_motion("deformed", count, false, R, 0.1),
          make_motion("stem at rest", count, true, Mat3d::Identity(), 0),
          make_motion("bent stem", count, true, R, 0.02),
          make_motion("stretched beyond the limit", count, false, beyond, 0.03),
          make_motion("blown up alike", count, false, blown, 0),
          make_motion("one stretch beyond the limit", count, false, one_long, 0),
          make_motion("inverted", count, false, inverted, 0.01)};
}

inline Values weights(int count) {
  Values w;
  double total = 0;
  for (int d = 0; d < count; ++d) total += w.emplace_back(Random(23, d).uniform(0.2, 1));
  for (double& x : w) x /= total;
  return w;
}

/// A few Gaussians, one of which does not move, bound to 12 drivers.
struct Scene {
  CloudOf<double> rest;
  Binding binding;
};

inline Scene make_scene(int gaussians, int drivers, int degree) {
  Scene scene;
  scene.rest.sh_degree = degree;
  scene.rest.resize(gaussians);
  scene.binding.driver.assign(gaussians * Binding::kCount, -1);
  scene.binding.weight.assign(gaussians * Binding::kCount, 0.0f);
  for (int g = 0; g < gaussians; ++g) {
    Random random(26, g);
    for (int k = 0; k < 3; ++k) {
      scene.rest.position[g][k] = random.uniform(-0.5, 1);
      scene.rest.log_scale[g][k] = random.uniform(-2, 0);
    }
    for (int k = 0; k < 4; ++k) scene.rest.rotation[g][k] = random.normal();
    for (int k = 0; k < scene.rest.sh_count() * 3; ++k) scene.rest.sh_of(g)[k] = random.normal();
    if (g == 2) continue;
    const int count = g == 1 ? 1 : 8;
    const Values w = weights(count);
    for (int k = 0; k < count; ++k) {
      scene.binding.driver[g * Binding::kCount + k] = (5 * g + k) % drivers;
      scene.binding.weight[g * Binding::kCount + k] = static_cast<float>(w[k]);
    }
  }
  return scene;
}

/// What `deform` does, by the same kernels in double; rotation and log_scale are those of the principal axes.
inline CloudOf<double> carried(const DeformOptions& options, const Scene& scene, const Motion& m) {
  const ShRotation<double> rotation;
  CloudOf<double> out = scene.rest;
  for (size_t g = 0; g < scene.rest.size(); ++g) {
    double w[Binding::kCount];
    Vec3d from[Binding::kCount], to[Binding::kCount];
    Mat3d F[Binding::kCount];
    int count = 0;
    for (; count < Binding::kCount; ++count) {
      const int d = scene.binding.driver[g * Binding::kCount + count];
      if (d < 0) break;
      w[count] = scene.binding.weight[g * Binding::kCount + count];
      from[count] = m.rest[d];
      to[count] = m.now[d];
      F[count] = m.F[d];
    }
    if (count == 0) continue;
    const RigidFit<double> fit = fit_rigid<double>(count, w, from, to, F);
    const Mat3d A = covariance_factor<double>(scene.rest.rotation[g], scene.rest.log_scale[g]);
    Mat3d axes;
    Vec3d length;
    principal_axes<double>(carried_frame<double>(options, fit) * A, axes, length);
    const Eigen::Quaterniond q(axes);
    out.position[g] = carried_position<double>(options, fit, scene.rest.position[g]);
    out.rotation[g] = {q.w(), q.x(), q.y(), q.z()};
    out.log_scale[g] = length.array().log();
    rotation.apply(fit.R, scene.rest.sh_degree, out.sh_of(g));
  }
  return out;
}

/// Position [3], covariance [9] and, if asked for, spherical harmonics of every Gaussian.
inline Values flat(const CloudOf<double>& cloud, bool with_sh) {
  Values y;
  for (size_t g = 0; g < cloud.size(); ++g) {
    const Mat3d A = covariance_factor<double>(cloud.rotation[g], cloud.log_scale[g]);
    append(y, cloud.position[g]);
    append(y, Mat3d(A * A.transpose()));
    if (with_sh) y.insert(y.end(), cloud.sh_of(g), cloud.sh_of(g) + cloud.sh_count() * 3);
  }
  return y;
}

template <class T>
Values flat(const DeformGradientOf<T>& gradient) {
  Values out;
  for (const Vec3<T>& v : gradient.drivers_now) append(out, v);
  for (const Mat3<T>& M : gradient.F) append(out, M);
  return out;
}

}  // namespace pliant::made_motion

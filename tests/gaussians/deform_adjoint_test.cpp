// Derivatives of the deformation, kernel by kernel and as a whole, against differences in double: at rest (all
// stretches equal), in motion, beyond the limit of stretch, and for drivers on a line.

#include <gtest/gtest.h>

#include "gaussians/base/check_adjoint.h"
#include "gaussians/base/portable.h"
#include "gaussians/render/deform.h"
#include "gaussians/render/deform_kernels.h"
#include "gaussians/render/spherical_harmonics.h"
#include "gaussians/render/splat_kernels.h"

namespace pliant {
namespace {

using Values = std::vector<double>;

template <class M>
void append(Values& out, const M& m) {
  out.insert(out.end(), m.data(), m.data() + m.size());
}

Mat3d random_matrix(Random& random) {
  Mat3d M;
  for (int k = 0; k < 9; ++k) M.data()[k] = random.normal();
  return M;
}

Mat3d random_rotation(Random& random) { return polar_rotation<double>(random_matrix(random)); }

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

Motion make_motion(const char* name, int count, bool on_a_line, const Mat3d& A, double noise) {
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

std::vector<Motion> motions(int count) {
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

Values weights(int count) {
  Values w;
  double total = 0;
  for (int d = 0; d < count; ++d) total += w.emplace_back(Random(23, d).uniform(0.2, 1));
  for (double& x : w) x /= total;
  return w;
}

AdjointCheckOptions small_steps() {
  AdjointCheckOptions options;
  options.step = 2e-3;
  return options;
}

TEST(DeformAdjoint, RigidFitAgreesWithDifferences) {
  for (const int count : {1, 2, 8}) {
    const Values w = weights(count);
    for (Motion m : motions(count)) {
      const auto fit_at = [&](const Values& x) {
        m.set(x);
        return fit_rigid<double>(count, w.data(), m.rest.data(), m.now.data(), m.F.data());
      };
      const AdjointCheck check = check_adjoint(
          [&](const Values& x) {
            const RigidFit<double> fit = fit_at(x);
            Values y;
            append(y, fit.R), append(y, fit.now), append(y, fit.F);
            return y;
          },
          [&](const Values& x, const Values& y) {
            const RigidFit<double> fit = fit_at(x);
            const auto adj = fit_rigid_adjoint<double>(count, w.data(), m.rest.data(), fit, Mat3d(y.data()),
                                                       Vec3d(y.data() + 9), Mat3d(y.data() + 12));
            Values out;
            for (int j = 0; j < count; ++j) append(out, Vec3d(w[j] * (adj.moment * (m.rest[j] - fit.rest) + adj.now)));
            for (int j = 0; j < count; ++j) append(out, Mat3d(w[j] * adj.F));
            return out;
          },
          m.values(), small_steps());
      EXPECT_LT(check.worst, 1e-6) << m.name << ", " << count << " drivers: " << check.message;
    }
  }
}

TEST(DeformAdjoint, LimitOfStretchAgreesWithDifferencesBelowAndBeyond) {
  Random random(24);
  for (const Vec3d& sigma :
       {Vec3d(1, 1, 1), Vec3d(0.9, 1, 1.2), Vec3d(0.3, 1, 3), Vec3d(0.3, 0.3, 3.9), Vec3d(0.1, 1, 7), Vec3d(6, 6, 6),
        Vec3d(1, 1, 6), Vec3d(0.05, 0.05, 1), Vec3d(1, 6, 6 + 1e-9), Vec3d(1, 1 + 1e-9, 9), Vec3d(-0.5, 1, 2)}) {
    const Mat3d F = random_rotation(random) * sigma.asDiagonal() * random_rotation(random).transpose();
    Values x;
    append(x, F);
    const AdjointCheck check = check_adjoint(
        [](const Values& x) {
          Values y;
          append(y, limit_stretch<double>(Mat3d(x.data()), 4));
          return y;
        },
        [](const Values& x, const Values& y) {
          Values out;
          append(out, limit_stretch_adjoint<double>(Mat3d(x.data()), 4, Mat3d(y.data())));
          return out;
        },
        x, small_steps());
    EXPECT_LT(check.worst, 1e-6) << sigma.transpose() << ": " << check.message;
  }
}

TEST(DeformAdjoint, RotationOfSphericalHarmonicsAgreesWithDifferences) {
  const ShRotation<double> rotation;
  for (int degree = 0; degree <= 3; ++degree) {
    const int size = 3 * (degree + 1) * (degree + 1);
    Random random(25, degree);
    Values sh, x;
    for (int k = 0; k < size; ++k) sh.push_back(random.normal());
    append(x, random_rotation(random));
    const AdjointCheck check = check_adjoint(
        [&](const Values& x) {
          Values y = sh;
          rotation.apply(Mat3d(x.data()), degree, y.data());
          return y;
        },
        [&](const Values& x, const Values& y) {
          Mat3d adj = Mat3d::Zero();
          rotation.apply_adjoint(Mat3d(x.data()), degree, sh.data(), y.data(), adj);
          Values out;
          append(out, adj);
          return out;
        },
        x);
    EXPECT_LT(check.worst, 1e-8) << "degree " << degree << ": " << check.message;
  }
}

/// A few Gaussians, one of which does not move, bound to 12 drivers.
struct Scene {
  CloudOf<double> rest;
  Binding binding;
};

Scene make_scene(int gaussians, int drivers, int degree) {
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

/// Position, covariance and spherical harmonics of every Gaussian, by the same kernels as `deform`, in double.
Values deformed(const DeformOptions& options, const Scene& scene, const Motion& m, bool with_sh) {
  const ShRotation<double> rotation;
  Values y;
  for (size_t g = 0; g < scene.rest.size(); ++g) {
    const Mat3d A = covariance_factor<double>(scene.rest.rotation[g], scene.rest.log_scale[g]);
    Vec3d position = scene.rest.position[g];
    Mat3d covariance = A * A.transpose();
    Values sh(scene.rest.sh_of(g), scene.rest.sh_of(g) + scene.rest.sh_count() * 3);
    double w[Binding::kCount];
    Vec3d from[Binding::kCount], to[Binding::kCount];
    Mat3d F[Binding::kCount];
    int count = 0;
    for (; count < Binding::kCount; ++count) {
      const int d = scene.binding.driver[g * Binding::kCount + count];
      if (d < 0) break;
      w[count] = scene.binding.weight[g * Binding::kCount + count];
      from[count] = m.rest[d], to[count] = m.now[d], F[count] = m.F[d];
    }
    if (count > 0) {
      const RigidFit<double> fit = fit_rigid<double>(count, w, from, to, F);
      const Mat3d M = carried_frame<double>(options, fit) * A;
      position = carried_position<double>(options, fit, position), covariance = M * M.transpose();
      rotation.apply(fit.R, scene.rest.sh_degree, sh.data());
    }
    append(y, position), append(y, covariance);
    if (with_sh) append(y, sh);
  }
  return y;
}

/// Splits a cotangent of `deformed` and calls deform_adjoint.
template <class T>
DeformGradientOf<T> gradient_of(const DeformOptions& options, const Scene& scene, const Motion& m, const Values& y,
                                bool with_sh) {
  const size_t n = scene.rest.size(), sh_size = with_sh ? scene.rest.sh_count() * 3 : 0;
  std::vector<Vec3<T>> rest, now, position(n);
  std::vector<Mat3<T>> F, covariance(n);
  std::vector<T> sh;
  for (size_t d = 0; d < m.rest.size(); ++d) {
    rest.push_back(m.rest[d].cast<T>()), now.push_back(m.now[d].cast<T>()), F.push_back(m.F[d].cast<T>());
  }
  for (size_t g = 0; g < n; ++g) {
    const double* row = y.data() + g * (12 + sh_size);
    position[g] = Vec3d(row).cast<T>(), covariance[g] = Mat3d(row + 3).cast<T>();
    for (size_t k = 0; k < sh_size; ++k) sh.push_back(static_cast<T>(row[12 + k]));
  }
  return deform_adjoint<T>(options, cloud_cast<T>(scene.rest), scene.binding, rest, now, F, position, covariance, sh);
}

template <class T>
Values flat(const DeformGradientOf<T>& gradient) {
  Values out;
  for (const Vec3<T>& v : gradient.drivers_now) append(out, v);
  for (const Mat3<T>& M : gradient.F) append(out, M);
  return out;
}

class WholeDeform : public testing::TestWithParam<DeformOptions> {};

TEST_P(WholeDeform, AdjointAgreesWithDifferencesOfEveryMotion) {
  const DeformOptions options = GetParam();
  double worst = 0;
  for (const bool with_sh : {true, false}) {
    const Scene scene = make_scene(5, 12, with_sh ? 3 : 1);
    for (Motion m : motions(12)) {
      AdjointCheckOptions check_options = small_steps();
      check_options.unit_cotangents = 24;
      const AdjointCheck check = check_adjoint(
          [&](const Values& x) {
            m.set(x);
            return deformed(options, scene, m, with_sh);
          },
          [&](const Values& x, const Values& y) {
            m.set(x);
            return flat(gradient_of<double>(options, scene, m, y, with_sh));
          },
          m.values(), check_options);
      EXPECT_LT(check.worst, 1e-6) << m.name << ": " << check.message;
      worst = std::max(worst, check.worst);
    }
  }
  RecordProperty("worst_relative_error", testing::PrintToString(worst));
}

TEST_P(WholeDeform, DoubleKernelsGiveWhatDeformGivesInFloat) {
  const DeformOptions options = GetParam();
  const Scene scene = make_scene(40, 12, 3);
  for (const Motion& m : motions(12)) {
    const Values expected = deformed(options, scene, m, true);
    GaussianCloud rest, out;
    static_cast<CloudOf<float>&>(rest) = cloud_cast<float>(scene.rest);
    std::vector<Vec3f> from, to;
    std::vector<Mat3f> F;
    for (size_t d = 0; d < m.rest.size(); ++d)
      from.push_back(m.rest[d].cast<float>()), to.push_back(m.now[d].cast<float>()), F.push_back(m.F[d].cast<float>());
    deform(options, rest, scene.binding, from, to, F, out);
    for (size_t g = 0; g < rest.size(); ++g) {
      const double* row = expected.data() + g * 60;
      const Mat3f A = covariance_factor<float>(out.rotation[g], out.log_scale[g]);
      EXPECT_LT((out.position[g].cast<double>() - Vec3d(row)).norm(), 2e-5) << m.name;
      EXPECT_LT(((A * A.transpose()).cast<double>() - Mat3d(row + 3)).norm() / Mat3d(row + 3).norm(), 1e-4) << m.name;
      for (int k = 0; k < 48; ++k) EXPECT_NEAR(out.sh_of(g)[k], row[12 + k], 2e-4) << m.name;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Options, WholeDeform,
                         testing::Values(DeformOptions{true, false}, DeformOptions{false, false},
                                         DeformOptions{true, true}, DeformOptions{false, true}));

TEST(DeformAdjoint, FloatAgreesWithDoubleAndIsEqualBitForBitForOneToFourThreads) {
  const Scene scene = make_scene(3000, 200, 3);
  const Motion m = motions(200)[2];
  Values y;
  for (size_t k = 0; k < scene.rest.size() * 60; ++k) y.push_back(Random(27, k).normal());
  const Values expected = flat(gradient_of<double>({}, scene, m, y, true));
  const int before = omp_get_max_threads();
  Values first;
  for (int threads = 1; threads <= 4; ++threads) {
    omp_set_num_threads(threads);
    const Values now = flat(gradient_of<float>({}, scene, m, y, true));
    if (threads == 1) first = now;
    EXPECT_EQ(now, first) << threads;
  }
  omp_set_num_threads(before);
  double error = 0, size = 0;
  for (size_t k = 0; k < first.size(); ++k) {
    error += std::pow(first[k] - expected[k], 2), size += expected[k] * expected[k];
  }
  EXPECT_LT(std::sqrt(error / size), 1e-5);
}

TEST(DeformAdjoint, CollapsedAndInvertedDriversGiveFiniteDerivatives) {
  const Scene scene = make_scene(20, 12, 3);
  const Values y(20 * 60, 1.0);
  for (const Mat3d& A :
       {Mat3d(Mat3d::Zero()), Mat3d(-Mat3d::Identity()), Mat3d(Mat3d::Ones()), Mat3d(Vec3d(1, 1, -1).asDiagonal())}) {
    const Motion m = make_motion("collapsed", 12, false, A, 0);
    for (const double value : flat(gradient_of<float>({}, scene, m, y, true))) ASSERT_TRUE(std::isfinite(value));
  }
}

}  // namespace
}  // namespace pliant

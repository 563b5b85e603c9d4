// Derivatives of the deformation, kernel by kernel and as a whole, against differences in double: at rest (all
// stretches equal), in motion, beyond the limit of stretch, and for drivers on a line.

#include <gtest/gtest.h>

#include "gaussians/base/portable.h"
#include "gaussians/render/image_loss.h"
#include "gaussians/render/render_as.h"
#include "tests/check_adjoint.h"
#include "tests/gaussians/cloud_cast.h"
#include "tests/gaussians/made_motion.h"

namespace pliant {
namespace {

using namespace made_motion;

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
            append(y, fit.R);
            append(y, fit.now);
            append(y, fit.F);
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

/// Splits a cotangent of what `flat` gives of a carried cloud and calls deform_adjoint.
template <class T>
DeformGradientOf<T> gradient_of(const DeformOptions& options, const Scene& scene, const Motion& m, const Values& y,
                                bool with_sh) {
  const size_t n = scene.rest.size(), sh_size = with_sh ? scene.rest.sh_count() * 3 : 0;
  std::vector<Vec3<T>> rest, now, position(n);
  std::vector<Mat3<T>> F, covariance(n);
  std::vector<T> sh;
  for (size_t d = 0; d < m.rest.size(); ++d) {
    rest.push_back(m.rest[d].cast<T>());
    now.push_back(m.now[d].cast<T>());
    F.push_back(m.F[d].cast<T>());
  }
  for (size_t g = 0; g < n; ++g) {
    const double* row = y.data() + g * (12 + sh_size);
    position[g] = Vec3d(row).cast<T>();
    covariance[g] = Mat3d(row + 3).cast<T>();
    for (size_t k = 0; k < sh_size; ++k) sh.push_back(static_cast<T>(row[12 + k]));
  }
  return deform_adjoint<T>(options, cloud_cast<T>(scene.rest), scene.binding, rest, now, F, position, covariance, sh);
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
            return flat(carried(options, scene, m), with_sh);
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
    const Values expected = flat(carried(options, scene, m), true);
    GaussianCloud rest, out;
    static_cast<CloudOf<float>&>(rest) = cloud_cast<float>(scene.rest);
    std::vector<Vec3f> from, to;
    std::vector<Mat3f> F;
    for (size_t d = 0; d < m.rest.size(); ++d) {
      from.push_back(m.rest[d].cast<float>());
      to.push_back(m.now[d].cast<float>());
      F.push_back(m.F[d].cast<float>());
    }
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
    error += std::pow(first[k] - expected[k], 2);
    size += expected[k] * expected[k];
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

// The whole way of a fit: drivers -> Gaussians -> picture -> loss against a photo, and back.  Colours stay off their
// clamp and L1 is left out, because differences would cross their kinks.
TEST(DeformAdjoint, LossOfAPictureOfMovedGaussiansAgreesWithDifferencesOfTheDrivers) {
  Scene scene = make_scene(8, 12, 2);
  for (size_t k = 0; k < scene.rest.sh.size(); ++k) scene.rest.sh[k] = 0.1 * scene.rest.sh[k] + (k % 27 < 3 ? 1 : 0);
  const Camera camera = look_at({1.5, -3.5, 1.2}, {0.4, 0, 0.2}, {0, 0, 1}, 21, 16, 20);
  const PhotometricOptions loss{0, 1};
  const int before = omp_get_max_threads();
  omp_set_num_threads(1);  // thousands of tiny pictures
  const auto all = motions(12);
  const Image<double> photo =
      render_as<double, false>(carried({}, scene, make_motion("photo", 12, false, all[2].F[0], 0.05)), camera).color;
  for (Motion m : {all[0], all[2], all[4], all[5]}) {
    AdjointCheckOptions options = small_steps();
    options.random_cotangents = 0;
    options.inputs = 60;
    const AdjointCheck check = check_adjoint(
        [&](const Values& x) {
          m.set(x);
          const Rendered<double> picture = render_as<double, false>(carried({}, scene, m), camera);
          return Values{photometric_loss(loss, picture.color, photo).total};
        },
        [&](const Values& x, const Values& y) {
          m.set(x);
          const CloudOf<double> cloud = carried({}, scene, m);
          const Rendered<double> picture = render_as<double, false>(cloud, camera);
          Rendered<double> adj;
          photometric_loss_adjoint(loss, picture.color, photo, {}, y[0], adj.color);
          const RenderGradient<double> g =
              render_adjoint_as<double, false>(cloud, camera, {}, {}, 0, picture, adj, nullptr, {.covariance = true});
          return flat(deform_adjoint<double>({}, scene.rest, scene.binding, m.rest, m.now, m.F, g.cloud.position,
                                             g.covariance, g.cloud.sh));
        },
        m.values(), options);
    EXPECT_LT(check.worst, 1e-6) << m.name << ": " << check.message;
  }
  omp_set_num_threads(before);
}

}  // namespace
}  // namespace pliant

// Volumes of solids that are known only by flat Gaussians on their surface.

#include "physics/body/interior_fill.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <numbers>

#include "gaussians/base/error.h"
#include "gaussians/base/random.h"

namespace pliant {
namespace {

/// Discs of standard deviation `sigma` and half-thickness `flat` on points of a surface.
class Splats {
 public:
  Splats(double sigma, double flat) : sigma_(sigma), flat_(flat) {}

  void add(const Vec3d& x, const Vec3d& normal) {
    const size_t i = cloud.size();
    cloud.resize(i + 1);
    Mat3f R;
    R.col(2) = normal.normalized().cast<float>();
    R.col(0) = R.col(2).unitOrthogonal();
    R.col(1) = R.col(2).cross(R.col(0));
    cloud.position[i] = x.cast<float>();
    cloud.rotation[i] = quaternion_wxyz(R);
    cloud.log_scale[i] = Vec3d(sigma_, sigma_, flat_).array().log().matrix().cast<float>();
    cloud.opacity_logit[i] = 3;
  }

  GaussianCloud cloud;

 private:
  double sigma_, flat_;
};

GaussianCloud cylinder(double radius, double length, int count, bool bottom) {
  const double side = 2 * std::numbers::pi * radius * length, cap = std::numbers::pi * radius * radius;
  Splats splats(0.6 * std::sqrt((side + 2 * cap) / count), 1e-4);
  for (int i = 0; i < count; ++i) {
    Random random(1, i);
    const double u = random.uniform() * (side + (bottom ? 2 : 1) * cap),
                 angle = random.uniform(0, 2 * std::numbers::pi);
    const Vec3d out(std::cos(angle), std::sin(angle), 0), along(0, 0, 1);
    if (u < side) {
      splats.add(radius * out + random.uniform() * length * along, out);
    } else {
      const Vec3d x = radius * std::sqrt(random.uniform()) * out;
      splats.add(u < side + cap ? Vec3d(x + length * along) : x, u < side + cap ? along : Vec3d(-along));
    }
  }
  return splats.cloud;
}

FillSummary fill(const GaussianCloud& cloud, int target, SolidSamples* samples = nullptr) {
  FillOptions options;
  options.target_count = target;
  FillSummary summary;
  const SolidSamples result = fill_interior(options, cloud, &summary);
  EXPECT_NEAR(result.total_volume(), summary.volume, 1e-6 * summary.volume);
  EXPECT_EQ(result.size(), summary.samples);
  EXPECT_EQ(result.thickness.size(), result.size());
  if (samples) *samples = result;
  return summary;
}

TEST(InteriorFill, ACylinderTwoToSixteenCellsThickKeepsItsVolume) {
  const double radius = 0.05, length = 0.5, volume = std::numbers::pi * radius * radius * length;
  const GaussianCloud cloud = cylinder(radius, length, 6000, true);
  for (const double cells : {2.0, 4.0, 8.0, 16.0}) {
    const double cell = 2 * radius / cells;
    SolidSamples samples;
    const FillSummary summary = fill(cloud, static_cast<int>(volume / (cell * cell * cell)), &samples);
    EXPECT_NEAR(2 * radius / summary.cell, cells, 0.1 * cells);
    EXPECT_NEAR(summary.volume / volume, 1, 0.05) << cells;
    double thin = 0;
    for (size_t i = samples.size() - summary.thin_samples; i < samples.size(); ++i) thin += samples.volume[i];
    EXPECT_LT(thin, 0.01 * volume) << "samples of what is too thin for the grid are the last";
  }
}

TEST(InteriorFill, SamplesLieInsideAndAreCentred) {
  SolidSamples samples;
  fill(cylinder(0.05, 0.3, 6000, true), 4000, &samples);
  Vec3d centre = Vec3d::Zero();
  for (size_t i = 0; i < samples.size(); ++i) {
    const Vec3d x = samples.position[i].cast<double>();
    EXPECT_LT(x.head<2>().norm(), 0.054);
    centre += samples.volume[i] * x / samples.total_volume();
  }
  EXPECT_LT((centre - Vec3d(0, 0, 0.15)).norm(), 0.003);
}

TEST(InteriorFill, AnOpenBottomDoesNotLeak) {
  EXPECT_NEAR(fill(cylinder(0.3, 1, 6000, false), 4000).volume / (std::numbers::pi * 0.09), 1, 0.05);
}

TEST(InteriorFill, AnEllipsoidAndABoxKeepTheirVolumes) {
  const Vec3d axes(0.5, 0.3, 0.2);
  Splats ellipsoid(0.02, 1e-4), box(0.02, 1e-4);
  for (uint64_t k = 0; ellipsoid.cloud.size() < 5000; ++k) {
    Random random(2, k);
    const Vec3d u = Vec3d(random.normal(), random.normal(), random.normal()).normalized();
    const Vec3d normal = u.cwiseQuotient(axes);
    if (random.uniform() < normal.norm() * axes.minCoeff()) ellipsoid.add(u.cwiseProduct(axes), normal);
  }
  for (int i = 0; i < 6000; ++i) {
    Random random(3, i);
    const int face = static_cast<int>(random.below(6));
    Vec3d x(random.uniform(), random.uniform(), random.uniform()), normal = Vec3d::Zero();
    x[face / 2] = face % 2;
    normal[face / 2] = face % 2 ? 1 : -1;
    box.add(x, normal);
  }
  EXPECT_NEAR(fill(ellipsoid.cloud, 4000).volume / (4.0 / 3 * std::numbers::pi * axes.prod()), 1, 0.03);
  EXPECT_NEAR(fill(box.cloud, 4000).volume, 1, 0.03);
}

TEST(InteriorFill, AThinLeafIsNotInflated) {
  // One layer of Gaussians of standard deviation 2 mm across: a slab of the same spread is 2 mm sqrt(12) thick.
  Splats leaf(0.02, 0.002);
  for (int i = 0; i < 5000; ++i) {
    Random random(4, i);
    const double x = random.uniform(), y = 0.3 * random.uniform();
    leaf.add(Vec3d(x, y, 0.1 * x * x), Vec3d(-0.2 * x, 0, 1));
  }
  SolidSamples samples;
  const FillSummary summary = fill(leaf.cloud, 10000, &samples);
  EXPECT_NEAR(summary.volume / (0.3 * 1.0066 * 0.002 * std::sqrt(12.0)), 1, 0.15);
  EXPECT_EQ(summary.thin_samples, summary.samples);
  for (const float t : samples.thickness) EXPECT_NEAR(t, 0.0069, 0.002);
}

TEST(InteriorFill, GaussiansWithoutAreaGiveNoSampleThatIsNotFinite) {
  GaussianCloud cloud = cylinder(0.1, 0.3, 800, true);
  Splats needles(1e-30, 1e-30);  // far from the cylinder, each with no area, and many at one place
  for (int i = 0; i < 40; ++i) needles.add(Vec3d(0.5, 0.5, i < 20 ? 0.1 : 0.1 + 0.005 * i), Vec3d(0, 0, 1));
  cloud.append(needles.cloud);
  SolidSamples samples;
  fill(cloud, 2000, &samples);
  ASSERT_GT(samples.size(), 500u);
  for (size_t i = 0; i < samples.size(); ++i) {
    EXPECT_TRUE(samples.position[i].allFinite()) << i;
    EXPECT_GT(samples.volume[i], 0) << i;
  }
}

TEST(InteriorFill, IsRepeatable) {
  const GaussianCloud cloud = cylinder(0.1, 0.3, 2000, true);
  SolidSamples a, b;
  fill(cloud, 2000, &a);
  fill(cloud, 2000, &b);
  EXPECT_TRUE(a.position == b.position && a.volume == b.volume);
}

TEST(InteriorFill, AnInvisibleObjectAndOneWithoutExtentAreUsageErrors) {
  GaussianCloud cloud = cylinder(0.1, 0.3, 200, true), same = cloud;
  for (float& opacity : cloud.opacity_logit) opacity = -9;
  for (Vec3f& x : same.position) x = Vec3f(1, 2, 3);
  for (const GaussianCloud& bad : {cloud, GaussianCloud{}, same}) {
    try {
      fill_interior({}, bad);
      FAIL() << "no error";
    } catch (const Error& error) {
      EXPECT_EQ(error.failure, Failure::kUsage);
    }
  }
}

}  // namespace
}  // namespace pliant

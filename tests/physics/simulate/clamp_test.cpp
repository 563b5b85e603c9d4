// The clamp of a cantilever: its first frequency does not depend on where the nodes of the grid lie.

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "tests/physics/cantilever.h"
#include "tests/physics/shapes.h"

namespace pliant {
namespace {

constexpr double kHeight = 0.03, kFree = 0.1, kYoung = 263824, kPoisson = 0.4, kDensity = 1070;
constexpr double kFiniteElements = 7.29;  // Hz, quadratic hexahedra, fully clamped

/// First frequency of a beam of 6 x 6 cells that is clamped at x = 0, by the time until it first turns round after
/// gravity is switched on; displaced by `offset` cells against the nodes and turned by `turn`.
double frequency(const Vec3d& offset, const Mat3d& turn) {
  constexpr double dx = kHeight / 6, foot = 3 * dx;
  auto p = fixture::fill_shape<float>({kFree + foot, kHeight, kHeight}, dx, 2, 0.0, kYoung, kPoisson, kDensity,
                                      [](const Vec3d&) { return true; });
  std::vector<double> weight;  // near the shape of the first mode
  for (Vec3f& x : p.position) {
    const Vec3d own = x.cast<double>() - Vec3d(foot, 0, 0);
    weight.push_back(own.x() > 0 ? own.x() * own.x() : 0);
    x = (turn * own + dx * offset).cast<float>();
  }
  Interaction wall;
  wall.type = InteractionType::kPin;
  wall.region = Region::half_space(dx * offset, turn * Vec3d::UnitX());
  return fixture::first_frequency(p, wall, turn * Vec3d(0, 0, -9.81), weight, 0.08);
}

TEST(Clamp, TheFrequencyOfACantileverDoesNotDependOnTheGrid) {
  const Mat3d straight = Mat3d::Identity();
  const Mat3d turned = Eigen::AngleAxisd(0.5, Vec3d(0.3, 1, 0.2).normalized()).toRotationMatrix();
  double low = INFINITY, high = 0;
  const auto measure = [&](const Vec3d& offset, const Mat3d& turn) {
    const double f = frequency(offset, turn);
    low = std::min(low, f);
    high = std::max(high, f);
    std::printf("offset %.2f %.2f %.2f%s: %.3f Hz\n", offset.x(), offset.y(), offset.z(),
                &turn == &turned ? " turned" : "", f);
  };
  for (const double x : {0.0, 0.25, 0.5, 0.75}) measure(Vec3d(x, 0, 0), straight);
  measure(Vec3d(0.4, 0.25, 0.6), straight);
  measure(Vec3d(0.3, 0.1, 0.2), turned);
  EXPECT_LT(high / low, 1.03);
  EXPECT_NEAR(low / kFiniteElements, 1, 0.03);
  EXPECT_NEAR(high / kFiniteElements, 1, 0.03);
}

}  // namespace
}  // namespace pliant

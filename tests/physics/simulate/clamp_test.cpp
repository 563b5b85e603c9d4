// The clamp of a cantilever: its first frequency does not depend on where the nodes of the grid lie, and it sags as
// beam theory says.

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

// Thinner than the depth by which the nodes of a clamp lie inside of it, whatever its shape.
TEST(Clamp, AThinCylinderHoldsWhatABoxOfItsHeightHolds) {
  constexpr double dx = 0.01, length = 0.24, middle = 0.12;
  const auto p = fixture::block<float>({length, 4 * dx, 4 * dx}, dx, 0.0, 1e5, 0.3, kDensity);
  const auto bent = [&](const Region& region) {
    SimulateOptions options;
    options.fps = 50;
    options.duration = 0.1;
    options.gravity = Vec3d(0, 0, -9.81);
    options.rest_shape = RestShapeMode::kCaptured;
    Interaction clamp, push;
    clamp.type = InteractionType::kPin;
    clamp.region = region;
    push.type = InteractionType::kGust;
    push.vector = Vec3d(0, 0, 5);
    return simulate<float>(options, p, {clamp, push}, initial_state(p)).summary.max_displacement;
  };
  for (const double height : {0.5 * dx, 2.0 * dx, 4.0 * dx}) {
    const double low = middle - 0.5 * height, high = middle + 0.5 * height;
    const double box = bent(Region::box({low, -1, -1}, {high, 1, 1}));
    const double cylinder = bent(Region::cylinder({low, 2 * dx, 2 * dx}, {high, 2 * dx, 2 * dx}, 1));
    EXPECT_GT(box, 1e-3);
    EXPECT_NEAR(cylinder / box, 1, 1e-3) << height / dx << " cells";
  }
}

// Springs of a pin are as stiff as the material is; E and nu of a fluid with a bulk modulus of its own say nothing.
TEST(Clamp, HoldsAFluidWithAnySmallBulkModulusStably) {
  auto p = fixture::block<float>({0.04, 0.04, 0.08}, 0.01, 1.0, 1e7, 0.3, 1000);
  p.materials[0].law = Law::kFluid;
  p.materials[0].bulk_modulus = 1e4;
  Interaction pin;
  pin.type = InteractionType::kPin;
  pin.region = Region::half_space(Vec3d(0, 0, 0.03), Vec3d::UnitZ());
  SimulateOptions options;
  options.fps = 100;
  options.duration = 0.05;
  const auto summary = simulate<float>(options, p, {pin}, initial_state(p)).summary;
  EXPECT_EQ(summary.retries, 0);
  EXPECT_LT(summary.max_displacement, 0.08);
}

/// Sag [m] at rest of the outermost half of a cell of a beam along x of kSlender times its height.
constexpr int kCells = 4;
constexpr double kSlender = 6, kShearFactor = 0.85;  // Cowper 1966, nu = .3

/// By its own mass, or by a weight [N] instead.
double sag(double weight) {
  constexpr double dx = kHeight / kCells, foot = 3 * dx, length = kSlender * kHeight;
  auto p = fixture::block<float>({length + foot, kHeight, kHeight}, dx, 0.0, 1e6, 0.3, kDensity);
  for (Vec3f& x : p.position) x.x() -= static_cast<float>(foot);
  SimulateOptions options;
  options.fps = 100;
  options.duration = 0.5;
  options.damping_time = 0.05;
  Interaction wall;
  wall.type = InteractionType::kPin;
  wall.region = Region::half_space(Vec3d::Zero(), Vec3d::UnitX());
  std::vector<Interaction> script = {wall};
  Interaction load;
  load.vector = options.gravity;
  load.type = InteractionType::kGust;
  if (!(weight > 0)) script.push_back(load);
  load.type = InteractionType::kWeight;
  load.mass = weight / 9.81;
  load.region = Region::half_space(Vec3d(length - 0.5 * dx, 0, 0), -Vec3d::UnitX());
  if (weight > 0) script.push_back(load);
  const auto end = simulate<float>(options, p, script, initial_state(p)).state;
  double sum = 0, count = 0;
  for (size_t i = 0; i < p.size(); ++i) {
    if (!load.region.contains(p.position[i].cast<double>())) continue;
    sum += p.position[i].z() - end.x[i].z();
    ++count;
  }
  return sum / count;
}

// Timoshenko 1921.  The ratio of two loads' sags depends neither on E nor on where exactly the clamp holds.
TEST(Clamp, ASlenderCantileverSagsAsTimoshenkoSays) {
  const double length = kSlender * kHeight, area = kHeight * kHeight, bending = 1e6 * area * kHeight * kHeight / 12,
               shear = kShearFactor * 1e6 / 2.6 * area, load = kDensity * area * 9.81,
               x = length - kHeight / kCells / 4;
  const double weight = 0.3 * load * length;
  const double by_weight = weight * (x * x * x / (3 * bending) + x / shear);
  const double by_mass = load * (x * x * (6 * length * length - 4 * length * x + x * x) / (24 * bending) +
                                 (length * x - 0.5 * x * x) / shear);
  const double own = sag(0), hung = sag(weight);
  std::printf("own mass %.4f, weight %.4f of Timoshenko's\n", own / by_mass, hung / by_weight);
  EXPECT_NEAR(own / by_mass, 1, 0.05);
  EXPECT_NEAR(hung / by_weight, 1, 0.05);
  EXPECT_NEAR(hung / own / (by_weight / by_mass), 1, 0.02);
}

}  // namespace
}  // namespace pliant

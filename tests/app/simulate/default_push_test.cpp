// The region of the push that `run` applies by itself holds something of every body, where nothing else holds it.

#include "app/simulate/default_push.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

namespace pliant {
namespace {

/// Particles on a grid of spacing 0.01 m in a box of that size, where `keep` says so.
Particles body_of(const Vec3d& size, const std::function<bool(const Vec3d&)>& keep) {
  Particles out;
  out.cell_size = 0.02f;
  for (double x = -size.x() / 2; x <= size.x() / 2; x += 0.01)
    for (double y = -size.y() / 2; y <= size.y() / 2; y += 0.01)
      for (double z = 0.005; z <= size.z(); z += 0.01)
        if (keep({x, y, z})) {
          out.position.push_back(Vec3d(x, y, z).cast<float>());
          out.mass.push_back(1e-3f);
        }
  return out;
}

/// The same as a file, every particle of which is its own sample.
ParticleFile file_of(const Particles& body) {
  ParticleFile file;
  file.driving_position = file.solid_position = body.position;
  file.solid_volume.assign(body.size(), 1e-6f);
  for (size_t i = 0; i < body.size(); ++i) file.solid_driver.push_back(static_cast<int>(i));
  file.cell_size = body.cell_size;
  return file;
}

PushPlace place_on(const Particles& body, const std::vector<Region>& pins, const Vec3d& right = Vec3d::UnitX()) {
  return default_push_place(body, tip_of(file_of(body), pins, Vec3d::UnitZ()), Vec3d::UnitZ(), right);
}

int touched(const Particles& body) {
  const PushPlace place = place_on(body, {});
  return static_cast<int>(std::count_if(body.position.begin(), body.position.end(),
                                        [&](const Vec3f& x) { return place.region.contains(x.cast<double>()); }));
}

TEST(DefaultPush, TouchesBodiesThatLieFlatAndRings) {
  const auto radius = [](const Vec3d& x) { return std::hypot(x.x(), x.y()); };
  EXPECT_GE(touched(body_of({0.3, 0.3, 0.01}, [&](const Vec3d& x) { return radius(x) < 0.15; })), 4);
  EXPECT_GE(touched(body_of({0.3, 0.3, 0.02}, [&](const Vec3d& x) { return radius(x) > 0.1 && radius(x) < 0.15; })), 4);
  EXPECT_GE(touched(body_of({0.02, 0.02, 0.4}, [](const Vec3d&) { return true; })), 4);
}

TEST(DefaultPush, OfAColumnIsAtItsTopAndSideways) {
  const Particles column = body_of({0.06, 0.06, 0.4}, [](const Vec3d&) { return true; });
  const PushPlace place = place_on(column, {}, Vec3d(1, 0, 0.5));
  EXPECT_TRUE(place.region.contains({0, 0, 0.38}));
  EXPECT_FALSE(place.region.contains({0, 0, 0.2}));
  EXPECT_LT((place.direction - Vec3d::UnitX()).norm(), 1e-9);
}

TEST(DefaultPush, OfWhatIsHeldBelowIsWhereItIsWithoutAHold) {
  const Particles column = body_of({0.06, 0.06, 0.4}, [](const Vec3d&) { return true; });
  const ObjectTip free = tip_of(file_of(column), {}, Vec3d::UnitZ());
  for (const Region& pin : {Region::half_space(Vec3d(0, 0, 0.2), Vec3d::UnitZ()), Region::sphere({0, 0, 0}, 0.05),
                            Region::box({-1, -1, -1}, {1, 1, 0.04}), Region::sphere({5, 5, 5}, 0.1)}) {
    const ObjectTip tip = tip_of(file_of(column), {pin}, Vec3d::UnitZ());
    EXPECT_TRUE(tip.top);
    EXPECT_EQ(tip.particles, free.particles);
  }
}

TEST(DefaultPush, OfWhatHangsIsAtTheEndThatNothingHolds) {
  const Particles column = body_of({0.06, 0.06, 0.4}, [](const Vec3d&) { return true; });
  for (const double held : {0.39, 0.36, 0.3, 0.2}) {
    const PushPlace place = place_on(column, {Region::half_space(Vec3d(0, 0, held), -Vec3d::UnitZ())});
    EXPECT_TRUE(place.region.contains({0, 0, 0.02})) << held;
    EXPECT_FALSE(place.region.contains({0, 0, 0.15})) << held;
  }
  // Of a level bar that is held in its middle, it is one end, not the mean of both.
  const Particles bar = body_of({0.6, 0.04, 0.04}, [](const Vec3d&) { return true; });
  const PushPlace place = place_on(bar, {Region::box({-0.2, -1, -1}, {0.2, 1, 1})});
  EXPECT_TRUE(place.region.contains({0.28, 0, 0.02}) || place.region.contains({-0.28, 0, 0.02}));
}

TEST(DefaultPush, IsOnAPieceThatIsHeld) {
  // A stalk, and a head above it that hangs on nothing.
  const Particles body = body_of(
      {0.1, 0.1, 0.5}, [](const Vec3d& x) { return x.z() < 0.3 ? std::hypot(x.x(), x.y()) < 0.03 : x.z() > 0.4; });
  const Region foot = Region::half_space(Vec3d(0, 0, 0.03), Vec3d::UnitZ());
  const PushPlace place = place_on(body, {foot});
  EXPECT_TRUE(place.region.contains({0, 0, 0.285}));
  EXPECT_FALSE(place.region.contains({0, 0, 0.42}));
  EXPECT_TRUE(place_on(body, {}).region.contains({0, 0, 0.48})) << "where nothing is held";
}

}  // namespace
}  // namespace pliant

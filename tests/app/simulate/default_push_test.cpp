// The region of the push that `run` applies by itself holds something of every body.

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

int touched(const Particles& body) {
  const PushPlace place = default_push_place(body, Vec3d::UnitZ(), Vec3d::UnitX());
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
  const PushPlace place = default_push_place(column, Vec3d::UnitZ(), Vec3d(1, 0, 0.5));
  EXPECT_TRUE(place.region.contains({0, 0, 0.38}));
  EXPECT_FALSE(place.region.contains({0, 0, 0.2}));
  EXPECT_LT((place.direction - Vec3d::UnitX()).norm(), 1e-9);
}

}  // namespace
}  // namespace pliant

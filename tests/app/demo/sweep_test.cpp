// Closed surfaces of triangles: rods, sheets and solids of revolution obey the laws of what they approximate.

#include "app/demo/kinds/sweep.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "app/demo/kinds/kind_builder.h"

namespace pliant {
namespace {

double mesh_volume(const AnalyticShape& shape) {
  const TriangleMesh mesh = shape.mesh(0.002);
  double volume = 0;
  for (const Eigen::Vector3i& t : mesh.triangle)
    volume += mesh.vertex[t[0]].dot(mesh.vertex[t[1]].cross(mesh.vertex[t[2]])) / 6;
  return volume;
}

/// Share of a box's points inside of the shape, times the volume of the box.
double sampled_volume(const AnalyticShape& shape, const Vec3d& half, const Vec3d& centre) {
  Random random(7);
  constexpr int kPoints = 60000;
  int inside = 0;
  for (int i = 0; i < kPoints; ++i) {
    const Vec3d u(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
    inside += shape.inside(centre + u.cwiseProduct(half));
  }
  return 8 * half.prod() * inside / kPoints;
}

struct NamedSolid {
  const char* name;
  std::unique_ptr<AnalyticShape> shape;
  double volume;
  Vec3d half, centre;  ///< of a box around it
};
std::vector<NamedSolid> solids() {
  constexpr double kPi = std::numbers::pi;
  std::vector<NamedSolid> all;
  // A capsule: a cylinder between two half balls.
  all.push_back({"rod",
                 make_rod({{0, 0, 0}, {0, 0, 0.1}}, 0.01, 0.01),
                 kPi * 1e-4 * 0.08 + 4.0 / 3 * kPi * 1e-6,
                 {0.011, 0.011, 0.051},
                 {0, 0, 0.05}});
  // Pappus: area of the section times the way of its centre, less what rounded ends lack of a cylinder.
  std::vector<Vec3d> arc;
  for (int i = 0; i <= 60; ++i) arc.emplace_back(0.05 * std::cos(kPi * i / 60), 0.05 * std::sin(kPi * i / 60), 0);
  all.push_back({"arc",
                 make_rod(arc, 0.008, 0.008),
                 kPi * 6.4e-5 * (kPi * 0.05 - 2.0 / 3 * 0.008),
                 {0.06, 0.035, 0.009},
                 {0, 0.026, 0}});
  // |a|^4 + |b|^4 = 1 encloses 3.7081 half axes; the edges of the strip's ends are rounded as well.
  const Blade strip{0.1, 0.02, 0.003, 0, [](double) { return 1.0; }};
  all.push_back({"strip",
                 make_blade(strip),
                 3.7081 * 0.02 * 0.003 * (0.1 - 2.0 / 3 * 0.003),
                 {0.051, 0.021, 0.004},
                 {0.05, 0, 0}});
  all.push_back({"turned",
                 make_turned({{0, 0}, {0.03, 0}, {0.02, 0.05}, {0, 0.05}}),
                 kPi * 0.05 / 3 * (9e-4 + 6e-4 + 4e-4),
                 {0.031, 0.031, 0.026},
                 {0, 0, 0.025}});
  return all;
}

TEST(DemoSweep, VolumeIsThatOfTheSolidByTheMeshAndByWhatIsInside) {
  for (const NamedSolid& s : solids()) {
    EXPECT_NEAR(mesh_volume(*s.shape) / s.volume, 1, 0.02) << s.name;
    EXPECT_NEAR(sampled_volume(*s.shape, s.half, s.centre) / s.volume, 1, 0.03) << s.name;
  }
}

TEST(DemoSweep, RayAgainstTheNormalMeetsEachCoveringPoint) {
  for (const NamedSolid& s : solids())
    for (const SurfacePoint& p : s.shape->cover(0.004, 3)) {
      // Where the surface bends, another part of it may come first.
      const SurfaceHit hit = s.shape->intersect({p.position + 5e-4 * p.normal, -p.normal}, 0, 1);
      ASSERT_NEAR(hit.t, 5e-4, 1e-4) << s.name << " at " << p.position.transpose();
      ASSERT_NEAR(p.normal.norm(), 1, 1e-9);
      ASSERT_LE((p.position - s.shape->bound_centre()).norm(), s.shape->bound_radius());
    }
}

TEST(DemoSweep, CoverHasOnePointPerSquareOfTheSpacing) {
  const std::unique_ptr<AnalyticShape> rod = make_rod({{0, 0, 0}, {0, 0, 0.1}}, 0.01, 0.01);
  const double area = 2 * std::numbers::pi * 0.01 * 0.1, spacing = 0.002;
  EXPECT_NEAR(rod->cover(spacing, 1).size() * spacing * spacing / area, 1, 0.06);
}

TEST(DemoSweep, FlutesKeepTheSectionsAreaToSecondOrder) {
  // The mean of (1 + d cos)^2 over a turn is 1 + d^2 / 2.
  const std::vector<Eigen::Vector2d> profile = {{0, 0}, {0.04, 0}, {0.04, 0.05}, {0, 0.05}};
  const double plain = mesh_volume(*make_turned(profile)), fluted = mesh_volume(*make_turned(profile, 8, 0.2));
  EXPECT_NEAR(fluted / plain, 1 + 0.02, 0.004);
}

}  // namespace
}  // namespace pliant

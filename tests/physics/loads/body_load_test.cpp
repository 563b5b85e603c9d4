// Loads on single particles and the surface that they act on.

#include "physics/loads/body_load.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "gaussians/base/random.h"
#include "physics/body/driving_particles.h"
#include "physics/body/surface_elements.h"
#include "tests/check_adjoint.h"
#include "tests/physics/shapes.h"

namespace pliant {
namespace {

TEST(BodyLoad, TheAdjointAgreesWithDifferences) {
  BodyLoad<double> load;
  load.acceleration = Vec3d(1, 2, 3);
  load.drag = 0.7;
  load.angular = Vec3d(3, -1, 2);
  load.centre = Vec3d(0.1, 0.2, 0);
  load.spring = 1.5;
  load.wind = Vec3d(4, 1, 0);
  load.pressure = 0.6;
  load.per_volume = Vec3d(-2, 0.5, 1);
  LoadedParticle<double> p;
  p.reference = Vec3d(0.2, 0.1, 0.1);
  p.exposure = Vec3d(-2, 0.3, 0.4);
  p.volume = 0.7;
  // x, v, F, mass, stiffness; acceleration, angular, centre, wind, force per volume, drag.
  std::vector<double> all = {0.3, -0.2, 0.5, 1, -0.5, 0.2, 1.1, 0.1, -0.2, 0.05, 0.9, 0.1, 0.2, -0.1, 1.05, 0.8, 2};
  const auto walk = [](auto& particle, auto& of_load, auto&& visit) {
    for (int a = 0; a < 3; ++a) visit(particle.x[a]);
    for (int a = 0; a < 3; ++a) visit(particle.v[a]);
    for (int k = 0; k < 9; ++k) visit(particle.F(k / 3, k % 3));
    visit(particle.mass);
    visit(particle.stiffness);
    for (auto* v : {&of_load.acceleration, &of_load.angular, &of_load.centre, &of_load.wind, &of_load.per_volume})
      for (int a = 0; a < 3; ++a) visit((*v)[a]);
    visit(of_load.drag);
  };
  for (const auto* v : {&load.acceleration, &load.angular, &load.centre, &load.wind, &load.per_volume})
    all.insert(all.end(), v->data(), v->data() + 3);
  all.push_back(load.drag);
  const auto set = [&](const std::vector<double>& values) {
    size_t k = 0;
    walk(p, load, [&](double& x) { x = values[k++]; });
  };
  const AdjointCheck check = check_adjoint(
      [&](const std::vector<double>& values) {
        set(values);
        const Vec3d gain = velocity_gain(load, 0.3, p);
        return std::vector<double>(gain.data(), gain.data() + 3);
      },
      [&](const std::vector<double>& values, const std::vector<double>& adj) {
        set(values);
        LoadedParticleGradient<double> by;
        BodyLoadGradient by_load;
        velocity_gain_adjoint(load, 0.3, p, Vec3d(adj[0], adj[1], adj[2]), by, by_load);
        std::vector<double> out;
        walk(by, by_load, [&](double x) { out.push_back(x); });
        return out;
      },
      all);
  EXPECT_LT(check.worst, 1e-6) << check.message;
}

TEST(SurfaceElements, OfABallSumToItsAreaPointOutwardAndClose) {
  constexpr double dx = 0.01, radius = 0.05;
  const auto ball = fixture::fill_shape<double>(Vec3d::Constant(2 * radius), dx, 2, 1.0, 1, 0, 1, [&](const Vec3d& x) {
    return (x - Vec3d::Constant(radius)).norm() < radius;
  });
  Vec3d sum = Vec3d::Zero();
  double area = 0, outward = 0;
  const auto elements = surface_elements(ball, dx);
  for (size_t i = 0; i < elements.size(); ++i) {
    const Vec3d out = (ball.position[i] - Vec3d::Constant(radius)).normalized();
    sum += elements[i];
    area += elements[i].norm();
    outward += elements[i].dot(out);
  }
  EXPECT_NEAR(outward / (4 * 3.14159265 * radius * radius), 1, 0.12);
  EXPECT_NEAR(area / outward, 1, 0.25);  // the rest is noise of the particles' places
  EXPECT_LT(sum.norm(), 0.02 * area);
}

/// Area of the elements over that of the upper face of a sheet [0, width]^2, between the outermost three cells.
double share_of_face(const BasicParticles<double>& sheet, double dx, double width) {
  const auto elements = surface_elements(sheet, dx);
  double up = 0;
  for (size_t i = 0; i < elements.size(); ++i) {
    const Vec3d& x = sheet.position[i];
    if (std::min({x.x(), x.y(), width - x.x(), width - x.y()}) > 3 * dx) up += std::max(0.0, elements[i].z());
  }
  const double inner = width - 6 * dx;
  return up / (inner * inner);
}

// Whatever the thickness and wherever the nodes lie.
TEST(SurfaceElements, OfAPlateSumToTheAreaOfEachFace) {
  constexpr double dx = 0.01, width = 0.16;
  const auto mean_of = [&](BasicParticles<double> sheet) {
    double sum = 0;
    for (int k = 0; k < 4; ++k) {
      sum += share_of_face(sheet, dx, width) / 4;
      for (Vec3d& x : sheet.position) x.z() += dx / 4;
    }
    return sum;
  };
  for (const double cells : {1.0, 1.5, 2.0, 3.0, 4.0}) {
    const double share = mean_of(fixture::block<double>({width, width, cells * dx}, dx, 0.5));
    EXPECT_NEAR(share, 1, 0.1) << cells << " cells";
  }
  // Drivers of a leaf: in two layers whose variance is that of the thickness that is simulated.
  auto leaf = fixture::block<double>({width, width, 0.5 * dx}, dx, 0.5);
  for (size_t i = 0; i < leaf.size(); ++i) {
    const double side = Random(3, i).uniform() < 0.5 ? -1 : 1;
    leaf.position[i].z() = side * kThinCells * dx / std::sqrt(12.0);
    leaf.volume[i] *= kThinCells / 0.5;
  }
  EXPECT_NEAR(mean_of(leaf), 1, 0.1);
}

TEST(ThinParts, AreThoseOfLessThanThreeCells) {
  constexpr double dx = 0.01;
  // A block of 5 cells with a plate of 2 cells and one of 3 cells at its sides.
  const auto body = fixture::fill_shape<double>({0.15, 0.05, 0.05}, dx, 2, 0.6, 1, 0, 1, [&](const Vec3d& x) {
    return (x.x() > 0.05 && x.x() < 0.10) || (x.x() < 0.05 ? x.z() < 0.02 : x.z() < 0.03);
  });
  const auto thin = thin_parts(body, dx);
  int wrong = 0, plate = 0;
  for (size_t i = 0; i < thin.size(); ++i) {
    const bool expected = body.position[i].x() < 0.05;
    plate += expected;
    wrong += (thin[i] != 0) != expected;
  }
  EXPECT_GT(plate, 300);
  EXPECT_LT(wrong, 0.1 * thin.size());  // beside the thick block
}

}  // namespace
}  // namespace pliant

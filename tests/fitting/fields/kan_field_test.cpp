#include "fitting/fields/kan_field.h"

#include <gtest/gtest.h>

#include "gaussians/base/adam.h"
#include "gaussians/base/error.h"
#include "gaussians/base/random.h"

namespace pliant {
namespace {

std::vector<Vec3f> places(int count, uint64_t seed) {
  std::vector<Vec3f> points;
  for (int i = 0; i < count; ++i) {
    Random random(seed, i);
    points.push_back(Vec3d(random.uniform(2, 3), random.uniform(-1, 1), random.uniform(0, 0.2)).cast<float>());
  }
  return points;
}

std::vector<double> stirred(const KanField& field, double size, uint64_t seed) {
  std::vector<double> p = field.constant(std::vector<double>{0.3});
  for (size_t i = 0; i < p.size(); ++i) p[i] += size * Random(seed, i).normal();
  return p;
}

TEST(KanField, StartsAsTheConstantThatItIsAskedFor) {
  for (const double bound : {double(INFINITY), 2.0}) {
    const KanField field({.bound = bound}, places(40, 1));
    for (const double wanted : {-1.5, 0.0, 0.7})
      for (const double value : field.values(field.constant(std::vector<double>{wanted})))
        EXPECT_NEAR(value, wanted, 1e-12);
  }
}

// Central differences in double, places beyond the splines' interval among the hidden nodes.
TEST(KanField, AdjointOfValuesAgreesWithDifferences) {
  for (const double bound : {double(INFINITY), 1.5}) {
    const KanField field({.hidden = 5, .bound = bound, .seed = 3}, places(25, 2));
    std::vector<double> p = stirred(field, 0.6, 4), weight(field.points());
    for (size_t i = 0; i < weight.size(); ++i) weight[i] = Random(5, i).normal();
    const auto loss = [&] {
      const std::vector<double> values = field.values(p);
      double sum = 0;
      for (size_t i = 0; i < values.size(); ++i) sum += weight[i] * values[i];
      return sum;
    };
    const std::vector<double> adj = field.values_adjoint(p, weight);
    double largest = 0;
    for (const double g : adj) largest = std::max(largest, std::abs(g));
    for (size_t k = 0; k < p.size(); ++k) {
      const double kept = p[k], h = 1e-5;
      p[k] = kept + h;
      const double above = loss();
      p[k] = kept - h;
      const double below = loss();
      p[k] = kept;
      EXPECT_NEAR((above - below) / (2 * h), adj[k], 1e-7 * largest) << k;
    }
  }
}

// A cubic spline reproduces cubics (Marsden's identity for x: coefficients at the centres of the splines).
TEST(KanField, ASplineOfAnEdgeReproducesALine) {
  const std::vector<Vec3f> points = {Vec3f(0, 0, 0), Vec3f(1, 1, 1), Vec3f(0.3f, 0.9f, 0.1f), Vec3f(0.77f, 0.2f, 0.5f)};
  const KanField field({.hidden = 1}, points);
  std::vector<double> p(field.parameters(), 0.0);
  const double step = 2.0 / 5;
  for (int j = 0; j < 8; ++j) {
    const double centre = -1 + step * (j - 1);
    p[1 + j] = 0.5 * centre;     // node = x / 2
    p[27 + 1 + j] = 3 * centre;  // value = 3 node
  }
  const std::vector<double> values = field.values(p);
  for (size_t i = 0; i < points.size(); ++i) EXPECT_NEAR(values[i], 1.5 * (2 * points[i].x() - 1), 1e-6);
}

TEST(KanField, FollowsTwoPartsOfDifferentStiffness) {
  const std::vector<Vec3f> points = places(200, 7);
  const KanField field({}, points);
  std::vector<double> p = field.constant(std::vector<double>{0.0}), wanted;
  for (const Vec3f& x : points) wanted.push_back(std::tanh(6 * x.y()));
  Adam<double> adam(p.size());
  const auto error = [&](std::vector<double>& adj) {
    adj = field.values(p);
    double sum = 0;
    for (size_t i = 0; i < adj.size(); ++i) {
      adj[i] -= wanted[i];
      sum += adj[i] * adj[i] / static_cast<double>(adj.size());
    }
    return std::sqrt(sum);
  };
  std::vector<double> adj;
  const double before = error(adj);
  for (int k = 0; k < 400; ++k) {
    error(adj);
    adam.step(p, field.values_adjoint(p, adj), 0.02);
  }
  EXPECT_LT(error(adj), 0.1 * before);
}

TEST(KanField, BoundsHoldHoweverLargeTheParameters) {
  const KanField field({.bound = 2}, places(100, 8));
  const std::vector<double> p = stirred(field, 50, 9);
  for (const double value : field.values(p)) EXPECT_LE(std::abs(value), 2);
  for (const double g : field.values_adjoint(p, std::vector<double>(100, 1.0))) EXPECT_TRUE(std::isfinite(g));
}

TEST(KanField, IsEqualForASeedAndTakesFlatBodies) {
  const std::vector<Vec3f> flat = {Vec3f(0, 0, 1), Vec3f(1, 0, 1), Vec3f(2, 3, 1)};
  const KanField field({.seed = 4}, flat), again({.seed = 4}, flat), other({.seed = 5}, flat);
  const std::vector<double> zero = {0.0};
  EXPECT_EQ(field.constant(zero), again.constant(zero));
  EXPECT_NE(field.constant(zero), other.constant(zero));
  for (const double value : field.values(stirred(field, 1, 6))) EXPECT_TRUE(std::isfinite(value));
}

TEST(KanField, RefusesImpossibleOptions) {
  EXPECT_THROW(KanField({.hidden = 0}, places(3, 1)), Error);
  EXPECT_THROW(KanField({.bound = 0}, places(3, 1)), Error);
  EXPECT_THROW(KanField({}, {}), Error);
}

}  // namespace
}  // namespace pliant

#include "fitting/fields/triplane_field.h"

#include <gtest/gtest.h>
#include <omp.h>

#include <cmath>

#include "gaussians/base/adam.h"
#include "tests/check_adjoint.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

std::vector<Vec3f> cloud(int count, uint64_t seed) {
  std::vector<Vec3f> points;
  for (int i = 0; i < count; ++i) {
    Random random(seed, i);
    for (Vec3f& x = points.emplace_back(); float& c : x.reshaped()) c = static_cast<float>(random.uniform(-1, 1));
    points.back() = points.back().cwiseProduct(Vec3f(0.1f, 0.3f, 0.05f)) + Vec3f(2, -1, 0.5f);
  }
  return points;
}

/// Away from the constant start, so that every parameter counts.
std::vector<double> disturbed(std::vector<double> p, double by, uint64_t seed) {
  for (size_t i = 0; i < p.size(); ++i) p[i] += by * Random(seed, i).normal();
  return p;
}

class TriplaneFieldTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!has_triplane_fields()) GTEST_SKIP() << "built without libtorch";
  }
};

TEST_F(TriplaneFieldTest, StartsAsTheConstantThatItIsAskedFor) {
  const auto points = cloud(50, 1);
  for (const int layers : {1, 2, 3}) {
    TriplaneOptions o;
    o.layers = layers;
    o.channels = 3;
    o.resolution = 5;
    for (const bool bounded : {false, true}) {
      if (bounded) {
        o.low = {-2, 0, 10};
        o.high = {4, 20, 13};
      }
      const auto field = make_triplane_field(o, points);
      const std::vector<double> value = {0.7, 14, 12.9};
      const auto p = field->constant(value);
      EXPECT_EQ(p.size(), field->parameters());
      const auto values = field->values(p);
      ASSERT_EQ(values.size(), 150u);
      for (size_t i = 0; i < values.size(); ++i) EXPECT_NEAR(values[i], value[i % 3], 1e-12 * value[i % 3]);
    }
  }
}

TEST_F(TriplaneFieldTest, AdjointsOfValuesAndRoughnessAgreeWithDifferences) {
  AdjointCheckOptions check;
  check.step = 1e-4;
  check.unit_cotangents = 6;
  check.inputs = 300;  // shorter than the way to the next kink of a ReLU
  for (const int layers : {2, 3}) {
    TriplaneOptions o;
    o.channels = 2;
    o.resolution = 4;
    o.features = 6;
    o.hidden = 8;
    o.layers = layers;
    o.scale = 0.5;
    o.low = {-3, 0};
    o.high = {3, 5};
    const auto field = make_triplane_field(o, cloud(20, 2));
    const auto p = disturbed(field->constant(std::vector<double>{1, 2}), 0.3, 3);
    const auto values = [&](const std::vector<double>& q) { return field->values(q); };
    const auto values_adjoint = [&](const std::vector<double>& q, const std::vector<double>& w) {
      return field->values_adjoint(q, w);
    };
    const AdjointCheck of_values = check_adjoint(values, values_adjoint, p, check);
    EXPECT_LE(of_values.worst, 1e-6) << of_values.message;
    const auto rough = [&](const std::vector<double>& q) { return std::vector<double>{field->roughness(q, 2, {})}; };
    const auto rough_adjoint = [&](const std::vector<double>& q, const std::vector<double>& w) {
      std::vector<double> gradient(q.size(), 1.0);  // it is added
      field->roughness(q, 2 * w[0], gradient);
      for (double& g : gradient) g -= 1;
      return gradient;
    };
    const AdjointCheck of_roughness = check_adjoint(rough, rough_adjoint, p, check);
    EXPECT_LE(of_roughness.worst, 1e-6) << of_roughness.message;
  }
}

TEST_F(TriplaneFieldTest, RoughnessIsTheMeanSquaredSlopeOfThePlanes) {
  TriplaneOptions o;
  o.resolution = 6;
  o.features = 2;
  const auto field = make_triplane_field(o, cloud(3, 4));
  std::vector<double> p(field->parameters(), 0.0);
  for (int i = 0; i < 3 * 2 * 36; ++i) p[i] = 0.25 * (i % 6) - 2 * (i / 6 % 6);  // slope .25 along rows, -2 across
  EXPECT_NEAR(field->roughness(p, 10, {}), 10 * 3 * (0.0625 + 4), 1e-12);
}

TEST_F(TriplaneFieldTest, BoundsHoldHoweverLargeTheParameters) {
  TriplaneOptions o;
  o.low = {std::log(1e3)};
  o.high = {std::log(1e8)};
  const auto field = make_triplane_field(o, cloud(200, 5));
  double least = INFINITY, most = 0;
  for (const double by : {0.3, 1.0, 30.0}) {
    for (uint64_t seed = 0; seed < 5; ++seed) {
      for (const double v : field->values(disturbed(field->constant(std::vector<double>{11}), by, seed))) {
        least = std::min(least, v);
        most = std::max(most, v);
      }
    }
  }
  EXPECT_GE(least, o.low[0]);
  EXPECT_LE(most, o.high[0]);
  EXPECT_NEAR(least, o.low[0], 0.01);
  EXPECT_NEAR(most, o.high[0], 0.01);
}

TEST_F(TriplaneFieldTest, OtherPointsHaveTheValuesOfTheSamePlaces) {
  const auto points = cloud(40, 7);
  const auto field = make_triplane_field({}, points);
  const auto p = disturbed(field->constant(std::vector<double>{3}), 0.3, 8);
  const auto values = field->values(p);
  EXPECT_EQ(field->values_at(p, points), values);
  const auto one = field->values_at(p, std::vector<Vec3f>{points[17]});
  EXPECT_NEAR(one[0], values[17], 1e-12);
  const auto outside = field->values_at(p, std::vector<Vec3f>{{9, 9, 9}, {2.2f, -0.6f, 0.6f}});
  EXPECT_NEAR(outside[0], outside[1], 1e-12);
}

TEST_F(TriplaneFieldTest, EqualForASeedAndLeavesTheNumberOfThreadsAlone) {
  const auto points = cloud(300, 9);
  const int threads = omp_get_max_threads();
  omp_set_num_threads(3);
  for (const int torch_threads : {1, 2}) {
    TriplaneOptions o;
    o.resolution = 24;
    o.seed = 5;
    o.threads = torch_threads;
    std::vector<double> first, gradient;
    for (int run = 0; run < 2; ++run) {
      const auto field = make_triplane_field(o, points);
      const auto p = field->constant(std::vector<double>{2});
      const auto g = field->values_adjoint(disturbed(p, 0.1, 1), std::vector<double>(300, 1.0));
      if (run) {
        EXPECT_EQ(p, first);
        EXPECT_EQ(g, gradient);
      }
      first = p;
      gradient = g;
      EXPECT_EQ(omp_get_max_threads(), 3);
    }
    o.seed = 6;
    EXPECT_NE(make_triplane_field(o, points)->constant(std::vector<double>{2}), first);
  }
  omp_set_num_threads(threads);
}

TEST_F(TriplaneFieldTest, CanFollowASmoothField) {
  const auto points = cloud(400, 10), others = cloud(200, 11);
  const auto truth = [](const Vec3f& x) {
    return 11 + std::sin(8 * (x.y() + 1)) + 5 * (x.x() - 2) * (1 + 10 * (x.z() - 0.5));
  };
  const auto field = make_triplane_field({}, points);
  auto p = field->constant(std::vector<double>{11});
  Adam<double> adam(p.size());
  for (int step = 0; step < 150; ++step) {
    auto residual = field->values(p);
    for (size_t i = 0; i < points.size(); ++i) residual[i] = (residual[i] - truth(points[i])) / points.size();
    adam.step(p, field->values_adjoint(p, residual), 1e-2);
  }
  const auto values = field->values_at(p, others);
  double mean = 0, spread = 0, error = 0;
  for (const Vec3f& x : others) mean += truth(x) / others.size();
  for (size_t i = 0; i < others.size(); ++i) {
    spread += std::pow(truth(others[i]) - mean, 2);
    error += std::pow(truth(others[i]) - values[i], 2);
  }
  EXPECT_GT(1 - error / spread, 0.99);
}

TEST(TriplaneFields, AreThereWhereTheyAreRequiredOrThatIsSaid) {
  if (has_triplane_fields())
    EXPECT_NO_THROW(require_triplane_fields());
  else
    expect_error(Failure::kInput, {"pliant_triplanes.so", "libtorch"}, [] { require_triplane_fields(); });
}

TEST(TriplaneOptions, ImpossibleOnesAreRefusedBeforeAnythingIsLoaded) {
  TriplaneOptions o;
  o.low = {2};
  o.high = {1};
  EXPECT_THROW(make_triplane_field(o, cloud(3, 1)), Error);
  EXPECT_THROW(make_triplane_field({}, {}), Error);
}

}  // namespace
}  // namespace pliant

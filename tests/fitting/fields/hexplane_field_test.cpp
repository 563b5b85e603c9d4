#include "fitting/fields/hexplane_field.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "fitting/fields/triplane_field.h"
#include "tests/check_adjoint.h"

namespace pliant {
namespace {

const std::vector<double> kTimes = {0, 0.3, 1};

std::vector<Vec3f> points_in_box(int count, uint64_t seed) {
  std::vector<Vec3f> points;
  for (int i = 0; i < count; ++i) {
    Random random(seed, i);
    for (float& c : points.emplace_back().reshaped()) c = static_cast<float>(random.uniform(-1, 1));
    points.back() = points.back().cwiseProduct(Vec3f(0.1f, 0.3f, 0.05f)) + Vec3f(2, -1, 0.5f);
  }
  return points;
}

/// Away from the constant start, so that every parameter counts.
std::vector<double> away_from(std::vector<double> p, double by, uint64_t seed) {
  for (size_t i = 0; i < p.size(); ++i) p[i] += by * Random(seed, i).normal();
  return p;
}

HexplaneOptions small_options(int layers) {
  HexplaneOptions o;
  o.channels = 2;
  o.space_resolution = 4;
  o.time_resolution = 5;
  o.features = 6;
  o.hidden = 8;
  o.layers = layers;
  o.scale = 0.5;
  return o;
}

/// Of a plane [rows, columns] at a place in [0, 1], bilinear.
double on_plane(const double* plane, int rows, int columns, double across, double down) {
  const double x = across * (columns - 1), y = down * (rows - 1);
  const int column = std::min(static_cast<int>(x), columns - 2), row = std::min(static_cast<int>(y), rows - 2);
  const double a = x - column, b = y - row;
  const double* corner = plane + row * columns + column;
  return (1 - b) * ((1 - a) * corner[0] + a * corner[1]) + b * ((1 - a) * corner[columns] + a * corner[columns + 1]);
}

/// [channels] the field at a place and a time, all in [0, 1].
std::vector<double> field_at(const HexplaneOptions& o, std::span<const double> p, const Vec3d& place, double time) {
  constexpr int kFirst[3] = {0, 0, 1}, kSecond[3] = {1, 2, 2};
  const int space = o.space_resolution, rows = o.time_resolution;
  const double* planes_of_time = p.data() + 3 * o.features * space * space;
  std::vector<double> x;
  for (int f = 0; f < o.features; ++f) {
    double product = 1;
    for (int k = 0; k < 3; ++k) {
      const double* of_space = p.data() + (k * o.features + f) * space * space;
      const double* of_time = planes_of_time + (k * o.features + f) * rows * space;
      product *= on_plane(of_space, space, space, place[kFirst[k]], place[kSecond[k]]) *
                 on_plane(of_time, rows, space, place[k], time);
    }
    x.push_back(product);
  }
  const double* weight = planes_of_time + 3 * o.features * rows * space;
  for (int layer = 0; layer < o.layers; ++layer) {
    const bool last = layer + 1 == o.layers;
    const size_t in = x.size(), out = last ? o.channels : o.hidden;
    const double* bias = weight + out * in;
    std::vector<double> y;
    for (size_t j = 0; j < out; ++j) {
      double sum = 0;
      for (size_t i = 0; i < in; ++i) sum += weight[j * in + i] * x[i];
      y.push_back(last ? o.scale * sum + bias[j] : std::max(0.0, sum + bias[j]));
    }
    x = y;
    weight = bias + out;
  }
  return x;
}

class HexplaneFieldTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!has_triplane_fields()) GTEST_SKIP() << "built without libtorch";
  }
};

TEST_F(HexplaneFieldTest, StartsAsTheConstantThatItIsAskedFor) {
  for (const int layers : {1, 2, 3}) {
    const auto field = make_hexplane_field(small_options(layers), points_in_box(50, 1), kTimes);
    EXPECT_EQ(field->points(), 150u);
    const auto p = field->constant(std::vector<double>{0.7, -14});
    EXPECT_EQ(p.size(), field->parameters());
    const auto values = field->values(p);
    ASSERT_EQ(values.size(), 300u);
    for (size_t i = 0; i < values.size(); ++i) EXPECT_NEAR(values[i], i % 2 ? -14 : 0.7, 1e-12);
  }
}

TEST_F(HexplaneFieldTest, ValuesAreTheNetworkOfTheProductOfSixPlanes) {
  const auto points = points_in_box(40, 2);
  Box box;
  for (const Vec3f& x : points) box.add(x);
  const Vec3d centre = box.centre().cast<double>(), size = box.size().cast<double>();
  for (const int layers : {1, 2, 3}) {
    const HexplaneOptions o = small_options(layers);
    const auto field = make_hexplane_field(o, points, kTimes);
    const auto p = away_from(field->constant(std::vector<double>{1, 2}), 0.3, 3);
    const auto values = field->values(p);
    ASSERT_EQ(values.size(), kTimes.size() * points.size() * 2);
    size_t at = 0;
    for (const double time : kTimes) {
      for (const Vec3f& point : points) {
        Vec3d place = (point.cast<double>() - centre).cwiseQuotient(size);
        for (double& c : place) c = std::clamp(c + 0.5, 0.0, 1.0);
        for (const double expected : field_at(o, p, place, time)) EXPECT_NEAR(values[at++], expected, 1e-12);
      }
    }
  }
}

TEST_F(HexplaneFieldTest, AdjointsOfValuesAndRoughnessAgreeWithDifferences) {
  AdjointCheckOptions check;
  check.step = 1e-4;  // shorter than the way to the next kink of a ReLU
  check.unit_cotangents = 6;
  check.inputs = 300;
  for (const int layers : {2, 3}) {
    const auto field = make_hexplane_field(small_options(layers), points_in_box(8, 2), kTimes);
    const auto p = away_from(field->constant(std::vector<double>{1, 2}), 0.3, 3);
    const AdjointCheck of_values = check_adjoint(
        [&](const std::vector<double>& q) { return field->values(q); },
        [&](const std::vector<double>& q, const std::vector<double>& w) { return field->values_adjoint(q, w); }, p,
        check);
    EXPECT_LE(of_values.worst, 1e-6) << of_values.message;
    const AdjointCheck of_roughness =
        check_adjoint([&](const std::vector<double>& q) { return std::vector<double>{field->roughness(q, 2, {})}; },
                      [&](const std::vector<double>& q, const std::vector<double>& w) {
                        std::vector<double> gradient(q.size(), 1.0);  // it is added
                        field->roughness(q, 2 * w[0], gradient);
                        for (double& g : gradient) g -= 1;
                        return gradient;
                      },
                      p, check);
    EXPECT_LE(of_roughness.worst, 1e-6) << of_roughness.message;
  }
}

TEST_F(HexplaneFieldTest, RoughnessIsTheSlopeInSpaceAndTheCurvatureInTime) {
  const HexplaneOptions o = small_options(2);
  const auto field = make_hexplane_field(o, points_in_box(3, 4), kTimes);
  std::vector<double> p(field->parameters(), 0.0);
  const int space = 3 * 6 * 4 * 4, time = 3 * 6 * 5 * 4;
  // Slope 0.25 along rows and -2 across.
  for (int i = 0; i < space; ++i) p[i] = 0.25 * (i % 4) - 2 * (i / 4 % 4);
  EXPECT_NEAR(field->roughness(p, 10, {}), 10 * 3 * (0.0625 + 4), 1e-12);
  // Steps across space and slopes along time are free; second differences along time are 0.5.
  for (int i = 0; i < time; ++i) p[space + i] = 7 * (i % 4) + 3 * (i / 4 % 5);
  EXPECT_NEAR(field->roughness(p, 10, {}), 10 * 3 * (0.0625 + 4), 1e-12);
  for (int i = 0; i < time; ++i) p[space + i] += 0.25 * std::pow(i / 4 % 5, 2);
  EXPECT_NEAR(field->roughness(p, 10, {}), 10 * 3 * (0.0625 + 4 + 0.25), 1e-12);
}

TEST_F(HexplaneFieldTest, EqualForASeed) {
  const auto points = points_in_box(100, 5);
  for (const int threads : {1, 2}) {
    HexplaneOptions o;
    o.seed = 5;
    o.threads = threads;
    std::vector<double> first, values, gradient;
    for (int run = 0; run < 2; ++run) {
      const auto field = make_hexplane_field(o, points, kTimes);
      const auto p = field->constant(std::vector<double>{0, 1, 2});
      const auto moved = away_from(p, 0.1, 1);
      const auto v = field->values(moved), g = field->values_adjoint(moved, std::vector<double>(900, 1.0));
      if (run) {
        EXPECT_EQ(p, first);
        EXPECT_EQ(v, values);
        EXPECT_EQ(g, gradient);
      }
      first = p;
      values = v;
      gradient = g;
    }
    o.seed = 6;
    EXPECT_NE(make_hexplane_field(o, points, kTimes)->constant(std::vector<double>{0, 1, 2}), first);
  }
}

TEST(HexplaneOptions, ImpossibleOnesAreRefusedByName) {
  const auto points = points_in_box(3, 6);
  const auto refused = [&](const HexplaneOptions& o, std::span<const Vec3f> x, const std::vector<double>& times) {
    try {
      make_hexplane_field(o, x, times);
    } catch (const Error& e) {
      EXPECT_EQ(e.failure, Failure::kUsage);
      return e.field;
    }
    return std::string("nothing");
  };
  EXPECT_EQ(refused({}, {}, kTimes), "points");
  EXPECT_EQ(refused({}, points, {}), "times");
  EXPECT_EQ(refused({}, points, {0, 1.5}), "times");
  EXPECT_EQ(refused({}, points, {0, NAN}), "times");
  const std::pair<const char*, int HexplaneOptions::*> sizes[] = {
      {"channels", &HexplaneOptions::channels},
      {"features", &HexplaneOptions::features},
      {"hidden", &HexplaneOptions::hidden},
      {"layers", &HexplaneOptions::layers},
      {"threads", &HexplaneOptions::threads},
      {"space_resolution", &HexplaneOptions::space_resolution},
      {"time_resolution", &HexplaneOptions::time_resolution}};
  for (const auto& [name, size] : sizes) {
    HexplaneOptions o;
    o.*size = 0;
    EXPECT_EQ(refused(o, points, kTimes), name);
  }
  HexplaneOptions o;
  o.time_resolution = 2;
  EXPECT_EQ(refused(o, points, kTimes), "time_resolution");
}

}  // namespace
}  // namespace pliant

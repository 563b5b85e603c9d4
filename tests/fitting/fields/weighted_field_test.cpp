// Fields that leave what is held alone, and a field for each axis.

#include "fitting/fields/weighted_field.h"

#include <gtest/gtest.h>

#include "fitting/fields/axes_field.h"
#include "fitting/fields/smooth_field.h"
#include "fitting/fit/fit_material.h"
#include "tests/check_adjoint.h"
#include "tests/fitting/twin_stem.h"

namespace pliant {
namespace {

using fixture::TwinStem;

std::vector<double> drawn(size_t count, double sigma, uint64_t seed) {
  std::vector<double> p;
  for (size_t i = 0; i < count; ++i) p.push_back(sigma * Random(seed, i).normal());
  return p;
}

void expect_adjoint(const Field& field, const std::vector<double>& at) {
  AdjointCheckOptions check;
  check.step = 1e-4;
  check.unit_cotangents = 4;
  check.inputs = 60;
  const AdjointCheck found = check_adjoint(
      [&](const std::vector<double>& p) { return field.values(p); },
      [&](const std::vector<double>& p, const std::vector<double>& w) { return field.values_adjoint(p, w); }, at,
      check);
  EXPECT_LE(found.worst, 1e-6) << found.message;
}

TEST(WeightedField, ValuesAndTheirAdjointAreThoseOfTheFieldTimesTheWeights) {
  const TwinStem twin;
  const auto smooth = std::make_shared<SmoothField>(SmoothFieldOptions{}, twin.particles.position);
  const auto axes = std::make_shared<AxesField>(smooth);
  std::vector<double> weight = drawn(axes->points(), 1, 5);
  weight[7] = 0;
  const WeightedField field(axes, weight);
  const std::vector<double> p = drawn(3 * smooth->parameters(), 1, 6), values = field.values(p);
  for (int axis = 0; axis < 3; ++axis) {
    const auto one = smooth->values(std::span(p).subspan(axis * smooth->parameters(), smooth->parameters()));
    for (size_t i = 0; i < one.size(); ++i) EXPECT_EQ(values[3 * i + axis], weight[i] * one[i]);
  }
  expect_adjoint(field, p);
  EXPECT_EQ(axes->constant(std::vector<double>{0, 0, 0}), std::vector<double>(3 * smooth->parameters(), 0.0));
}

TEST(WeightedField, FieldsOfGradientsLeaveWhatIsPinnedForGoodAsItIs) {
  const TwinStem twin;
  std::vector<Interaction> acting = twin.pins;
  Interaction passing = twin.pins[0];  // one that ends, higher up
  passing.region = Region::half_space(Vec3d(0, 0, 0.05), Vec3d(0, 0, 1));
  passing.duration = 0.1;
  acting.push_back(passing);
  const std::vector<double> free = free_particles(twin.particles, acting);
  MaterialFitOptions options;
  for (const MaterialKind kind : {MaterialKind::kSmooth, MaterialKind::kKan, MaterialKind::kTriplanes}) {
    if (kind == MaterialKind::kTriplanes && !has_triplane_fields()) GTEST_SKIP() << "built without libtorch";
    options.kind = kind;
    const ClipFitOptions varied = gradient_fields(options, twin.particles, acting);
    Motion<float> motion{twin.particles, initial_state(twin.particles), acting, {}};
    GradientFitParameters at;
    // Away from the start, at which the network's output is constant.
    at.material = varied.material->constant(std::vector<double>{0.3});
    if (varied.velocity) at.velocity = varied.velocity->constant(std::vector<double>{1, 2, 3});
    for (auto* part : {&at.material, &at.velocity}) {
      const std::vector<double> by = drawn(part->size(), 0.1, 8);
      for (size_t i = 0; i < part->size(); ++i) (*part)[i] += by[i];
    }
    const Motion<float> found = with_fields(motion, varied.fields(), at);
    size_t held = 0;
    for (size_t i = 0; i < free.size(); ++i) {
      const bool below = twin.particles.position[i].z() <= 0.015f;
      EXPECT_EQ(free[i], below ? 0 : 1);
      held += below;
      EXPECT_EQ(found.particles.young[i] == twin.particles.young[i], below) << i;
      EXPECT_EQ(found.start.v[i].isZero(0), below || !varied.velocity) << i;
    }
    EXPECT_GT(held, 10u);
    expect_adjoint(*varied.material, at.material);
    if (varied.velocity) expect_adjoint(*varied.velocity, at.velocity);
  }
}

}  // namespace
}  // namespace pliant

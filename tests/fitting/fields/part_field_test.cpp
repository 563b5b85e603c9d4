#include "fitting/fields/part_field.h"

#include <gtest/gtest.h>

#include "gaussians/base/random.h"

namespace pliant {
namespace {

std::vector<double> numbers(size_t count, uint64_t seed) {
  std::vector<double> out(count);
  for (size_t i = 0; i < count; ++i) out[i] = Random(seed, i).normal();
  return out;
}

TEST(PartField, EveryPointHasTheValueOfItsPart) {
  const PartField field({2, 0, 1, 2}, 1);
  EXPECT_EQ(field.values(std::vector<double>{10, 20, 30}), (std::vector<double>{30, 10, 20, 30}));
  EXPECT_EQ(field.values(field.constant(std::vector<double>{7})), (std::vector<double>{7, 7, 7, 7}));
}

TEST(PartField, AdjointIsTheTransposeOfValues) {
  const PartField field({1, 0, 1, 2, 1}, 3);
  const auto p = numbers(9, 1), w = numbers(15, 2);
  const auto values = field.values(p), adj = field.values_adjoint(p, w);
  double forward = 0, reverse = 0;
  for (size_t i = 0; i < w.size(); ++i) forward += w[i] * values[i];
  for (size_t i = 0; i < p.size(); ++i) reverse += p[i] * adj[i];
  EXPECT_NEAR(forward, reverse, 1e-12);
}

}  // namespace
}  // namespace pliant

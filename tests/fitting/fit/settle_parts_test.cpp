#include "fitting/fit/settle_parts.h"

#include <gtest/gtest.h>

#include "gaussians/base/random.h"

namespace pliant {
namespace {

/// A rod in x whose left half is of another colour, in light that differs from point to point; the parts put the border
/// wrong.
struct Rod {
  std::vector<Vec3f> position, color;
  std::vector<uint8_t> thin, held;
  std::vector<uint32_t> truth, given;

  explicit Rod(double border) {
    for (size_t i = 0; i < 800; ++i) {
      Random random(3, i);
      const Vec3d x(random.uniform(-1, 1), random.uniform(0, 0.1), random.uniform(0, 0.1));
      const double light = random.uniform(0.5, 1);
      const Vec3d base = x.x() < 0 ? Vec3d(0.5, 0.4, 0.3) : Vec3d(0.4, 0.5, 0.3),
                  noise(random.normal(), random.normal(), random.normal());
      position.push_back(x.cast<float>());
      color.push_back((light * base + 0.005 * noise).cast<float>());
      thin.push_back(0);
      held.push_back(0);
      truth.push_back(x.x() >= 0);
      given.push_back(x.x() >= border);
    }
  }
  size_t wrong(const std::vector<uint32_t>& part) const {
    size_t count = 0;
    for (size_t i = 0; i < part.size(); ++i) count += part[i] != truth[i];
    return std::min(count, part.size() - count);  // whichever is called the first
  }
};

TEST(SettleParts, BordersGoWhereTheColourChangesInAnyLight) {
  for (const double border : {-0.2, 0.0, 0.2}) {
    const Rod rod(border);
    const std::vector<uint32_t> settled = settle_parts({}, rod.given, rod.position, rod.color, rod.thin);
    EXPECT_LE(rod.wrong(settled), 12u) << border << ", was " << rod.wrong(rod.given);
  }
  EXPECT_GT(Rod(0.2).wrong(Rod(0.2).given), 60u);
}

TEST(SettleParts, WhatIsThinGoesWithTheThin) {
  Rod rod(0.2);
  for (size_t i = 0; i < 800; ++i) {
    rod.color[i] = Vec3f(0.4f, 0.4f, 0.4f);
    rod.thin[i] = rod.truth[i];
  }
  SettleOptions options;
  options.like = 0.2;  // one look alone speaks softly where many points are on the wrong side
  EXPECT_EQ(rod.wrong(settle_parts(options, rod.given, rod.position, rod.color, rod.thin)), 0u);
}

TEST(SettleParts, OnePointAmongOthersTakesAfterThem) {
  // Its colour lies between both parts'.
  Rod rod(0);
  size_t odd = 0;
  while (std::abs(rod.position[odd].x() - 0.6f) > 0.05f) ++odd;
  rod.given[odd] = 0;
  rod.color[odd] = Vec3f(0.45f, 0.45f, 0.3f);
  const std::vector<uint32_t> settled = settle_parts({}, rod.given, rod.position, rod.color, rod.thin);
  EXPECT_EQ(settled[odd] == settled[0], rod.truth[odd] == rod.truth[0]);
}

TEST(SettleParts, WhatIsHeldStaysAndHasNoSay) {
  Rod rod(0.2);
  const std::vector<uint32_t> without = settle_parts({}, rod.given, rod.position, rod.color, rod.thin);
  Random random(4);
  for (size_t i = 0; i < 200; ++i) {
    rod.position.push_back(rod.position[i]);
    rod.color.push_back(Vec3f(0, 0, 1));
    rod.thin.push_back(1);
    rod.given.push_back(rod.given[i]);
    rod.held.push_back(1);
  }
  const std::vector<uint32_t> with = settle_parts({}, rod.given, rod.position, rod.color, rod.thin, rod.held);
  for (size_t i = 0; i < 800; ++i) EXPECT_EQ(with[i], without[i]) << i;
  for (size_t i = 800; i < 1000; ++i) EXPECT_EQ(with[i] == with[0], rod.given[i] == with[0]) << i;
}

TEST(SettleParts, APartThatLosesAllItsPointsLeavesNoGap) {
  Rod rod(0);
  for (size_t i = 0; i < 800; ++i) rod.given[i] = rod.truth[i] == 0 ? 0 : 2;
  rod.given[5] = 1;
  const std::vector<uint32_t> settled = settle_parts({}, rod.given, rod.position, rod.color, rod.thin);
  EXPECT_EQ(*std::max_element(settled.begin(), settled.end()), 1u);
}

}  // namespace
}  // namespace pliant

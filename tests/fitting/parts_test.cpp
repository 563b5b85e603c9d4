#include "fitting/fit/parts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "gaussians/base/random.h"

namespace pliant {
namespace {

/// Two blobs of 200 points each, 1 apart, red and green, and 1000 points of a third below them in two blues.
struct Blobs {
  std::vector<Vec3f> position, color;
  std::vector<uint8_t> held;

  Blobs() {
    for (size_t i = 0; i < 1400; ++i) {
      const bool base = i >= 400, second = i % 2;
      const Vec3d middle = base ? Vec3d(second ? -3 : 3, 0, -3) : Vec3d(second ? 1 : 0, 0, 0);
      Random random(1, i);
      position.push_back((middle + 0.1 * Vec3d(random.normal(), random.normal(), random.normal())).cast<float>());
      color.push_back(base ? Vec3f(0, second ? 0.4f : 0, 1) : second ? Vec3f(0.9f, 0, 0) : Vec3f(0, 0.9f, 0));
      held.push_back(base);
    }
  }
};

TEST(Parts, PlaceAndColourTellBlobsApart) {
  const Blobs blobs;
  PartsOptions options;
  options.count = 4;
  const std::vector<uint32_t> part = find_parts(options, blobs.position, blobs.color);
  for (size_t i = 0; i < part.size(); ++i) EXPECT_EQ(part[i], part[i < 400 ? i % 2 : 400 + i % 2]);
  EXPECT_EQ(std::set<uint32_t>(part.begin(), part.end()), (std::set<uint32_t>{0, 1, 2, 3}));
}

TEST(Parts, WhatIsHeldTakesNoPartsOfItsOwn) {
  const Blobs blobs;
  PartsOptions options;
  options.count = 2;
  // Without knowing what is held, its many and far points would take both.
  const std::vector<uint32_t> unaware = find_parts(options, blobs.position, blobs.color);
  EXPECT_EQ(unaware[0], unaware[1]);
  const std::vector<uint32_t> part = find_parts(options, blobs.position, blobs.color, blobs.held);
  for (size_t i = 0; i < 400; ++i) EXPECT_EQ(part[i], part[i % 2]);
  EXPECT_NE(part[0], part[1]);
  EXPECT_LE(*std::max_element(part.begin(), part.end()), 1u);
}

TEST(Parts, ThereAreNoMorePartsThanDifferentPoints) {
  PartsOptions options;
  options.count = 5;
  const std::vector<Vec3f> position = {Vec3f(0, 0, 0), Vec3f(1, 0, 0), Vec3f(0, 0, 0), Vec3f(1, 0, 0)}, color(4, Vec3f::Zero());
  EXPECT_EQ(find_parts(options, position, color), (std::vector<uint32_t>{0, 1, 0, 1}));
  EXPECT_EQ(find_parts(options, position, color, std::vector<uint8_t>(4, 1)), (std::vector<uint32_t>{0, 0, 0, 0}));
}

}  // namespace
}  // namespace pliant

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
  const std::vector<Vec3f> position = {Vec3f(0, 0, 0), Vec3f(1, 0, 0), Vec3f(0, 0, 0), Vec3f(1, 0, 0)},
                           color(4, Vec3f::Zero());
  EXPECT_EQ(find_parts(options, position, color), (std::vector<uint32_t>{0, 1, 0, 1}));
  EXPECT_EQ(find_parts(options, position, color, std::vector<uint8_t>(4, 1)), (std::vector<uint32_t>{0, 0, 0, 0}));
}

/// Four parts of 100 points: two of nearly the same colour, one of that colour but thin, one of another.
struct Patches {
  std::vector<uint32_t> part;
  std::vector<Vec3f> color;
  std::vector<uint8_t> thin;

  Patches() {
    for (uint32_t i = 0; i < 400; ++i) {
      Random random(2, i);
      const Vec3d mean = i / 100 == 3 ? Vec3d(0.7, 0.2, 0.2) : Vec3d(0.2, i / 100 == 1 ? 0.32 : 0.3, 0.1);
      part.push_back(i / 100);
      thin.push_back(i / 100 == 2);
      color.push_back((mean + 0.05 * Vec3d(random.normal(), random.normal(), random.normal())).cast<float>());
    }
  }
};

TEST(Parts, ThoseThatLookAlikeAreOneMaterialUnlessOneIsThin) {
  const Patches patches;
  const std::vector<uint32_t> material = join_alike({}, patches.part, patches.color, patches.thin).value();
  for (uint32_t i = 0; i < 400; ++i) EXPECT_EQ(material[i], (std::vector<uint32_t>{0, 0, 1, 2})[i / 100]) << i;
}

TEST(Parts, WhatIsHeldHasNoSayInTheLook) {
  // Half of the second part is held and blue: by the mean of all its points it would be another material.
  Patches patches;
  std::vector<uint8_t> held(400, 0);
  for (uint32_t i = 100; i < 150; ++i) {
    patches.color[i] = Vec3f(0, 0, 1);
    held[i] = 1;
  }
  EXPECT_NE(join_alike({}, patches.part, patches.color, patches.thin).value()[199], 0u);
  EXPECT_EQ(join_alike({}, patches.part, patches.color, patches.thin, held).value()[199], 0u);
}

TEST(Parts, OfOneColourTheyTellNoMaterials) {
  const Patches patches;
  const std::vector<Vec3f> color(400, Vec3f(0.4f, 0.4f, 0.4f));
  EXPECT_FALSE(join_alike({}, patches.part, color, std::vector<uint8_t>(400, 0)));
}

}  // namespace
}  // namespace pliant

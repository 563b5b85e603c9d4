#include "fitting/distribution/object_corpus.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "tests/temporary_folder.h"

namespace pliant {
namespace {

std::vector<std::string> all_families() {
  std::vector<std::string> all;
  for (const FamilyRole role : {FamilyRole::kTrain, FamilyRole::kValidate, FamilyRole::kTest})
    for (const std::string& name : corpus_families(role)) all.push_back(name);
  return all;
}

TEST(ObjectCorpus, FamiliesAreManyAndOfOneRole) {
  const auto all = all_families();
  EXPECT_EQ(std::set<std::string>(all.begin(), all.end()).size(), all.size());
  EXPECT_GE(corpus_families(FamilyRole::kTrain).size(), 14u);
  EXPECT_GE(corpus_families(FamilyRole::kValidate).size(), 3u);
  EXPECT_GE(corpus_families(FamilyRole::kTest).size(), 3u);
}

TEST(ObjectCorpus, FieldsAreInsidePhysicalBoundsAndSamplesAreAnObject) {
  for (const std::string& family : all_families()) {
    for (uint64_t seed = 0; seed < 4; ++seed) {
      SCOPED_TRACE(family + " " + std::to_string(seed));
      const MaterialObject o = make_object(family, seed);
      const size_t n = o.samples.size();
      EXPECT_EQ(o.family, family);
      EXPECT_GE(n, 500u);
      EXPECT_LE(n, 3000u);
      ASSERT_EQ(o.samples.volume.size(), n);
      ASSERT_EQ(o.samples.thickness.size(), n);
      ASSERT_EQ(o.young.size(), n);
      ASSERT_EQ(o.poisson.size(), n);
      ASSERT_EQ(o.density.size(), n);
      ASSERT_EQ(o.colour.size(), n);
      ASSERT_TRUE(o.part.empty() || o.part.size() == n);
      Box box;
      for (size_t i = 0; i < n; ++i) {
        ASSERT_TRUE(o.young[i] > 0 && std::isfinite(o.young[i]));
        ASSERT_TRUE(o.density[i] > 0 && std::isfinite(o.density[i]));
        ASSERT_TRUE(o.poisson[i] >= 0 && o.poisson[i] <= 0.49f);
        ASSERT_TRUE(o.samples.volume[i] > 0);
        ASSERT_TRUE(o.samples.thickness[i] >= 0);
        ASSERT_TRUE(o.colour[i].minCoeff() >= 0 && o.colour[i].maxCoeff() <= 1);
        ASSERT_TRUE(o.samples.position[i].allFinite());
        box.add(o.samples.position[i]);
      }
      EXPECT_GT(box.size().norm(), 0.005f);
      EXPECT_LT(box.size().norm(), 5.0f);
      EXPECT_LE(o.samples.total_volume(), double{box.size().prod()} * 1.2);
    }
  }
}

TEST(ObjectCorpus, ASeedGivesTheSameObjectTwiceAndAnotherSeedAnother) {
  for (const std::string& family : all_families()) {
    const MaterialObject a = make_object(family, 7), b = make_object(family, 7), c = make_object(family, 8);
    EXPECT_EQ(a.young, b.young);
    EXPECT_EQ(a.samples.position, b.samples.position);
    EXPECT_EQ(a.colour, b.colour);
    EXPECT_EQ(a.part, b.part);
    EXPECT_NE(a.young, c.young) << family;
  }
}

TEST(ObjectCorpus, AnUnknownFamilyIsRefusedWithTheNearest) {
  expect_error(Failure::kUsage, {"flowr", "flower"}, [] { make_object("flowr", 1); });
}

// What the families claim, seen in what they make.
TEST(ObjectCorpus, StemsStiffenTowardTheirFoot) {
  ObjectBuilder b("stem", 3);
  const PlantTissue t = woody(b);
  add_stem(b, t, b.new_part(), curve(Vec3f::Zero(), Vec3f::UnitZ(), 1, Vec3f::UnitX(), 0.2f), 0.02f, 0.01f);
  const MaterialObject o = b.build();
  double foot = 0, tip = 0, feet = 0, tips = 0;
  for (size_t i = 0; i < o.young.size(); ++i) {
    const float z = o.samples.position[i].z();
    (z < 0.3f ? foot : tip) += z < 0.3f || z > 0.7f ? std::log10(o.young[i]) : 0;
    (z < 0.3f ? feet : tips) += z < 0.3f || z > 0.7f;
  }
  EXPECT_GT(foot / feet, tip / tips + 0.1);
}

// Shares of samples in a half agree with the shares of volume, and the volume with counting in a box.
template <class Shape>
void expect_uniform(const Shape& shape, const Box& box) {
  Random random(5);
  const int trials = 40000;
  int inside = 0, low = 0, sampled_low = 0;
  const float middle = box.centre().z();
  for (int i = 0; i < trials; ++i) {
    Vec3f x;
    for (int c = 0; c < 3; ++c) x[c] = static_cast<float>(random.uniform(box.low[c], box.high[c]));
    if (!shape.contains(x)) continue;
    ++inside;
    low += x.z() < middle;
  }
  const double counted = static_cast<double>(box.size().prod()) * inside / trials;
  EXPECT_NEAR(shape.volume(), counted, 4 * counted / std::sqrt(static_cast<double>(inside)));
  int contained = 0;
  for (int i = 0; i < 4000; ++i) {
    const ShapePoint p = shape.sample(random);
    contained += shape.contains(p.position);
    sampled_low += p.position.z() < middle;
    ASSERT_TRUE(p.along >= 0 && p.along <= 1 && p.depth >= -1e-6f);
  }
  EXPECT_GE(contained, 3900);
  EXPECT_NEAR(sampled_low / 4000.0, static_cast<double>(low) / inside, 0.05);
}

TEST(Shapes, SampleUniformlyWhatTheyContain) {
  const Box box{{-1.2f, -1.2f, -0.2f}, {1.2f, 1.2f, 2.2f}};
  expect_uniform(Tube(curve(Vec3f::Zero(), Vec3f::UnitZ(), 1.8f, Vec3f::UnitX(), 0.0f), 0.5f, 0.2f), box);
  expect_uniform(Ellipsoid({0, 0, 1}, {0.5f, 1, 0.8f}), box);
  expect_uniform(Ellipsoid({0, 0, 1}, {1, 1, 1}, Mat3f::Identity(), 0.3f), box);
  expect_uniform(Lathe(Vec3f::Zero(), Vec3f::UnitZ(), 2, [](float s) { return 1 - 0.5f * s; }), box);
  expect_uniform(
      Lathe(
          Vec3f::Zero(), Vec3f::UnitZ(), 2, [](float s) { return 0.5f + 0.5f * s; }, [](float) { return 0.4f; }),
      box);
  expect_uniform(Cuboid({0, 0, 1}, {0.4f, 0.9f, 0.6f}), box);
}

TEST(Shapes, AFlatSheetHasTheVolumeOfItsOutline) {
  const Sheet sheet(
      curve(Vec3f::Zero(), Vec3f::UnitX(), 2, Vec3f::UnitZ(), 0), Vec3f::UnitY(), [](float s) { return 0.5f * s; }, 0,
      0.01f);
  EXPECT_NEAR(sheet.volume(), 2 * 2 * 0.25 * 0.01, 1e-4 * 0.01);
  Random random(1);
  for (int i = 0; i < 1000; ++i) {
    const ShapePoint p = sheet.sample(random);
    ASSERT_LE(std::abs(p.position.z()), 0.00501f);
    ASSERT_LE(std::abs(p.position.y()), 0.25f * p.position.x() + 1e-5f);
  }
}

}  // namespace
}  // namespace pliant

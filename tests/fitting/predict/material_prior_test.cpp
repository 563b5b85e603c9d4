#include "fitting/predict/material_prior.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/temporary_folder.h"

namespace pliant {
namespace {

MaterialPrior prior(const char* label) { return prior_of(match_label(material_table(), label).value()); }

}  // namespace

TEST(MaterialPrior, IsTheMeanOfTheMovingPartsInLogarithms) {
  const MaterialTable& table = material_table();
  const MaterialPrior p = prior("potted flower");
  double sum = 0, young = 0, low = 0, density = 0;
  for (const KnownPart& part : table.objects[table.object_of.at("potted flower")].parts) {
    if (!part.moves) continue;
    const KnownMaterial& m = table.materials[part.material];
    sum += part.share;
    young += part.share * std::log10(m.young.typical);
    low += part.share * std::log10(m.young.low);
    density += part.share * std::log10(m.density.typical);
  }
  EXPECT_NEAR(std::log10(p.young.typical), young / sum, 1e-12);
  EXPECT_NEAR(std::log10(p.young.low), low / sum, 1e-12);
  EXPECT_NEAR(std::log10(p.density.typical), density / sum, 1e-12);
  EXPECT_EQ(p.parts.size(), 5u);
  EXPECT_EQ(p.groups, std::vector<std::string>{"plant"});
  ASSERT_TRUE(p.height && p.frequency);
  EXPECT_GT(p.height->typical, 0);
}

TEST(MaterialPrior, OfAMaterialAloneIsItsRow) {
  const MaterialPrior p = prior("silicone rubber");
  const KnownMaterial& m = find_material(material_table(), "silicone rubber");
  EXPECT_NEAR(p.young.low / m.young.low, 1, 1e-12);
  EXPECT_NEAR(p.young.high / m.young.high, 1, 1e-12);
  EXPECT_EQ(p.law.law, Law::kNeoHookean);
  EXPECT_FALSE(p.height || p.frequency);
}

TEST(MaterialPrior, FrequencyFollowsTheMaterialThatALabelNames) {
  const KnownMaterial &wood = find_material(material_table(), "wood"),
                      &steel = find_material(material_table(), "steel");
  const double ratio =
      steel.young.typical / wood.young.typical / (steel.density.typical / wood.density.typical);  // f^2 ~ E / rho
  for (double Band::*end : {&Band::low, &Band::typical, &Band::high})
    EXPECT_NEAR((*prior("steel chair").frequency).*end / ((*prior("chair").frequency).*end), std::sqrt(ratio), 1e-9);
  EXPECT_EQ(prior("wooden chair").frequency->typical, prior("chair").frequency->typical);
  EXPECT_GT(prior("paper flower").frequency->typical, prior("flower").frequency->typical);
  EXPECT_FALSE(prior("bronze elephant").frequency || prior("bronze elephant").height) << "elephants are large";
  EXPECT_LT(prior("plush elephant").height->high, 1) << "plush toys are not";
  EXPECT_EQ(prior("gold skull").frequency->typical, 0);
  EXPECT_FALSE(prior("jelly skull").frequency);
}

TEST(MaterialPrior, OfAHollowThingHasTheDensityOfAllThatItsWallsEnclose) {
  EXPECT_LT(prior("car").density.high, 400);
  EXPECT_LT(prior("balloon").density.typical, 10);
  EXPECT_LT(prior("basketball").density.typical, 200);
  EXPECT_NE(prior("car").words.find("hollow"), std::string::npos);
  EXPECT_EQ(prior("car").young.typical, prior("steel").young.typical) << "E is that of the wall";
  EXPECT_NEAR(prior("steel can").density.typical / prior("can").density.typical,
              prior("steel").density.typical / prior("aluminium").density.typical, 1e-9);
  EXPECT_EQ(prior("stone ball").density.typical, prior("stone").density.typical) << "another class is solid";
}

TEST(MaterialPrior, SaysOfLongThingsThatTheirSizeIsTheirLength) {
  for (const char* label : {"toothbrush", "pen", "spoon", "phone", "book", "banana", "guitar", "belt"})
    EXPECT_TRUE(prior(label).longest) << label;
  EXPECT_FALSE(prior("mug").longest);
  EXPECT_GT(prior("skis").height->typical, 3 * prior("toothbrush").height->typical);
}

TEST(MaterialPrior, SaysWhereItsNumbersComeFrom) {
  EXPECT_NE(prior("rose").words.find("estimate: "), std::string::npos);
  const std::string palm = prior("palm").words;
  EXPECT_NE(palm.find("E (measured): https://"), std::string::npos) << palm;
  EXPECT_NE(palm.find("MIT"), std::string::npos) << palm;
  EXPECT_NE(prior("steel chair").words.find("named by the label"), std::string::npos);
  EXPECT_NE(prior("leather sofa").words.find("changes none"), std::string::npos);
}

TEST(MaterialPrior, OfEveryObjectIsAMaterialThatCanBeSimulated) {
  const MaterialTable& table = material_table();
  for (const KnownObject& object : table.objects) {
    const auto match = match_label(table, object.name);
    ASSERT_TRUE(match) << object.name;
    EXPECT_EQ(match->object, &object);
    const MaterialPrior p = prior_of(*match);
    validate_material(object.name, p.young.typical, p.poisson.typical, p.density.typical);
    validate_material(object.name, p.law);
    EXPECT_LE(p.young.low, p.young.typical) << object.name;
    EXPECT_LE(p.young.typical, p.young.high) << object.name;
  }
}

TEST(MaterialPrior, LawsFollowTheMaterial) {
  EXPECT_EQ(prior("sandcastle").law.law, Law::kSand);
  EXPECT_EQ(prior("snowman").law.law, Law::kSnow);
  EXPECT_EQ(prior("balloon").law.law, Law::kNeoHookean);
  EXPECT_EQ(prior("shaving foam").law.law, Law::kFoam);
  EXPECT_EQ(prior("rose").law.law, Law::kFixedCorotated);
}

TEST(Softness, RunsMonotonelyFromTheHighEndToTheLow) {
  const Band band = {1e4, 3e5, 1e6};
  EXPECT_EQ(at_softness(band, 0), 1e6);
  EXPECT_EQ(at_softness(band, 0.5), 3e5);
  EXPECT_EQ(at_softness(band, 1), 1e4);
  EXPECT_NEAR(at_softness(band, 0.75), std::sqrt(1e4 * 3e5), 1e-6);
  double last = at_softness(band, 0);
  for (int i = 1; i <= 1000; ++i) {
    const double value = at_softness(band, i / 1000.0);
    EXPECT_LT(value, last);
    last = value;
  }
  for (const double wrong : {-0.1, 1.1, std::nan("")})
    expect_error(Failure::kUsage, {"--softness"}, [&] { at_softness(band, wrong); });
}

}  // namespace pliant

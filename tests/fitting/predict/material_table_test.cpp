// The shipped tables, law by law, and what the parser refuses.

#include "fitting/predict/material_table.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/temporary_folder.h"

namespace pliant {
namespace {

const char kMaterialTitles[] =
    "name,synonyms,class,E_low,E_typical,E_high,nu_low,nu_typical,nu_high,rho_low,rho_typical,rho_high,law,constants,"
    "kind,source_gives,source,licence,reason\n";
const char kObjectTitles[] =
    "name,synonyms,parts,height_low,height_typical,height_high,frequency_low,frequency_typical,frequency_high,"
    "size,bulk_density\n";
const char kMoss[] = "moss,lichen,plant,1e4,6e4,3e5,.1,.2,.35,50,200,500,,,estimate,,,,loose mat\n";
const char kTuft[] = "tuft,mosses,moss:1*,.01,.05,.2,1,3,9,,\n";

MaterialTable parse(const std::string& materials, const std::string& objects = kTuft) {
  return parse_material_table(kMaterialTitles + materials, "m.csv", kObjectTitles + objects, "o.csv");
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const size_t at = text.find(from);
  if (at == std::string::npos) throw std::logic_error("'" + from + "' is not in " + text);
  return text.replace(at, from.size(), to);
}

}  // namespace

TEST(MaterialTable, IsLargeAndSaysWhatEveryRowRestsOn) {
  const MaterialTable& table = material_table();
  EXPECT_GE(table.materials.size(), 150u);
  EXPECT_GE(table.objects.size(), 100u);
  size_t sourced = 0;
  for (const KnownMaterial& m : table.materials) {
    sourced += m.kind != RowKind::kEstimate;
    if (m.kind == RowKind::kEstimate) {
      EXPECT_FALSE(m.reason.empty()) << m.name;
    } else {
      EXPECT_FALSE(m.source.empty()) << m.name;
      const bool open = m.licence.starts_with("CC BY") || m.licence == "MIT" || m.licence == "Apache-2.0" ||
                        m.licence == "BSD-3-Clause";
      EXPECT_TRUE(open && m.licence.find("SA") == std::string::npos) << m.name << ": " << m.licence;
    }
  }
  EXPECT_GE(sourced, 15u);
}

TEST(MaterialTable, BandsAreOrderedPhysicalAndNarrowOnTheWhole) {
  std::vector<double> widths;
  for (const KnownMaterial& m : material_table().materials) {
    for (const Band* band : {&m.young, &m.poisson, &m.density}) {
      EXPECT_LE(band->low, band->typical) << m.name;
      EXPECT_LE(band->typical, band->high) << m.name;
    }
    EXPECT_LT(m.young.low, m.young.high) << m.name;
    EXPECT_GT(m.density.low, 5) << m.name;
    EXPECT_LT(m.density.high, 2e4) << m.name;
    widths.push_back(std::log10(m.young.high / m.young.low));
  }
  std::nth_element(widths.begin(), widths.begin() + widths.size() / 2, widths.end());
  EXPECT_LE(widths[widths.size() / 2], 1.5) << "decades";
}

TEST(MaterialTable, ObjectsAreMadeOfItsMaterials) {
  const MaterialTable& table = material_table();
  for (const KnownObject& object : table.objects) {
    double sum = 0;
    bool moves = false;
    for (const KnownPart& part : object.parts) {
      ASSERT_LT(part.material, table.materials.size());
      sum += part.share;
      moves |= part.moves;
    }
    EXPECT_NEAR(sum, 1, 1e-6) << object.name;
    EXPECT_TRUE(moves) << object.name;
    EXPECT_GT(object.height.low, 0) << object.name;
  }
}

TEST(MaterialTable, FindsMaterialsByAnyNameAndListsNearOnes) {
  const MaterialTable& table = material_table();
  EXPECT_EQ(find_material(table, "Fresh Leaves").name, "leaf");
  EXPECT_EQ(find_material(table, "silicone").name, "silicone rubber");
  expect_error(Failure::kUsage, {"--material", "siliconne", "silicone", "--list"},
               [&] { find_material(table, "siliconne"); });
  expect_error(Failure::kUsage, {"--material"}, [&] { find_material(table, ""); });
}

TEST(MaterialTable, ListsEveryRowSplitByKind) {
  const MaterialTable table = parse(
      std::string(kMoss) + "gel,,gel,1e4,2e4,3e4,.4,.45,.49,900,950,999,neo_hookean,,measured,E,a page,CC BY,made\n");
  const std::string list = material_list(table);
  for (const char* text : {"2 materials (1 measured, 0 handbook, 1 estimate)", "1 objects", "moss [plant]", "gel [gel]",
                           "a page (CC BY)", "neo_hookean", "tuft"})
    EXPECT_NE(list.find(text), std::string::npos) << text << " in\n" << list;
}

TEST(MaterialTable, ReadsLawsWithTheirConstants) {
  const MaterialTable table = parse(replaced(kMoss, ",,,estimate", ",plasticine,yield_stress=300,estimate"));
  EXPECT_EQ(table.materials[0].law.law, Law::kPlasticine);
  EXPECT_EQ(table.materials[0].law.yield_stress, 300);
}

TEST(MaterialTable, ReadsSizesBulkDensitiesAndMarksOfParts) {
  const MaterialTable table = parse(kMoss, std::string(kTuft) + "bar,,moss:1*==,.1,.2,.3,0,0,0,longest,40\n");
  const KnownObject &tuft = table.objects[0], &bar = table.objects[1];
  EXPECT_FALSE(tuft.longest || tuft.parts[0].replaceable || tuft.parts[0].shows);
  EXPECT_EQ(tuft.bulk_density, 0);
  EXPECT_TRUE(bar.longest && bar.parts[0].moves && bar.parts[0].replaceable && bar.parts[0].shows);
  EXPECT_EQ(bar.bulk_density, 40);
}

TEST(MaterialTable, RefusesMalformedMaterials) {
  const std::vector<std::tuple<std::string, std::string, std::vector<std::string>>> cases = {
      {"1e4", "x4", {"m.csv", "line 2", "E_low", "'x4'"}},
      {"1e4", "inf", {"E_low", "'inf'"}},
      {"1e4", "", {"E_low", "''"}},
      {"1e4", "0", {"young", "0.0"}},
      {"6e4", "6e6", {"E_high", "'3e5'"}},
      {"6e4", "6e3", {"E_typical", "'6e3'"}},
      {".35,50", ".5,50", {"poisson", "0.5"}},
      {"50,200", "-5,200", {"density"}},
      {"500,,,", "500,rock,,", {"law", "'rock'", "sand"}},
      {"500,,,", "500,,yield=3,", {"constants", "'yield=3'"}},
      {"500,,,", "500,plasticine,,", {"yield_stress"}},
      {"500,,,", "500,,yield_stress=x,", {"constants", "'x'"}},
      {"estimate", "rumour", {"kind", "'rumour'"}},
      {"estimate,,,,", "measured,E,a page,GPL-3.0,", {"licence", "GPL-3.0"}},
      {"estimate,,,,", "measured,E,a page,,", {"licence", "''"}},
      {"estimate,,,,", "measured,E,,MIT,", {"source"}},
      {"estimate,,,,", "measured,,a page,MIT,", {"source_gives"}},
      {"estimate,,,,", "measured,mass,a page,MIT,", {"source_gives", "'mass'"}},
      {"estimate,,,,", "estimate,,a page,,", {"kind", "estimate with a source"}},
      {"loose mat", "", {"reason", "empty"}},
      {",plant", ",", {"class", "empty"}},
      {"lichen", "Moss", {"'Moss'", "already"}},
      {"moss,", "---,", {"'---'", "no word"}},
      {"lichen", "a,b", {"20 cells"}},
      {"lichen", "\"a\"", {"quote"}},
  };
  for (const auto& [from, to, words] : cases)
    expect_error(Failure::kInput, words, [&] { parse(replaced(kMoss, from, to)); });
}

TEST(MaterialTable, RefusesMalformedObjectsAndTitles) {
  const std::vector<std::tuple<std::string, std::string, std::vector<std::string>>> cases = {
      {"moss:1*", "mos:1*", {"o.csv", "line 2", "parts", "'mos:1*'"}},
      {"moss:1*", "moss:.9*", {"parts", "0.9"}},
      {"moss:1*", "moss:2*", {"parts", "'moss:2*'"}},
      {"moss:1*", "moss:1", {"parts", "*"}},
      {"moss:1*", "moss", {"parts", "'moss'"}},
      {"moss:1*", "", {"parts", "0"}},
      {".01,", "0,", {"height_low"}},
      {".2,1,", ".2,-1,", {"frequency_low"}},
      {"9,,", "9,wide,", {"size", "'wide'", "longest"}},
      {"9,,", "9,,0", {"bulk_density", "positive"}},
      {"9,,", "9,,x", {"bulk_density", "'x'"}},
  };
  for (const auto& [from, to, words] : cases)
    expect_error(Failure::kInput, words, [&] { parse(kMoss, replaced(kTuft, from, to)); });
  expect_error(Failure::kInput, {"m.csv", "line 1"},
               [] { parse_material_table("name,E\n", "m.csv", kObjectTitles, "o.csv"); });
  expect_error(Failure::kInput, {"title 'E_lo'", "E_low"}, [] {
    parse_material_table(replaced(kMaterialTitles, "E_low", "E_lo"), "m.csv", kObjectTitles, "o.csv");
  });
  expect_error(Failure::kInput, {"o.csv", "no rows"}, [] { parse(kMoss, ""); });
}

}  // namespace pliant

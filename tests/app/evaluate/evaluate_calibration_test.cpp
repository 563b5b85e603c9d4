// Tables of stated uncertainties and truths.

#include "app/evaluate/evaluate_calibration.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "gaussians/base/random.h"
#include "tests/app/run_pliant.h"
#include "tests/temporary_folder.h"

using nlohmann::json;

namespace pliant {
namespace {

TEST(EvaluateCalibration, EachQuantityHasItsOwnFactor) {
  const TemporaryFolder folder;
  std::string table = "quantity,estimate,low,high,truth\n";
  for (int i = 0; i < 800; ++i) {
    const bool young = i % 2;
    // Bands of 90 %; those of E are half as wide as they should be.
    const double error = (young ? 2 : 1) * Random(9, i).normal();
    table += fmt::format("{},{},{},{},{}\n", young ? "log10 E" : "damping", 5.0, 5 - 1.6449, 5 + 1.6449, 5 + error);
  }
  CalibrationOptions options;
  options.band = 0.9;
  const json found = evaluate_calibration(folder.file("bands.csv", table), options);
  // Three standard deviations of the order statistics of 200 rows.
  EXPECT_NEAR(found["factors"]["log10 E"].get<double>(), 2, 0.34);
  EXPECT_NEAR(found["factors"]["damping"].get<double>(), 1, 0.17);
  ASSERT_EQ(found["levels"].size(), 6u) << "all and two quantities, 68 % and 90 %";
  for (const json& row : found["levels"]) {
    if (row["quantity"] == "all") continue;
    EXPECT_EQ(row["coverage_as_stated"].get<bool>(), row["quantity"] == "damping") << row.dump();
    EXPECT_EQ(row["rows"], 400);
    EXPECT_EQ(row["rows_second_half"], 200);
    // Three standard deviations, of which either half has its own.
    const double p = row["nominal"];
    EXPECT_NEAR(row["with_factor"].get<double>(), p, 3 * std::sqrt(2 * p * (1 - p) / 200)) << row.dump();
  }
  EXPECT_NE(markdown_of(calibration_tables(found)[0]).find("(off)"), std::string::npos);
}

TEST(EvaluateCalibration, TooFewRowsForALevelAreSaidInsteadOfItsFactor) {
  const TemporaryFolder folder;
  std::string table = "estimate,truth,sigma\n";
  for (int i = 0; i < 16; ++i) table += fmt::format("{},0,1\n", Random(9, i).normal());
  const json found = evaluate_calibration(folder.file("bands.csv", table), {});
  const json &low = found["levels"][0], &high = found["levels"][1];
  EXPECT_NEAR(found["factors"]["all"].get<double>(), low["factor"].get<double>(), 1e-12);
  for (const char* key : {"factor", "with_factor", "with_factor_low", "with_factor_as_stated"})
    EXPECT_TRUE(high[key].is_null()) << key;
  EXPECT_TRUE(high["with_one_factor"].is_number());
  EXPECT_NE(markdown_of(calibration_tables(found)[0]).find("too few rows"), std::string::npos);
}

TEST(EvaluateCalibration, TheMarkOfUtf8IsNoPartOfTheFirstTitle) {
  const TemporaryFolder folder;
  std::string table = "estimate,truth,sigma\r\n";
  for (int i = 0; i < 16; ++i) table += fmt::format("{},0,1\r\n", Random(9, i).normal());
  const json plain = evaluate_calibration(folder.file("plain.csv", table), {});
  EXPECT_EQ(evaluate_calibration(folder.file("marked.csv", "\xEF\xBB\xBF" + table), {}), plain);
}

TEST(EvaluateCalibration, UselessTablesAreRefusedByLineAndColumn) {
  const TemporaryFolder folder;
  const auto refuse = [&](const std::string& text, const std::vector<std::string>& words) {
    const auto file = folder.file("bands.csv", text);
    expect_error(Failure::kInput, words, [&] { evaluate_calibration(file, {}); });
  };
  refuse("estimate,sigma\n1,1\n", {"line 1", "truth"});
  refuse("estimate,truth,sigma,low,high\n1,1,1,0,2\n", {"line 1", "either"});
  refuse("estimate,truth,sigma,low\n1,1,1,0\n", {"line 1", "either"});
  refuse("estimate,truth,high,sigma\n1,1,2,1\n", {"line 1", "either"});
  refuse("estimate,truth,low\n1,1,0\n", {"line 1", "either"});
  refuse("estimate,truth,sigma,colour\n1,1,1,red\n", {"colour"});
  refuse("estimate,truth,sigma\n1,1,0\n", {"line 2", "sigma", "width"});
  refuse("estimate,truth,low,high\n1,1,1.5,2\n", {"line 2", "low"});
  refuse("estimate,truth,sigma\n1,x,1\n", {"line 2", "truth", "x"});
  refuse("estimate,truth,sigma\n1,1,1\n2,2,2\n", {"2 rows", "8"});
  refuse("quantity,estimate,truth,sigma\nE,1,1,1\nall,1,1,1\n", {"line 3", "quantity", "'all'"});
  const std::string file = (folder / "bands.csv").string();
  EXPECT_EQ(run_quietly({"evaluate", "calibration", file, "--band", "2"}), 2);
}

TEST(EvaluateCalibration, TheBandIsThatOfLowAndHigh) {
  const TemporaryFolder folder;
  std::string symmetric = "estimate,truth,sigma\n", sides = "estimate,truth,low,high\n";
  for (int i = 0; i < 16; ++i) {
    const double estimate = Random(9, i).normal();
    symmetric += fmt::format("{},0,1\n", estimate);
    sides += fmt::format("{},0,{},{}\n", estimate, estimate - 1, estimate + 1);
  }
  const auto with_sigma = folder.file("sigma.csv", symmetric), with_sides = folder.file("sides.csv", sides);
  CalibrationOptions options;
  options.band = 0.68;
  EXPECT_EQ(evaluate_calibration(with_sides, {}), evaluate_calibration(with_sides, options));
  expect_error(Failure::kUsage, {"--band", "sigma"}, [&] { evaluate_calibration(with_sigma, options); });
  EXPECT_EQ(run_quietly({"evaluate", "calibration", with_sigma.string(), "--band", "0.68"}), 2);
  EXPECT_EQ(run_quietly({"evaluate", "calibration", with_sides.string(), "--band", "0.9", "--json"}), 0);
}

}  // namespace
}  // namespace pliant

// report.html: times of all stages, and a command that a shell reads as it was typed.

#include "app/commands/report.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <nlohmann/json.hpp>

#include "app/run/options.h"
#include "gaussians/io/files/files.h"
#include "tests/temporary_folder.h"

namespace pliant {

namespace {

using nlohmann::json;

/// The report of a run with these stages.
std::string report_of(const json& stages) {
  const TemporaryFolder folder;
  write_text(folder / "run.json", json({{"scene", {{"source", "x"}}}, {"stages", stages}}).dump());
  write_text(folder / "interactions.json", "[]");
  write_text(folder / "stiffness.png", "a picture");
  write_report(RunDirectory::open(folder.path()), Scene(), "pliant run x");
  return read_text(folder / "report.html");
}

/// What run.json says of stages that are done: the first took 1 s, each next one twice as long.
json finished(const std::vector<std::string>& names) {
  json stages = json::object();
  int seconds = 1;
  for (const std::string& name : names) {
    const json nothing = json::object();
    stages[name] = {{"options", nothing}, {"scene", nothing},    {"found", nothing},
                    {"inputs", nothing},  {"outputs", {"x"}},    {"summary", nothing},
                    {"wall_s", seconds},  {"peak_memory_mb", 1}, {"seed", 1}};
    seconds *= 2;
  }
  stages["simulate"]["summary"]["motion"] = json::object();
  return stages;
}

/// A run whose material was predicted.
json predicted_stages() {
  json stages = finished({"extract", "predict", "fit", "simulate"});
  const json band = {{"low", 0.2}, {"typical", 0.3}, {"high", 0.4}};
  stages["predict"]["summary"] = {
      {"understood", "palm"}, {"source", "a table"}, {"frequency_hz", 2}, {"frequency_band", band}};
  for (const char* name : {"young", "poisson", "density"}) {
    stages["predict"]["summary"][name] = 0.3;
    stages["predict"]["summary"][name + std::string("_band")] = band;
  }
  return stages;
}

}  // namespace

TEST(RunReport, TotalIsTheTimeOfAllStages) {
  const std::string report = report_of(
      finished({"label", "segment", "extract", "repair", "fill", "seed", "fit", "simulate", "render", "page"}));
  EXPECT_NE(report.find("<td>total</td><td>1023.0</td>"), std::string::npos) << report;
}

TEST(RunReport, AGivenEHasNoBandAndARigidThingNoneOfItsSway) {
  json stages = predicted_stages();
  stages["simulate"]["found"]["predicted"] = true;
  const auto says = [&](const char* word) { return report_of(stages).find(word) != std::string::npos; };
  EXPECT_TRUE(says("Predicted mean: 0.3 Pa; band 0.2 to 0.4 Pa."));
  stages["predict"]["summary"]["given"] = {"young"};
  EXPECT_TRUE(says("Mean as given: 0.3 Pa; its distribution is predicted."));
  EXPECT_FALSE(says("Predicted mean"));
  stages["predict"]["summary"]["frequency_band"] = {{"low", 0}, {"typical", 0}, {"high", 0}};
  EXPECT_TRUE(says("sway frequency"));
  EXPECT_FALSE(says("0 to 0"));
}

TEST(RunReport, AnEThatWasFittedIsNotAssumed) {
  json stages = predicted_stages();
  for (const bool fitted : {false, true}) {
    stages["simulate"]["found"]["fitted"] = fitted;
    const std::string report = report_of(stages);
    const auto says = [&](const char* word) { return report.find(word) != std::string::npos; };
    EXPECT_EQ(says("mean of Young's modulus"), !fitted);
    EXPECT_EQ(says("sway frequency"), !fitted);
    for (const char* word : {"Poisson's ratio", "density [kg/m^3]", "palm: a table"}) EXPECT_TRUE(says(word)) << word;
  }
}

TEST(RunReport, WhatAFitOrASimulationHasFromElsewhereIsNotAssumed) {
  json stages = predicted_stages();
  using Said = std::vector<bool>;  // E, nu, rho and the sway
  const auto says = [&] {
    const std::string report = report_of(stages);
    Said said;
    for (const char* word : {"mean of Young's modulus", "Poisson's ratio", "density [kg/m^3]", "sway frequency"})
      said.push_back(report.find(word) != std::string::npos);
    return said;
  };
  json &simulate = stages["simulate"]["found"], &fit = stages["fit"];
  simulate["fitted"] = true;
  fit["found"]["material"] = {{"young", 0.3}, {"poisson", 0.3}, {"density", 0.3}};
  EXPECT_EQ(says(), (Said{false, true, true, false}));
  fit["found"]["material"]["poisson"] = 0.4;
  EXPECT_EQ(says(), (Said{false, false, true, false}));
  fit["inputs"]["initial_material"] = "the hash of a file";
  EXPECT_EQ(says(), (Said{false, false, false, false}));
  simulate["fitted"] = false;
  simulate["material"] = {{"young", 7}, {"poisson", 0.3}, {"density", 0.3}};
  EXPECT_EQ(says(), (Said{false, true, true, false}));
  stages["simulate"]["inputs"]["material"] = "the hash of a file";
  EXPECT_EQ(says(), (Said{false, false, false, false}));
  simulate["predicted"] = "palm";
  EXPECT_EQ(says(), (Said{true, true, true, true}));
}

TEST(QuotedWord, IsReadByAShellAsItIs) {
  const std::vector<std::string> words = {"run a", "potted palm", "it's", "",  "$HOME", "a;b", "*",    "~",
                                          "a\nb",  "\"",          "\\",   "#", "`ls`",  "é",   "--x=1"};
  std::string line = "printf '%s\\0'", expected, read;
  for (const std::string& word : words) {
    line += " " + quoted_word(word);
    expected += word + '\0';
  }
  FILE* shell = popen(line.c_str(), "r");
  ASSERT_TRUE(shell);
  for (int c; (c = std::fgetc(shell)) != EOF;) read += static_cast<char>(c);
  EXPECT_EQ(pclose(shell), 0);
  EXPECT_EQ(read, expected);
  EXPECT_EQ(quoted_word("--video=a_b/c-1.mp4"), "--video=a_b/c-1.mp4");
}

}  // namespace pliant

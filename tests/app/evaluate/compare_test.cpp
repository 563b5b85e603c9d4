// Comparisons of methods from result files with known values.

#include "app/evaluate/compare.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "app/evaluate/metric_table.h"
#include "gaussians/base/random.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/files/json_file.h"
#include "tests/app/run_pliant.h"
#include "tests/temporary_folder.h"

namespace fs = std::filesystem;
using nlohmann::json;

namespace pliant {
namespace {

class Compare : public testing::Test {
 protected:
  void write(const std::string& method, const std::string& result, const json& value) {
    fs::create_directories((folder_ / (method + "/" + result)).parent_path());
    write_json(folder_ / (method + "/" + result + ".json"), value);
  }
  json compare(const std::vector<std::string>& names, const CompareOptions& options = {}) const {
    std::vector<Method> methods;
    for (const std::string& name : names) methods.push_back({name, folder_ / name});
    return compare_methods(methods, options);
  }
  TemporaryFolder folder_;
};

const json& row_of(const json& rows, const std::string& key, const std::string& value, const std::string& metric) {
  for (const json& row : rows)
    if (row[key] == value && row["metric"] == metric) return row;
  ADD_FAILURE() << value << " " << metric;
  return rows[0];
}

TEST_F(Compare, PairedDifferencesDecideWhereMeansOverlap) {
  // Scenes differ by tens of dB, methods by 1 dB.
  for (int i = 0; i < 10; ++i) {
    const double scene = 25 + 4 * Random(3, i).normal();
    const std::string name = "scene" + std::to_string(i);
    write("ours", name, {{"psnr", scene + 1 + 0.2 * Random(4, i).normal()}, {"frequency_error", 0.3}});
    write("weak", name, {{"psnr", scene}, {"frequency_error", 0.1}});
    write("equal", name, {{"psnr", scene + 1 + 0.5 * Random(5, i).normal()}, {"frequency_error", 0.3}});
  }
  const json found = compare({"ours", "weak", "equal"});
  const json &psnr = row_of(found["differences"], "baseline", "weak", "psnr"),
             &frequency = row_of(found["differences"], "baseline", "weak", "frequency_error"),
             &equal = row_of(found["differences"], "baseline", "equal", "frequency_error");
  EXPECT_EQ(psnr["verdict"], "ours");
  EXPECT_EQ(psnr["wins"], 10);
  EXPECT_NEAR(psnr["p_sign"].get<double>(), 2 / 1024.0, 1e-12);
  EXPECT_GT(psnr["low"].get<double>(), 0.7);
  EXPECT_LT(psnr["high"].get<double>(), 1.3);
  // Where the baseline is better it says so: errors are better when they are lower.
  EXPECT_EQ(frequency["verdict"], "weak");
  EXPECT_EQ(frequency["losses"], 10);
  EXPECT_EQ(equal["verdict"], "undecided");
  EXPECT_EQ(equal["ties"], 10);
  EXPECT_TRUE(equal["p_sign"].is_null());
  const json &ours = row_of(found["means"], "method", "ours", "psnr"),
             &weak = row_of(found["means"], "method", "weak", "psnr");
  EXPECT_LT(ours["low"].get<double>(), weak["high"].get<double>()) << "the means alone do not decide";
}

TEST_F(Compare, MissingAndUnknownResultsAreFailuresAndCountAsTheWorst) {
  for (const char* scene : {"a", "b", "c"}) write("ours", scene, {{"frequency_error", 0.1}, {"miou", 0.9}});
  write("theirs", "a", {{"frequency_error", 2.5}, {"miou", 0.8}});
  write("theirs", "b", {{"frequency_error", nullptr}, {"miou", 0.95}});
  write("theirs", "d", {{"frequency_error", 0.05}, {"miou", 0.7}});
  const json found = compare({"ours", "theirs"});
  const json &error = row_of(found["means"], "method", "theirs", "frequency_error"),
             &iou = row_of(found["means"], "method", "theirs", "miou"),
             &ours = row_of(found["means"], "method", "ours", "miou");
  EXPECT_EQ(error["failures"], 2);
  EXPECT_EQ(error["failure_counts_as"], 2.5);
  EXPECT_NEAR(error["mean"].get<double>(), (2.5 + 2.5 + 2.5 + 0.05) / 4, 1e-12);
  EXPECT_EQ(iou["failures"], 1);
  EXPECT_NEAR(iou["mean"].get<double>(), (0.8 + 0.95 + 0 + 0.7) / 4, 1e-12);
  EXPECT_EQ(ours["failures"], 1);
  EXPECT_NEAR(ours["mean"].get<double>(), 2.7 / 4, 1e-12);
}

TEST_F(Compare, AFailureCountsInANestedMetricAsInThatOfTheTable) {
  for (const char* scene : {"a", "b"})
    write("ours", scene,
          {{"unseen", {{"frequency_error", 0.3}}}, {"video", {{"ssim", 0.6}}}, {"own", {{"share", 0.7}}}});
  write("theirs", "a", {{"unseen", {{"frequency_error", 0.2}}}, {"video", {{"ssim", 0.9}}}, {"own", {{"share", 0.2}}}});
  write("theirs", "b", {{"failed", "no motion"}});
  CompareOptions options;
  options.metrics = {"unseen.frequency_error:lower", "video.ssim:higher", "own.share:lower"};
  const json found = compare({"ours", "theirs"}, options);
  // Standing still has a frequency error of 1, no picture an SSIM of 0; of what is not in the table the worst is known.
  const std::vector<std::string> metrics = {"unseen.frequency_error", "video.ssim", "own.share"};
  const std::vector<double> counts_as = {1, 0, 0.7}, means = {0.6, 0.45, 0.45};
  for (size_t k = 0; k < metrics.size(); ++k) {
    const json& row = row_of(found["means"], "method", "theirs", metrics[k]);
    EXPECT_EQ(row["failures"], 1) << metrics[k];
    EXPECT_NEAR(row["failure_counts_as"].get<double>(), counts_as[k], 1e-12) << metrics[k];
    EXPECT_NEAR(row["mean"].get<double>(), means[k], 1e-12) << metrics[k];
  }
  options.metrics = {"unseen.frequency_error:higher"};
  expect_error(Failure::kUsage, {"unseen.frequency_error:higher", "write 'unseen.frequency_error:lower'"}, [&] {
    compare({"ours", "theirs"}, options);
  });
}

TEST_F(Compare, DroppingTheWorstResultsMakesNoMethodBetter) {
  for (int i = 0; i < 6; ++i) {
    write("ours", std::to_string(i), {{"ssim", 0.8}});
    write("theirs", std::to_string(i), {{"ssim", i < 3 ? 0.2 : 0.9}});
  }
  const double honest = row_of(compare({"ours", "theirs"})["means"], "method", "theirs", "ssim")["mean"];
  for (int i = 0; i < 3; ++i) fs::remove(folder_ / ("theirs/" + std::to_string(i) + ".json"));
  EXPECT_LT(row_of(compare({"ours", "theirs"})["means"], "method", "theirs", "ssim")["mean"].get<double>(), honest);
}

TEST_F(Compare, RunsOfASceneAreOneCluster) {
  // 40 runs of 4 scenes say as much as 4 scenes.
  for (int scene = 0; scene < 4; ++scene)
    for (int run = 0; run < 10; ++run) {
      const std::string name = std::to_string(scene) + "/" + std::to_string(run);
      write("ours", name, {{"psnr", 30 + scene}});
      write("theirs", name, {{"psnr", 30}});
    }
  const json runs = compare({"ours", "theirs"});
  const json& row = runs["differences"][0];
  EXPECT_EQ(runs["results"], 40);
  EXPECT_EQ(row["wins"].get<int>() + row["ties"].get<int>(), 4);
  EXPECT_LE(row["low"].get<double>(), 0.01);
  EXPECT_GE(row["high"].get<double>(), 2.9);
}

TEST_F(Compare, ScenesThatChanceWouldOrderAlikeDecideNothing) {
  // Five scenes that differ in one direction do so by chance in one of 16 cases, six in one of 32.
  for (int i = 0; i < 6; ++i) {
    write("ours", std::to_string(i), {{"psnr", 30 + 0.1 * i}});
    write("theirs", std::to_string(i), {{"psnr", 29}});
    const json row = compare({"ours", "theirs"})["differences"][0];
    EXPECT_EQ(row["verdict"], i < 5 ? "undecided" : "ours") << i + 1 << " scenes";
    if (i > 0 && i < 4) {
      EXPECT_LT(row["low"].get<double>(), 1) << "beyond the least of them";
    }
  }
  CompareOptions options;
  options.bootstrap.level = 0.9;
  fs::remove(folder_ / "ours/5.json");
  fs::remove(folder_ / "theirs/5.json");
  EXPECT_EQ(compare({"ours", "theirs"}, options)["differences"][0]["verdict"], "ours");
}

TEST_F(Compare, OneResultOfASceneIsComparedWithTheMeanOverTheRunsOfAnother) {
  write("ours", "a/1", {{"psnr", 30}});
  write("ours", "a/2", {{"psnr", 34}});
  write("ours", "b", {{"psnr", 20}});
  write("theirs", "a", {{"psnr", 31}});
  write("theirs", "b", {{"psnr", 20}});
  const json found = compare({"ours", "theirs"});
  for (const char* method : {"ours", "theirs"})
    EXPECT_EQ(row_of(found["means"], "method", method, "psnr")["failures"], 0) << method;
  const json& row = found["differences"][0];
  EXPECT_NEAR(row["difference"].get<double>(), (32 - 31 + 0) / 2.0, 1e-12);
  EXPECT_EQ(row["wins"], 1);
  EXPECT_EQ(row["ties"], 1);
  // Who has runs lacks those that others have, and who lacks the scene lacks all of them.
  write("few", "a/1", {{"psnr", 30}});
  write("none", "b", {{"psnr", 20}});
  const json lacking = compare({"ours", "few", "none"});
  const json &few = row_of(lacking["means"], "method", "few", "psnr"),
             &none = row_of(lacking["means"], "method", "none", "psnr");
  EXPECT_EQ(few["failures"], 2);
  EXPECT_NEAR(few["mean"].get<double>(), ((30 + 0) / 2.0 + 0) / 2, 1e-12);
  EXPECT_EQ(none["failures"], 2);
  EXPECT_NEAR(none["mean"].get<double>(), (0 + 20) / 2.0, 1e-12);
}

TEST_F(Compare, RunsThatFailAgainstASingleResultOfTheSceneAreFailures) {
  for (int run = 1; run <= 5; ++run)
    write("ours", "a/" + std::to_string(run), {{"psnr", run <= 2 ? json(30) : json()}});
  write("theirs", "a", {{"psnr", 25}});
  write("few", "a/1", {{"psnr", 30}});
  write("failed", "a/1", {{"psnr", nullptr}});
  // 2 of 5 runs, the single result, 1 of 5 runs, none of 5; a failure counts as 0 dB.
  const std::vector<std::string> names = {"ours", "theirs", "few", "failed"};
  const std::vector<double> means = {12, 25, 6, 0};
  const std::vector<int> failures = {3, 0, 4, 5}, results = {5, 1, 5, 5};
  const json found = compare(names);
  for (size_t m = 0; m < names.size(); ++m) {
    const json& row = row_of(found["means"], "method", names[m], "psnr");
    EXPECT_NEAR(row["mean"].get<double>(), means[m], 1e-12) << names[m];
    EXPECT_EQ(row["failures"], failures[m]) << names[m];
    EXPECT_EQ(row["results"], results[m]) << names[m];
  }
  // The same where no run has a result.
  for (const char* run : {"a/1", "a/2"}) write("ours", run, {{"psnr", nullptr}});
  CompareOptions options;
  options.metrics = {"psnr"};
  const json none = compare({"ours", "theirs"}, options);
  EXPECT_EQ(row_of(none["means"], "method", "ours", "psnr")["failures"], 5);
  EXPECT_EQ(none["differences"][0]["losses"], 1);
}

TEST_F(Compare, ScenesCountAlikeHoweverManyRunsTheyHave) {
  for (int run = 0; run < 9; ++run) {
    write("ours", "many/" + std::to_string(run), {{"psnr", 30}});
    write("theirs", "many/" + std::to_string(run), {{"psnr", 20}});
  }
  write("ours", "one", {{"psnr", 10}});
  write("theirs", "one", {{"psnr", 30}});
  const json found = compare({"ours", "theirs"});
  EXPECT_NEAR(row_of(found["means"], "method", "ours", "psnr")["mean"].get<double>(), 20, 1e-12);
  EXPECT_NEAR(found["differences"][0]["difference"].get<double>(), -5, 1e-12);
}

TEST_F(Compare, ResultsThatNoMethodKnowsDoNotCount) {
  write("ours", "a", {{"damping_error", 0.2}});
  write("ours", "b", {{"damping_error", nullptr}});
  write("theirs", "a", {{"damping_error", 0.4}});
  write("theirs", "b", {{"damping_error", nullptr}});
  const json found = compare({"ours", "theirs"});
  EXPECT_EQ(found["means"][0]["results"], 1);
  EXPECT_EQ(found["means"][0]["failures"], 0);
  EXPECT_TRUE(found["means"][0]["low"].is_null()) << "one scene has no spread";
}

TEST_F(Compare, TheCommandWritesJsonCsvAndMarkdown) {
  for (const char* scene : {"a", "b", "c", "d", "e", "f"}) {
    write("p", scene, {{"psnr", 30}, {"outside", {{"psnr", 50}}}, {"seconds", 3}});
    write("q", scene, {{"psnr", nullptr}, {"identical", true}, {"outside", {{"psnr", 60}}}, {"seconds", 9}});
  }
  const std::string ours = "ours=" + (folder_ / "p").string(), theirs = "with, comma=" + (folder_ / "q").string(),
                    out = (folder_ / "out").string();
  testing::internal::CaptureStdout();
  ASSERT_EQ(run_quietly({"evaluate", "compare", ours, theirs, "--metric", "psnr", "--metric", "outside.psnr",
                         "--metric", "seconds:lower", "--out", out}),
            0);
  EXPECT_NE(testing::internal::GetCapturedStdout().find("| PSNR [dB] ↑ | 30 [30, 30] | 100 [100, 100] |"),
            std::string::npos);
  const json result = read_json(folder_ / "out/compare.json");
  EXPECT_EQ(row_of(result["differences"], "baseline", "with, comma", "seconds")["verdict"], "ours");
  EXPECT_EQ(row_of(result["means"], "method", "with, comma", "psnr")["mean"], kPsnrOfIdentical);
  const std::string csv = read_text(folder_ / "out/compare_means.csv");
  EXPECT_EQ(csv.substr(0, csv.find("\r\n")), "failure_counts_as,failures,high,low,mean,method,metric,results");
  EXPECT_NE(csv.find("0.0,0,60.0,60.0,60.0,\"with, comma\",outside.psnr,6\r\n"), std::string::npos) << csv;
  EXPECT_TRUE(fs::exists(folder_ / "out/compare_differences.csv"));
  EXPECT_NE(read_text(folder_ / "out/compare.md").find("ours minus each other method"), std::string::npos);
}

TEST_F(Compare, ItsOptionsMayStandBeforeTheMethods) {
  std::vector<std::string> words = {"evaluate", "compare", "--out", (folder_ / "out").string(), "--metric", "psnr"};
  for (const char* method : {"a", "b", "c"}) {
    write(method, "scene", {{"psnr", 30}, {"ssim", 0.9}});
    words.push_back(method + ("=" + (folder_ / method).string()));
  }
  ASSERT_EQ(run_quietly(words), 0);
  const json means = read_json(folder_ / "out/compare.json")["means"];
  ASSERT_EQ(means.size(), 3u);
  for (const json& row : means) EXPECT_EQ(row["metric"], "psnr");
}

TEST_F(Compare, UselessInputIsRefused) {
  write("ours", "a", {{"psnr", 30}});
  write("list", "a", json::array());
  fs::create_directories(folder_ / "empty");
  CompareOptions options;
  options.metrics = {"pnsr"};
  expect_error(Failure::kUsage, {"--metric", "pnsr", "'psnr'"}, [&] { compare({"ours", "ours"}, options); });
  options.metrics = {"ssim"};
  expect_error(Failure::kInput, {"ssim"}, [&] { compare({"ours", "ours"}, options); });
  expect_error(Failure::kInput, {"none", "is not a folder"}, [&] { compare({"ours", "none"}); });
  expect_error(Failure::kInput, {"empty", "no JSON file"}, [&] { compare({"empty", "ours"}); });
  expect_error(Failure::kInput, {"empty", "no JSON file"}, [&] { compare({"ours", "empty"}); });
  write("other", "b", {{"psnr", 30}});
  expect_error(Failure::kInput, {"other", "b", "no scene of 'ours'"}, [&] { compare({"ours", "other"}); });
  options.metrics = {"psnr:lower"};
  expect_error(Failure::kUsage, {"--metric", "psnr:lower", "higher"}, [&] { compare({"ours", "ours"}, options); });
  options.metrics = {"frequency_error:higher"};
  expect_error(Failure::kUsage, {"frequency_error:higher", "lower"}, [&] { compare({"ours", "ours"}, options); });
  options.metrics = {"psnr:higher"};
  EXPECT_EQ(compare({"ours", "ours"}, options)["means"][0]["metric"], "psnr");
  options.metrics = {"psnr", "seconds:lower", "psnr:higher"};
  expect_error(Failure::kUsage, {"--metric", "'psnr' twice"}, [&] { compare({"ours", "ours"}, options); });
  options.metrics = {"seconds:lower", "seconds:higher"};
  expect_error(Failure::kUsage, {"--metric", "'seconds' twice"}, [&] { compare({"ours", "ours"}, options); });
  expect_error(Failure::kInput, {"a.json", "not a JSON object"}, [&] { compare({"ours", "list"}); });
  const std::string ours = (folder_ / "ours").string();
  EXPECT_EQ(run_quietly({"evaluate", "compare", "x=" + ours, ours}), 2);
  EXPECT_EQ(run_quietly({"evaluate", "compare", "x=" + ours, "x=" + ours}), 2);
}

}  // namespace
}  // namespace pliant

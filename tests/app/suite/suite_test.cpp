// The suite's workflow, run by Snakemake with a stand-in for pliant that writes what the commands would.

#include "app/suite/suite.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>

#include "app/evaluate/metric_table.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/files/json_file.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Notes its calls in `calls` beside itself.  `--field wrong` fails as a method does, and `--field killed` as a killed
/// program does after a second, once.  `simulate` needs the scene where `segment` has found it, which takes a scene
/// elsewhere only where it had finished; `evaluate material` fails where there is a file `no truth` beside the program.
constexpr char kStandIn[] = R"(#!/usr/bin/env python3
import json, os, sys, time
words = sys.argv[1:]
here = os.path.dirname(os.path.abspath(__file__))
open(here + "/calls", "a").write(" ".join(words) + "\n")
out = words[words.index("--out") + 1] if "--out" in words else None
def write(file, value):
    os.makedirs(os.path.dirname(file) or ".", exist_ok=True)
    open(file, "w").write(value if isinstance(value, str) else json.dumps(value))
def note(run, key, value):
    file = run + "/run.json"
    write(file, (json.load(open(file)) if os.path.exists(file) else {}) | {key: value})
if "wrong" in words:
    sys.exit(print("fit: no motion in the video") or 1)
if "killed" in words and not os.path.exists(here + "/killed"):
    open(here + "/killed", "w")
    if words[0] == "segment":
        note(out, "scene", {"source": os.path.abspath(words[1])})
    time.sleep(1)
    sys.exit(137)
match words[:2]:
    case ["demo", _]:
        write(out + "/scene.json", {"video": {"file": "videos/poke.mp4", "camera": "view_3"}})
        for name in ("poke", "pull", "wind", "jolt"):
            write(f"{out}/truth/{name}/trajectory.h5", "")
            write(f"{out}/truth/{name}/interactions.json", [{"type": "pin"}, {"type": "impulse", "start": 0.125}])
    case ["segment", scene]:
        if os.path.exists(out + "/run.json") and not os.path.exists(out + "/labels"):
            if json.load(open(out + "/run.json"))["scene"]["source"] != os.path.abspath(scene):
                sys.exit(print("belongs to another scene") or 2)
        write(out + "/labels", "")
        note(out, "scene", {"source": os.path.abspath(scene)})
    case ["extract", run]: write(run + "/objects/1_rose/object.ply", "")
    case ["repair", run]: note(run, "stages", {"repair": {"wall_s": 1234.25}})
    case ["simulate", run]:
        scene = json.load(open(run + "/run.json"))["scene"]["source"]
        if not os.path.exists(scene):
            sys.exit(print(scene + " does not exist") or 1)
        write(run + "/objects/1_rose/trajectory.h5", "")
    case ["evaluate", "trajectory"]:
        motion = words[3].split("/")[-2]
        error = {"poke": 0.125, "pull": 0.25, "wind": 0.5, "jolt": 0.375}[motion]
        write(out, {"relative_error": error, "frequency_error": None if motion in ("wind", "jolt") else error})
    case ["evaluate", "material"]:
        if os.path.exists(here + "/no truth"):
            sys.exit(print("material.h5 does not exist") or 1)
        write(out, {"log10_young_error": 0.5})
    case ["evaluate", "segmentation"]: write(out, {"miou": 0.75, "boundary_miou": 0.625})
    case ["evaluate", "repair"]: write(out, {"psnr": 30.0, "psnr_opencv": 20.0})
    case ["evaluate", "compare"]:
        text = "a table\n"
        methods = [word for word in words[2:] if "=" in word]
        if len(methods) < 2:
            sys.exit(print("METHODS: At least 2 required") or 2)
        if "--metric" not in words:
            sys.exit(print("has no metric of evaluate") or 1)
        for method in methods:
            name, folder = method.split("=")
            files = [f"{at}/{file}" for at, _, names in os.walk(folder) for file in names]
            text += f"{name}: mIoU {[json.load(open(file)).get('miou') for file in sorted(files)]}\n"
        write(out + "/compare.md", text)
    case ["--version"] | ["--version", _]: print("9.9")
)";

struct Suite : testing::Test {
  TemporaryFolder folder;
  Progress progress{true};
  Context context{progress, [] { return false; }};
  SuiteStage stage;
  json settings;

  void SetUp() override {
    if (std::system("command -v snakemake > /dev/null") != 0) GTEST_SKIP() << "Snakemake is not installed";
    const fs::path program = folder.file("pliant", kStandIn);
    fs::permissions(program, fs::perms::owner_all);
    stage.workers = 2;
    settings = suite_settings(stage, program, {"rose"});
    settings["methods"] = {{"motion", {{"ours", {{"commands", {{"fit"}}}, {"simulate", json::array()}}}}},
                           {"repair", {{"ours", json::object()}, {"opencv", json::object()}}}};
  }
  json run() { return run_suite(context, settings, stage, folder / "suite"); }
  json score(const std::string& file) { return read_json(folder / "suite/scores" / file); }
  /// That were noted since the last time.
  std::vector<std::string> calls() {
    std::vector<std::string> lines;
    if (fs::exists(folder / "calls")) {
      std::istringstream text(read_text(folder / "calls"));
      for (std::string line; std::getline(text, line);) lines.push_back(line);
    }
    fs::remove(folder / "calls");
    return lines;
  }
};

bool any_of_them(const std::vector<std::string>& calls, const std::string& begin) {
  return std::any_of(calls.begin(), calls.end(), [&](const std::string& call) { return call.starts_with(begin); });
}

TEST_F(Suite, EveryMethodIsScoredAndOneThatFailsKeepsItsRow) {
  settings["methods"]["motion"]["theirs"] = {{"commands", {{"fit", "--field", "wrong"}}}, {"simulate", json::array()}};
  const json result = run();
  ASSERT_EQ(result["failed"].size(), 1u);
  EXPECT_EQ(result["failed"][0]["method"], "theirs");
  const json ours = score("motion/ours/rose/1.json"), theirs = score("motion/theirs/rose/1.json");
  EXPECT_EQ(ours["video"]["relative_error"], 0.125);
  EXPECT_EQ(ours["unseen"]["relative_error"], 0.375);
  EXPECT_EQ(ours["unseen"]["frequency_error"], 0.25);  // where it is known
  EXPECT_EQ(ours["log10_young_error"], 0.5);
  EXPECT_EQ(theirs["failed"], "fit: no motion in the video");
  EXPECT_FALSE(theirs.contains("unseen"));
  EXPECT_EQ(score("repair/opencv/rose/1.json")["psnr"], 20.0);
  EXPECT_EQ(score("repair/ours/rose/1.json")["seconds"], 1234.25);  // of the stage, not of its evaluation
  EXPECT_TRUE(score("repair/opencv/rose/1.json")["seconds"].is_null());
  const std::string results = read_text(folder / "suite/RESULTS.md");
  for (const char* word : {"Pliant 9.9", "1 scenes", "a table", "| ours |  | 0 of 1 | 1234 |",
                           "| opencv |  | 0 of 1 | – |", "| theirs |  | 1 of 1 | "})
    EXPECT_NE(results.find(word), std::string::npos) << word;
}

TEST_F(Suite, FromTheVideoOfAJoltTheOtherMotionsAreUnseenAndKindsWithoutItAreLeftOut) {
  settings["methods"] = {{"jolt",
                          {{"ours", {{"commands", {{"fit", "--field", "smooth"}}}, {"simulate", json::array()}}},
                           {"given", {{"commands", json::array()}, {"simulate", {"--damping-time", 1}}}}}}};
  settings["scenes"]["flower/1"] = {{"kind", "flower"}, {"seed", 1}};
  settings["lacking"] = {{"jolt", {"flower"}}};
  EXPECT_TRUE(run()["failed"].empty());
  for (const char* method : {"ours", "given"}) {
    const json found = score(std::string("jolt/") + method + "/rose/1.json");
    EXPECT_EQ(found["task"], "jolt");
    EXPECT_EQ(found["video"]["relative_error"], 0.375) << method;
    EXPECT_NEAR(found["unseen"]["relative_error"].get<double>(), (0.125 + 0.25 + 0.5) / 3, 1e-12) << method;
  }
  EXPECT_FALSE(fs::exists(folder / "suite/scores/jolt/ours/flower"));
  const std::vector<std::string> made = calls();
  EXPECT_TRUE(std::any_of(made.begin(), made.end(), [](const std::string& call) {
    return call.starts_with("fit runs/rose/1/jolt-ours") &&
           call.find("--field smooth --video scenes/rose/1/videos/jolt.mp4 --video-camera view_3 --start 0.125") !=
               std::string::npos;
  })) << json(made).dump(1);
  const std::string results = read_text(folder / "suite/RESULTS.md");
  for (const char* word : {"## Motion, from the video of a jolt", "| ours |  | 0 of 1 | "})
    EXPECT_NE(results.find(word), std::string::npos) << results;
}

TEST_F(Suite, AKilledSuiteContinuesAndChangedSettingsRepeatOnlyWhatDependsOnThem) {
  settings["methods"] = {
      {"segmentation", {{"ours", {{"segment", {"--masks", "killed"}}}}, {"vote", {{"segment", {"--iterations", 0}}}}}}};
  EXPECT_THROW(run(), Error);
  EXPECT_FALSE(fs::exists(folder / "suite/scores/segmentation/ours/rose/1.json"));
  EXPECT_TRUE(any_of_them(calls(), "demo"));

  run();
  const std::vector<std::string> second = calls();
  EXPECT_FALSE(any_of_them(second, "demo"));
  EXPECT_FALSE(any_of_them(second, "segment scenes/rose/1 --out runs/rose/1/segmentation-vote"));
  EXPECT_TRUE(any_of_them(second, "segment scenes/rose/1 --out runs/rose/1/segmentation-ours"));
  EXPECT_EQ(score("segmentation/ours/rose/1.json")["miou"], 0.75);
  EXPECT_GT(score("segmentation/ours/rose/1.json")["seconds"].get<double>(), 1) << "of both attempts";

  settings["methods"]["segmentation"]["vote"]["segment"] = {"--no-vote"};
  run();
  const std::vector<std::string> third = calls();
  EXPECT_FALSE(any_of_them(third, "demo"));
  EXPECT_FALSE(any_of_them(third, "segment scenes/rose/1 --out runs/rose/1/segmentation-ours"));
  EXPECT_TRUE(any_of_them(third, "segment scenes/rose/1 --out runs/rose/1/segmentation-vote"));
}

TEST_F(Suite, WhatWasKilledBeforeItNotedItsTimeIsNotMeasured) {
  settings["methods"] = {{"segmentation", {{"ours", {{"segment", json::array()}}}}}};
  run();
  EXPECT_GT(score("segmentation/ours/rose/1.json")["seconds"], 0);
  // As a power failure leaves it.
  for (const char* file : {"RESULTS.md", "scores/segmentation/ours/rose/1.json"}) fs::remove(folder / "suite" / file);
  for (const auto& entry : fs::directory_iterator(folder / "suite/runs/rose/1"))
    if (entry.path().extension() == ".seconds") fs::remove(entry.path());
  run();
  EXPECT_TRUE(score("segmentation/ours/rose/1.json")["seconds"].is_null());
  EXPECT_NE(read_text(folder / "suite/RESULTS.md").find("| ours |  | 0 of 1 | – |"), std::string::npos);
}

TEST_F(Suite, AFolderThatWasMovedContinuesWithoutFailures) {
  const json motion = settings["methods"]["motion"];
  settings["methods"].erase("motion");
  run();
  calls();
  fs::rename(folder / "suite", folder / "moved");
  settings["methods"]["motion"] = motion;
  EXPECT_TRUE(run_suite(context, settings, stage, folder / "moved")["failed"].empty());
  EXPECT_EQ(read_json(folder / "moved/scores/motion/ours/rose/1.json")["log10_young_error"], 0.5);
  const std::vector<std::string> after = calls();
  EXPECT_TRUE(any_of_them(after, "segment scenes/rose/1 --out runs/rose/1/motion-ours"));
  for (const char* begin : {"demo", "segment scenes/rose/1 --out prepared", "extract", "seed", "evaluate repair"})
    EXPECT_FALSE(any_of_them(after, begin)) << begin;
}

TEST_F(Suite, AJobThatWasKilledBeforeTheFolderWasMovedBeginsAnew) {
  settings["methods"] = {{"segmentation", {{"ours", {{"segment", {"--masks", "killed"}}}}}}};
  EXPECT_THROW(run(), Error);
  fs::rename(folder / "suite", folder / "moved");
  EXPECT_TRUE(run_suite(context, settings, stage, folder / "moved")["failed"].empty());
  EXPECT_EQ(read_json(folder / "moved/scores/segmentation/ours/rose/1.json")["miou"], 0.75);
}

TEST_F(Suite, WhatFailsBesidesTheMethodIsNoFailureOfIt) {
  settings["methods"].erase("repair");
  folder.file("no truth", "");
  EXPECT_THROW(run(), Error);
  EXPECT_FALSE(fs::exists(folder / "suite/scores/motion/ours/rose/1.json"));
  fs::remove(folder / "no truth");
  EXPECT_TRUE(run()["failed"].empty());
  EXPECT_EQ(score("motion/ours/rose/1.json")["log10_young_error"], 0.5);
}

TEST_F(Suite, AnotherVersionDoesAllAgain) {
  settings["methods"] = {{"segmentation", {{"ours", {{"segment", json::array()}}}}}};
  run();
  calls();
  settings["version"] = "10.0";
  run();
  const std::vector<std::string> again = calls();
  for (const char* begin : {"demo", "segment", "evaluate segmentation"})
    EXPECT_TRUE(any_of_them(again, begin)) << begin;
}

TEST_F(Suite, ScoresOfEarlierSettingsDoNotCount) {
  settings["methods"] = {
      {"segmentation", {{"ours", {{"segment", json::array()}}}, {"vote", {{"segment", {"--no-vote"}}}}}}};
  // Of a second seed, and of a method that failed.
  write_text(folder / "suite/scores/segmentation/ours/rose/2.json", R"({"miou": 0.25})");
  write_text(folder / "suite/scores/segmentation/theirs/rose/1.json",
             R"({"scene": "rose/1", "method": "theirs", "failed": "no masks"})");
  EXPECT_TRUE(run()["failed"].empty());
  const std::string results = read_text(folder / "suite/RESULTS.md");
  EXPECT_NE(results.find("ours: mIoU [0.75]"), std::string::npos) << results;
}

TEST_F(Suite, OneMethodAloneAndMethodsThatAllFailedAreListedWithoutAComparison) {
  const json failing = {{"segment", {"--masks", "wrong"}}};
  settings["methods"] = {{"motion", settings["methods"]["motion"]},
                         {"segmentation", {{"ours", failing}, {"vote", failing}}}};
  write_text(folder / "suite/tables/motion/compare.md", "of earlier settings\n");
  EXPECT_EQ(run()["failed"].size(), 2u);
  EXPECT_FALSE(any_of_them(calls(), "evaluate compare"));
  EXPECT_FALSE(fs::exists(folder / "suite/tables/motion/compare.md"));
  const std::string results = read_text(folder / "suite/RESULTS.md");
  const size_t second = results.find("## Segmentation");
  ASSERT_NE(second, std::string::npos) << results;
  EXPECT_NE(results.substr(0, second).find("| ours |  | 0 of 1 | "), std::string::npos) << results;
  EXPECT_NE(results.substr(0, second).find("`scores/motion`"), std::string::npos) << results;
  for (const char* row : {"| ours |  | 1 of 1 | ", "| vote |  | 1 of 1 | ", "No method has a result"})
    EXPECT_NE(results.find(row, second), std::string::npos) << row;
}

TEST_F(Suite, JobsAreSubmittedWhereAClusterIsGiven) {
  settings["methods"] = json::object();  // so that the results alone are a job
  const std::string submit =
      "echo submitted >> " + (folder / "submitted").string() + "; sh \"$@\" > /dev/null 2>&1; echo job 1";
  stage.cluster = "sh " + folder.file("submit", submit).string();
  run();
  EXPECT_EQ(read_text(folder / "submitted"), "submitted\n");
  EXPECT_TRUE(fs::exists(folder / "suite/RESULTS.md"));
}

// The stand-in compares nothing: that `evaluate compare` takes what the jobs name, and what a failure counts as.
TEST(SuiteWorkflow, ItsMetricsAreThoseOfCompareAndAFailureIsNoBetterThanStandingStill) {
  const std::string text(suite_workflow());
  const size_t begin = text.find("OF_MOTION = "), end = text.find("TITLES = ");
  ASSERT_LT(begin, end);
  ASSERT_NE(end, std::string::npos);
  const std::string named = text.substr(begin, end - begin);
  const std::regex metric(R"re("([a-z0-9_.]+(?::(?:lower|higher))?)"(?!:))re");
  std::map<std::string, double> failure;
  for (std::sregex_iterator it(named.begin(), named.end(), metric), none; it != none; ++it) {
    const Metric found = metric_named((*it)[1], "--metric");
    failure[found.key] = found.failure;
  }
  EXPECT_EQ(failure, (std::map<std::string, double>{{"unseen.relative_error", 1},
                                                    {"unseen.frequency_error", 1},
                                                    {"video.relative_error", 1},
                                                    {"log10_young_error", 0},
                                                    {"miou", 0},
                                                    {"boundary_miou", 0},
                                                    {"psnr", 0}}));
}

TEST(SuiteSettings, ScenesAreKindsTimesSeedsAndUnknownKindsAreRefused) {
  SuiteStage stage;
  stage.seeds = 2;
  const json settings = suite_settings(stage, "pliant", {"rose", "cord"});
  EXPECT_EQ(settings["scenes"].size(), 4u);
  EXPECT_EQ(settings["scenes"]["cord/2"], json({{"kind", "cord"}, {"seed", 2}}));
  EXPECT_TRUE(settings["methods"]["jolt"].contains("physdreamer"));
  EXPECT_EQ(settings["lacking"]["jolt"], json({"potted-flower"}));
  stage.quick = true;
  EXPECT_FALSE(suite_settings(stage, "pliant", {"rose", "cord"})["methods"].contains("jolt"));
  stage.kinds = {"rosy"};
  expect_error(Failure::kUsage, {"--kind", "rosy", "rose"}, [&] { suite_settings(stage, "pliant", {"rose", "cord"}); });
}

TEST(SuiteSettings, OnesOwnAreReadWholeAndContradictedByNothing) {
  const TemporaryFolder folder;
  SuiteStage stage;
  const json usual = suite_settings(stage, "pliant", {"rose"});
  stage.settings = folder.file("suite.json", usual.dump());
  EXPECT_EQ(suite_settings(stage, "other", {"cord"})["scenes"], usual["scenes"]);
  EXPECT_EQ(suite_settings(stage, "other", {"cord"})["pliant"], "other");
  EXPECT_EQ(suite_settings(stage, "other", {"cord"})["version"], PLIANT_VERSION);
  stage.quick = true;
  expect_error(Failure::kUsage, {"--quick", "--settings"}, [&] { suite_settings(stage, "pliant", {"rose"}); });
  stage.quick = false;
  stage.settings = folder.file("partial.json", "{\"scenes\": {}}");
  expect_error(Failure::kInput, {"partial.json", "methods"}, [&] { suite_settings(stage, "pliant", {"rose"}); });
}

}  // namespace
}  // namespace pliant

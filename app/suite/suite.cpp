#include "app/suite/suite.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <thread>

#include "app/demo/kinds/kinds.h"
#include "fitting/observe/child_process.h"
#include "gaussians/base/error.h"
#include "gaussians/io/files/file_lock.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/files/json_file.h"

namespace fs = std::filesystem;
using nlohmann::json;

namespace pliant {
namespace {

/// A method of motion: commands after the preparation, and options of the simulations that are judged.
json motion_method(json commands, const std::string& what, json simulate = json::array()) {
  return {{"commands", std::move(commands)}, {"simulate", std::move(simulate)}, {"what", what}};
}

/// Every motion method begins with the E of scene.json, which is wrong on purpose.
json motion_methods() {
  return {{"ours", motion_method({{"fit"}}, "search over one E, then Gauss-Newton")},
          {"given",
           motion_method(json::array(), "E as given, without a video, as PhysGaussian (Xie et al. 2024) takes it")}};
}

/// From the video of a jolt, the situation that PhysDreamer is made for: a body at rest that moves of itself.  The
/// recipe has no damping; it is simulated with that of `given`.
json jolt_methods() {
  const json damped = {"--damping-time", 1};
  json methods = motion_methods();
  methods["physdreamer"] = motion_method({{"fit", "--recipe", "physdreamer"}},
                                         "PhysDreamer (Zhang et al. 2024), re-created: v0(x), then E(x)", damped);
  methods["physdreamer-code"] = motion_method({{"fit", "--recipe", "physdreamer-code"}},
                                              "the same as its released programs do it, re-created", damped);
  return methods;
}

/// Joint training takes minutes a scene.
json segmentation_methods(bool quick) {
  const auto method = [](json options, const std::string& what) {
    return json{{"segment", std::move(options)}, {"what", what}};
  };
  json methods = {
      {"ours", method(json::array(), "vote, then the semantic attribute")},
      {"vote", method({"--iterations", 0}, "the vote alone")},
      {"ours-associated", method({"--associate", "always"}, "IDs of the masks ignored, matched by overlap")},
      {"gaga", method({"--associate", "gaga"}, "the same matched by the rule of Gaga (Lyu et al. 2024), re-created")}};
  if (!quick)
    methods["gaussian-grouping"] =
        method({"--joint"}, "Gaussian Grouping (Ye et al. 2024), re-created: joint training");
  return methods;
}

json repair_methods() {
  return {{"ours", {{"what", "one background for all views"}}},
          {"opencv", {{"what", "the best of OpenCV's inpaintings, each view by itself"}}}};
}

/// Files of the scores that a suite brings.
std::vector<fs::path> expected_scores(const fs::path& folder, const json& settings) {
  std::vector<fs::path> scores;
  const json lacking = settings.value("lacking", json::object());
  for (const auto& [task, methods] : settings["methods"].items())
    for (const auto& [method, what] : methods.items())
      for (const auto& [scene, demo] : settings["scenes"].items()) {
        const json without = lacking.value(task, json::array());
        if (std::find(without.begin(), without.end(), demo["kind"]) != without.end()) continue;
        scores.push_back(folder / "scores" / task / method / (scene + ".json"));
      }
  return scores;
}

/// Those that are there; those of earlier settings do not count.
std::vector<fs::path> scores_in(const fs::path& folder, const json& settings) {
  std::vector<fs::path> scores = expected_scores(folder, settings);
  std::erase_if(scores, [](const fs::path& score) { return !fs::exists(score); });
  return scores;
}

}  // namespace

OptionTable options_of(SuiteStage& stage) {
  return {"suite",
          {{.name = "kind",
            .field = &stage.kinds,
            .help = "Kind of demo scene (default: all; with --quick the first three); repeatable"},
           {.name = "seeds", .field = &stage.seeds, .help = "Scenes of each kind", .low = 1, .high = 1000},
           {.name = "quick",
            .field = &stage.quick,
            .help = "Small scenes, and only the methods that take less than a minute each"},
           {.name = "workers",
            .field = &stage.workers,
            .help = "Jobs at a time, of one thread each; 0 = one for each core",
            .low = 0,
            .high = 10000},
           {.name = "cluster",
            .field = &stage.cluster,
            .help = "Command that submits the script of a job, such as 'sbatch' (default: jobs run here)",
            .value = "CMD"},
           {.name = "settings",
            .field = &stage.settings,
            .help = "A suite.json of your own, with further methods or scenes",
            .value = "FILE",
            .exists = true}}};
}

json suite_settings(const SuiteStage& stage, const std::string& pliant, const std::vector<std::string>& kinds) {
  if (!stage.settings.empty()) {
    if (stage.quick || stage.seeds != SuiteStage().seeds || !stage.kinds.empty())
      throw usage_error("evaluate suite",
                        stage.quick           ? "--quick"
                        : stage.kinds.empty() ? "--seeds"
                                              : "--kind",
                        "does nothing with --settings, which says what is run", "leave it out");
    json settings = read_json(stage.settings);
    for (const char* key : {"scenes", "methods", "demo", "particles", "simulate"})
      if (!settings.is_object() || !settings.contains(key))
        throw input_error(stage.settings, key, "is missing", "begin with the suite.json of another suite");
    settings["pliant"] = pliant;
    settings["version"] = PLIANT_VERSION;
    settings["threads"] = 1;
    return settings;
  }
  std::vector<std::string> chosen = stage.kinds;
  if (chosen.empty()) {
    chosen = kinds;
    if (stage.quick) chosen.resize(std::min<size_t>(chosen.size(), 3));
  }
  for (const std::string& kind : chosen)
    if (std::find(kinds.begin(), kinds.end(), kind) == kinds.end())
      throw usage_error("evaluate suite", "--kind", "'" + kind + "' is not a kind of demo scene",
                        "did you mean '" + nearest_name(kind, kinds) + "'?");
  json settings = {{"pliant", pliant}, {"version", PLIANT_VERSION}, {"threads", 1}, {"scenes", json::object()}};
  for (const std::string& kind : chosen)
    for (int seed = 1; seed <= stage.seeds; ++seed)
      settings["scenes"][fmt::format("{}/{}", kind, seed)] = {{"kind", kind}, {"seed", seed}};
  settings["demo"] =
      stage.quick ? json{"--photos", 12, "--gaussians", 12000, "--training", 100, "--width", 240, "--height", 180}
                  : json{"--photos", 24, "--gaussians", 40000, "--training", 300};
  settings["particles"] = stage.quick ? 1000 : 2000;
  settings["simulate"] = {"--duration", 2, "--fps", 24};
  settings["methods"] = {
      {"motion", motion_methods()}, {"segmentation", segmentation_methods(stage.quick)}, {"repair", repair_methods()}};
  if (!stage.quick) {  // these take minutes a scene
    settings["methods"]["motion"]["ours-smooth"] =
        motion_method({{"fit", "--field", "smooth"}}, "then a smooth field E(x)");
    settings["methods"]["jolt"] = jolt_methods();
    settings["lacking"] = {{"jolt", json::array({kPottedFlower})}};
  }
  return settings;
}

json run_suite(const Context& context, const json& settings, const SuiteStage& stage, const std::string& out) {
  const fs::path folder = out, log = folder / "snakemake.log";
  if (std::system("command -v snakemake > /dev/null") != 0)
    throw usage_error("evaluate suite", "snakemake", "is not installed", "install it: apt install snakemake");
  fs::create_directories(folder);
  const FileLock lock(folder / ".lock", out);
  write_text(folder / "Snakefile", std::string(suite_workflow()));
  write_json(folder / "suite.json", settings);

  // The lock above stands for Snakemake's, which outlives a killed one.
  const int workers = stage.workers > 0 ? stage.workers : static_cast<int>(std::thread::hardware_concurrency());
  std::string command = fmt::format("exec snakemake --nolock --rerun-incomplete --keep-going --directory {} -s {}",
                                    quoted_word(out), quoted_word((folder / "Snakefile").string()));
  command += stage.cluster.empty() ? fmt::format(" --cores {}", workers)
                                   : fmt::format(" --cluster {} --jobs {}", quoted_word(stage.cluster), workers);
  ChildProcess snakemake(
      {.command = command + " results", .argument = "--quiet", .log = log, .interrupted = context.interrupted});
  const int total = static_cast<int>(expected_scores(folder, settings).size());
  context.progress.begin("suite", total);
  std::optional<int> code;
  while (!(code = snakemake.wait(2)))
    context.progress.done(std::min(total, static_cast<int>(scores_in(folder, settings).size())));
  context.progress.end();
  if (*code != 0)
    throw input_error(log.string(), "", fmt::format("Snakemake ended with {}: {}", *code, snakemake.last_words()),
                      "see the logs beside it; the same command continues");
  const std::vector<fs::path> scores = scores_in(folder, settings);
  json failed = json::array();
  for (const fs::path& file : scores)
    if (const json score = read_json(file); score.contains("failed"))
      failed.push_back({{"scene", score["scene"]}, {"method", score["method"]}, {"failed", score["failed"]}});
  context.progress.say(fmt::format("suite: {} scores, {} of them failures: {}", scores.size(), failed.size(),
                                   (folder / "RESULTS.md").string()));
  return {{"results", (folder / "RESULTS.md").string()}, {"failed", failed}};
}

}  // namespace pliant

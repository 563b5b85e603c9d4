#include "app/evaluate/compare.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "app/evaluate/metric_table.h"
#include "gaussians/base/error.h"
#include "gaussians/io/files/json_file.h"

namespace fs = std::filesystem;
using nlohmann::json;

namespace pliant {
namespace {

using Runs = std::map<std::string, json>;     // by name; the run of SCENE.json has none
using Results = std::map<std::string, Runs>;  // by scene

Results read_results(const Method& method) {
  std::error_code ignored;
  if (!fs::is_directory(method.folder, ignored))
    throw input_error(method.folder.string(), "", "is not a folder", "give NAME=FOLDER with one JSON file per scene");
  Results results;
  for (const auto& entry : fs::recursive_directory_iterator(method.folder)) {
    if (!entry.is_regular_file() || entry.path().extension() != ".json") continue;
    json result = read_json(entry.path());
    if (!result.is_object())
      throw input_error(entry.path().string(), "", "is not a JSON object", "write it with `pliant evaluate ... --out`");
    const std::string name = fs::relative(entry.path(), method.folder).replace_extension().generic_string();
    const size_t slash = name.find('/');
    results[name.substr(0, slash)][slash == std::string::npos ? "" : name.substr(slash + 1)] = std::move(result);
  }
  if (results.empty())
    throw input_error(method.folder.string(), "", "has no JSON file", "write results with `evaluate ... --out`");
  return results;
}

/// A method that has none of the scenes of the first is a mistaken folder, not a method that failed everywhere.
void check_common_scenes(const std::vector<Method>& methods, const std::vector<Results>& results) {
  for (size_t m = 1; m < methods.size(); ++m) {
    const auto has = [&](const auto& scene) { return results[m].count(scene.first) > 0; };
    if (!std::any_of(results[0].begin(), results[0].end(), has))
      throw input_error(methods[m].folder.string(), results[m].begin()->first,
                        "is no scene of '" + methods[0].name + "', nor is any other in the folder",
                        "give results of the same scenes, under the same names");
  }
}

const Runs& runs_of(const Results& results, const std::string& scene) {
  static const Runs none;
  const auto found = results.find(scene);
  return found == results.end() ? none : found->second;
}

/// Values of a metric in the runs of one scene, by method; NaN = failed.  Empty when no method knows it there.
std::vector<std::vector<double>> values_of(const Metric& metric, const std::vector<Results>& results,
                                           const std::string& scene) {
  const auto is_single = [](const Runs& runs) { return runs.size() == 1 && runs.count(""); };
  std::set<std::string> all, known;  // runs
  bool single = false;
  for (const Results& own : results)
    for (const auto& [run, result] : runs_of(own, scene)) {
      all.insert(run);
      if (!metric_value(result, metric.key).is_number()) continue;
      known.insert(run);
      single |= is_single(runs_of(own, scene));
    }
  if (known.empty()) return {};
  // A single result stands for all runs of the scene, so that none of them is one that no method knows.
  if (single) known = all;
  std::vector<std::vector<double>> values;
  for (const Results& own : results) {
    const Runs& runs = runs_of(own, scene);
    // Who has SCENE.json alone has one result, whatever runs others have; who has runs lacks those that others have.
    std::set<std::string> wanted = known;
    if (is_single(runs))
      wanted = {""};
    else if (!runs.count("") && known.size() > 1)
      wanted.erase("");
    values.emplace_back();
    for (const std::string& run : wanted) {
      const auto found = runs.find(run);
      const json value = found == runs.end() ? json() : metric_value(found->second, metric.key);
      values.back().push_back(value.is_number() ? value.get<double>() : std::numeric_limits<double>::quiet_NaN());
    }
  }
  return values;
}

/// What all methods reach in a metric.
struct Reached {
  std::vector<std::vector<double>> value;  ///< [method][scene]: mean over its runs
  std::vector<int> failures, results;      ///< [method]
  double worst = 0;                        ///< what a failure counts as
};

Reached reached_by(const Metric& metric, const std::vector<Results>& results, const std::set<std::string>& scenes) {
  std::vector<std::vector<std::vector<double>>> runs;  // [scene][method][run]
  Reached out{std::vector<std::vector<double>>(results.size()), std::vector<int>(results.size()),
              std::vector<int>(results.size()), metric.failure};
  for (const std::string& scene : scenes) {
    std::vector<std::vector<double>> values = values_of(metric, results, scene);
    if (values.empty()) continue;
    for (const auto& own : values)
      for (const double v : own)
        if (!std::isnan(v)) out.worst = metric.higher_is_better ? std::min(out.worst, v) : std::max(out.worst, v);
    runs.push_back(std::move(values));
  }
  for (const auto& scene : runs)
    for (size_t m = 0; m < results.size(); ++m) {
      double sum = 0;
      for (const double v : scene[m]) {
        out.failures[m] += std::isnan(v);
        sum += std::isnan(v) ? out.worst : v;
      }
      out.results[m] += static_cast<int>(scene[m].size());
      out.value[m].push_back(sum / static_cast<double>(scene[m].size()));
    }
  return out;
}

/// Scenes in which the first is better, worse and equal.
struct Record {
  int wins = 0, losses = 0, ties = 0;
};

Record record_of(const Metric& metric, const std::vector<double>& ours, const std::vector<double>& theirs) {
  Record record;
  for (size_t i = 0; i < ours.size(); ++i) {
    const double gain = (metric.higher_is_better ? 1 : -1) * (ours[i] - theirs[i]);
    // Means over different numbers of equal runs differ by rounding.
    const bool equal = std::abs(gain) <= 1e-12 * std::max(std::abs(ours[i]), std::abs(theirs[i]));
    ++(equal ? record.ties : gain > 0 ? record.wins : record.losses);
  }
  return record;
}

std::vector<Metric> wanted_metrics(const CompareOptions& options, const Results& ours) {
  std::vector<Metric> wanted;
  for (const std::string& text : options.metrics) {
    const Metric metric = metric_named(text, "--metric");
    if (std::any_of(wanted.begin(), wanted.end(), [&](const Metric& other) { return other.key == metric.key; }))
      throw usage_error("evaluate", "--metric", "has '" + metric.key + "' twice", "name each metric once");
    wanted.push_back(metric);
  }
  if (!wanted.empty()) return wanted;
  for (const Metric& metric : metric_table()) {
    const auto has = [&](const auto& run) { return metric_value(run.second, metric.key).is_number(); };
    if (std::any_of(ours.begin(), ours.end(),
                    [&](const auto& scene) { return std::any_of(scene.second.begin(), scene.second.end(), has); }))
      wanted.push_back(metric);
  }
  return wanted;
}

}  // namespace

json compare_methods(const std::vector<Method>& methods, const CompareOptions& options) {
  CHECK(methods.size() >= 2);
  std::vector<Results> results;
  std::set<std::string> scenes;
  std::set<std::pair<std::string, std::string>> all;  // scene and run
  for (const Method& method : methods) {
    results.push_back(read_results(method));
    for (const auto& [scene, runs] : results.back()) {
      scenes.insert(scene);
      for (const auto& [run, result] : runs) all.insert({scene, run});
    }
  }
  check_common_scenes(methods, results);
  const std::vector<Metric> metrics = wanted_metrics(options, results[0]);
  if (metrics.empty())
    throw input_error(methods[0].folder.string(), "", "has no metric of evaluate", "name one as KEY:higher or :lower");

  json out = {{"kind", "compare"},
              {"level", options.bootstrap.level},
              {"resamples", options.bootstrap.resamples},
              {"seed", options.bootstrap.seed},
              {"scenes", scenes},
              {"results", all.size()},
              {"means", json::array()},
              {"differences", json::array()}};
  for (const Method& method : methods) out["methods"].push_back(method.name);
  for (const Metric& metric : metrics) {
    const Reached reached = reached_by(metric, results, scenes);
    if (reached.value[0].empty())
      throw input_error(methods[0].folder.string(), metric.key, "is in no result of any method",
                        "choose another --metric");
    for (size_t m = 0; m < methods.size(); ++m) {
      const MeanEstimate mean = bootstrap_mean(options.bootstrap, reached.value[m]);
      out["means"].push_back({{"metric", metric.key},
                              {"method", methods[m].name},
                              {"mean", mean.mean},
                              {"low", number_or_null(mean.interval.low)},
                              {"high", number_or_null(mean.interval.high)},
                              {"failures", reached.failures[m]},
                              {"results", reached.results[m]},
                              {"failure_counts_as", reached.worst}});
      if (m == 0) continue;
      const MeanEstimate difference = bootstrap_difference(options.bootstrap, reached.value[0], reached.value[m]);
      const Record record = record_of(metric, reached.value[0], reached.value[m]);
      const int decided = record.wins + record.losses;
      const double sign = metric.higher_is_better ? 1 : -1;
      const bool known = !too_few_clusters(difference.clusters, options.bootstrap.level),
                 ours = known && sign * difference.interval.low > 0 && sign * difference.interval.high > 0,
                 theirs = known && sign * difference.interval.low < 0 && sign * difference.interval.high < 0;
      out["differences"].push_back({{"metric", metric.key},
                                    {"ours", methods[0].name},
                                    {"baseline", methods[m].name},
                                    {"difference", difference.mean},
                                    {"low", number_or_null(difference.interval.low)},
                                    {"high", number_or_null(difference.interval.high)},
                                    {"wins", record.wins},
                                    {"losses", record.losses},
                                    {"ties", record.ties},
                                    {"p_sign", decided > 0 ? json(binomial_test(record.wins, decided)) : json()},
                                    {"verdict", ours     ? methods[0].name
                                                : theirs ? methods[m].name
                                                         : "undecided"}});
    }
  }
  return out;
}

std::vector<TextTable> compare_tables(const json& comparison) {
  const auto title_of = [](const std::string& key) {
    for (const Metric& metric : metric_table())
      if (metric.key == key)
        return metric.title + (metric.unit.empty() ? "" : " [" + metric.unit + "]") +
               (metric.higher_is_better ? " ↑" : " ↓");
    return key;
  };
  const std::string level = number_text(100 * comparison["level"].get<double>()) + " % interval";
  TextTable means{"Means with " + level, {"metric"}, {}}, differences{"", {}, {}};
  for (const json& method : comparison["methods"]) means.columns.push_back(method);
  std::string last;
  for (const json& row : comparison["means"]) {
    if (row["metric"] != last) means.rows.push_back({title_of(last = row["metric"])});
    std::string cell = estimate_text(row["mean"], row["low"], row["high"]);
    if (row["failures"] > 0) cell += ", " + row["failures"].dump() + " failed";
    means.rows.back().push_back(cell);
  }
  differences.title = comparison["methods"][0].get<std::string>() + " minus each other method, with " + level;
  differences.columns = {"metric", "against", "difference", "better : worse : equal scenes", "p (sign test)", "better"};
  for (const json& row : comparison["differences"])
    differences.rows.push_back({title_of(row["metric"]), row["baseline"],
                                estimate_text(row["difference"], row["low"], row["high"]),
                                row["wins"].dump() + " : " + row["losses"].dump() + " : " + row["ties"].dump(),
                                number_text(row["p_sign"], 2), row["verdict"]});
  return {means, differences};
}

}  // namespace pliant

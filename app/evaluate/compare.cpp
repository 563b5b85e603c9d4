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

using Results = std::map<std::string, json>;  // by name: the path without extension

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
    results[fs::relative(entry.path(), method.folder).replace_extension().generic_string()] = std::move(result);
  }
  return results;
}

std::string scene_of(const std::string& name) { return name.substr(0, name.find('/')); }

/// The results that any method knows the metric of.
std::vector<std::string> known_names(const Metric& metric, const std::vector<Results>& results,
                                     const std::set<std::string>& all) {
  std::vector<std::string> known;
  for (const std::string& name : all)
    for (const Results& own : results)
      if (const auto found = own.find(name);
          found != own.end() && metric_value(found->second, metric.key).is_number()) {
        known.push_back(name);
        break;
      }
  return known;
}

/// [method][result] values of a metric; NaN = failed.
using Values = std::vector<std::vector<double>>;

Values values_of(const Metric& metric, const std::vector<Results>& results, const std::vector<std::string>& names) {
  Values values(results.size());
  for (size_t m = 0; m < results.size(); ++m)
    for (const std::string& name : names) {
      const auto found = results[m].find(name);
      const json value = found == results[m].end() ? json() : metric_value(found->second, metric.key);
      values[m].push_back(value.is_number() ? value.get<double>() : std::numeric_limits<double>::quiet_NaN());
    }
  return values;
}

/// What a failure counts as.
double worst_of(const Metric& metric, const Values& values) {
  double worst = metric.failure;
  for (const auto& row : values)
    for (const double v : row)
      if (!std::isnan(v)) worst = metric.higher_is_better ? std::min(worst, v) : std::max(worst, v);
  return worst;
}

/// Scenes in which the first is better, worse and equal.
struct Record {
  int wins = 0, losses = 0, ties = 0;
};

Record record_of(const Metric& metric, const std::vector<double>& ours, const std::vector<double>& theirs,
                 const std::vector<int>& scene) {
  std::map<int, double> gain;
  for (size_t i = 0; i < ours.size(); ++i) gain[scene[i]] += (metric.higher_is_better ? 1 : -1) * (ours[i] - theirs[i]);
  Record record;
  for (const auto& [number, sum] : gain) ++(sum > 0 ? record.wins : sum < 0 ? record.losses : record.ties);
  return record;
}

std::vector<Metric> wanted_metrics(const CompareOptions& options, const Results& ours) {
  std::vector<Metric> wanted;
  for (const std::string& text : options.metrics) wanted.push_back(metric_named(text, "--metric"));
  if (!wanted.empty()) return wanted;
  for (const Metric& metric : metric_table()) {
    const auto has = [&](const auto& item) { return metric_value(item.second, metric.key).is_number(); };
    if (std::any_of(ours.begin(), ours.end(), has)) wanted.push_back(metric);
  }
  return wanted;
}

}  // namespace

json compare_methods(const std::vector<Method>& methods, const CompareOptions& options) {
  CHECK(methods.size() >= 2);
  std::vector<Results> results;
  std::set<std::string> all, scenes;
  for (const Method& method : methods) {
    results.push_back(read_results(method));
    for (const auto& [name, result] : results.back()) {
      all.insert(name);
      scenes.insert(scene_of(name));
    }
  }
  if (results[0].empty())
    throw input_error(methods[0].folder.string(), "", "has no JSON file", "write results with `evaluate ... --out`");
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
    const std::vector<std::string> names = known_names(metric, results, all);
    if (names.empty())
      throw input_error(methods[0].folder.string(), metric.key, "is in no result of any method",
                        "choose another --metric");
    std::vector<std::string> scene_names;
    for (const std::string& name : names) scene_names.push_back(scene_of(name));
    const std::vector<int> scene = cluster_numbers(scene_names);
    Values values = values_of(metric, results, names);
    const double worst = worst_of(metric, values);
    std::vector<int> failures;
    for (auto& row : values) {
      failures.push_back(
          static_cast<int>(std::count_if(row.begin(), row.end(), [](double v) { return std::isnan(v); })));
      for (double& v : row)
        if (std::isnan(v)) v = worst;
    }
    for (size_t m = 0; m < methods.size(); ++m) {
      const MeanEstimate mean = bootstrap_mean(options.bootstrap, values[m], scene);
      out["means"].push_back({{"metric", metric.key},
                              {"method", methods[m].name},
                              {"mean", mean.mean},
                              {"low", number_or_null(mean.interval.low)},
                              {"high", number_or_null(mean.interval.high)},
                              {"failures", failures[m]},
                              {"results", names.size()},
                              {"failure_counts_as", worst}});
      if (m == 0) continue;
      const MeanEstimate difference = bootstrap_difference(options.bootstrap, values[0], values[m], scene);
      const Record record = record_of(metric, values[0], values[m], scene);
      const int decided = record.wins + record.losses;
      const double sign = metric.higher_is_better ? 1 : -1;
      const bool ours = sign * difference.interval.low > 0 && sign * difference.interval.high > 0,
                 theirs = sign * difference.interval.low < 0 && sign * difference.interval.high < 0;
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
  differences.title = comparison["methods"][0].get<std::string>() + " minus each other, with " + level;
  differences.columns = {"metric", "against", "difference", "better : worse : equal scenes", "p (sign test)", "better"};
  for (const json& row : comparison["differences"])
    differences.rows.push_back({title_of(row["metric"]), row["baseline"],
                                estimate_text(row["difference"], row["low"], row["high"]),
                                row["wins"].dump() + " : " + row["losses"].dump() + " : " + row["ties"].dump(),
                                number_text(row["p_sign"], 2), row["verdict"]});
  return {means, differences};
}

}  // namespace pliant

#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "app/report/tables.h"
#include "app/statistics/bootstrap.h"

namespace pliant {

/// Results of one method: every .json below a folder is what `evaluate` wrote about one scene, SCENE.json, or about one
/// of several runs, SCENE/RUN.json.
struct Method {
  std::string name;
  std::filesystem::path folder;
};

struct CompareOptions {
  std::vector<std::string> metrics;  ///< of metric_named, each once; empty: those of the table that the first has
  BootstrapOptions bootstrap;
};

/// The first method against each other one, scene by scene: a scene counts once, by the mean over its runs, and a
/// method may have one result where another has runs, for all of which it stands.  A scene that a method lacks, a run
/// that it lacks beside its others, or a result in which the metric is unknown, is its failure: it counts as the worst
/// value that any method reached, and at least as Metric::failure; results that no method has are unknown and do not
/// count.
///   means: a row for each metric and method: mean over scenes, low, high, failures, results
///   differences: a row for each metric and other method: difference = first - other, low, high, wins, losses, ties
///   of the first method by scene, p_sign of the two-sided sign test, and verdict: the name of the method that the
///   interval favours, or "undecided", as it is with too_few_clusters scenes.
/// A folder without results, or with none of a scene of the first method, is an Error{kInput}; a metric named twice is
/// an Error{kUsage}.
nlohmann::json compare_methods(const std::vector<Method>& methods, const CompareOptions& options);

std::vector<TextTable> compare_tables(const nlohmann::json& comparison);

}  // namespace pliant

#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "app/run/options.h"
#include "app/run/progress.h"

namespace pliant {

/// evaluate suite: scenes with known truth x methods, as jobs of Snakemake (Moelder et al. 2021).
struct SuiteStage {
  std::vector<std::string> kinds;  ///< of demo scenes; empty = all, or the first three with `quick`
  int seeds = 1;                   ///< scenes of each kind
  bool quick = false;              ///< small scenes
  int workers = 0;                 ///< jobs at a time, of one thread each; 0 = one for each core
  std::string cluster;             ///< command that submits a job's script; empty = jobs run on this machine
  std::string settings;            ///< a suite.json instead of what the options above say
};
OptionTable options_of(SuiteStage& stage);

/// What the workflow reads: scenes, methods with the commands of each, sizes.  `kinds` are those of `demo`.
nlohmann::json suite_settings(const SuiteStage& stage, const std::string& pliant,
                              const std::vector<std::string>& kinds);

/// The jobs; written to a folder as Snakefile.
std::string_view suite_workflow();

/// Writes `out`/Snakefile and `out`/suite.json and runs them until `out`/RESULTS.md is there.  What a killed suite has
/// finished is not done again, nor what changed settings leave as it was; another version of Pliant does all again.
/// `out` may be moved between two calls.  RESULTS.md lists the methods of each task with their failures, and compares
/// them where two or more methods are listed and any of them has a result.  Throws Error{kUsage} without Snakemake,
/// Error{kInput} when a job fails otherwise than by a method's own commands or simulations, whose failure has a row.
nlohmann::json run_suite(const Context& context, const nlohmann::json& settings, const SuiteStage& stage,
                         const std::string& out);

}  // namespace pliant

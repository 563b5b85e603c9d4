#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "app/run/progress.h"

namespace pliant {

/// Options that every command takes, and what the chosen command will do.
struct Program {
  std::string out;
  uint64_t seed = 1;
  int threads = 0;
  bool quiet = false, json = false, overwrite = false;
  bool ends_when_interrupted = false;  ///< the chosen command is done when it is interrupted, as a server is
  std::string command_line;            ///< as a shell reads it, for the report
  bool help_all = false;               ///< the help shows the options of stages as well
  /// Of every command: an earlier spelling of an option and the one that took its place.
  std::map<std::string, std::map<std::string, std::string>> renamed;

  /// Set by the chosen command; returns what --json prints.
  std::function<nlohmann::json(Context&)> action;
};

/// Adds --seed, --threads, --quiet, --json, --config to a command, and --out and --overwrite where they apply.
void add_common(CLI::App& command, Program& program);
CLI::Option* add_out(CLI::App& command, Program& program, const std::string& what);
/// --overwrite, and what it does in this command.
void add_overwrite(CLI::App& command, Program& program, const std::string& what);

/// Makes an option be given as often as one likes, with one value each time.
CLI::Option* repeatable(CLI::Option* option);

/// Adds every command to `app`.
void add_commands(CLI::App& app, Program& program);

// One function per command, each in the file of its name.
void add_demo(CLI::App& app, Program& program);
void add_run(CLI::App& app, Program& program);
void add_info(CLI::App& app, Program& program);
void add_convert(CLI::App& app, Program& program);
void add_reconstruct(CLI::App& app, Program& program);
void add_segment(CLI::App& app, Program& program);
void add_extract(CLI::App& app, Program& program);
void add_repair(CLI::App& app, Program& program);
void add_seed(CLI::App& app, Program& program);
void add_predict(CLI::App& app, Program& program);
void add_train_predictor(CLI::App& app, Program& program);
void add_fit(CLI::App& app, Program& program);
void add_simulate(CLI::App& app, Program& program);
void add_render(CLI::App& app, Program& program);
void add_export(CLI::App& app, Program& program);
void add_view(CLI::App& app, Program& program);
void add_evaluate(CLI::App& app, Program& program);
void add_evaluate_suite(CLI::App& evaluate, Program& program);

}  // namespace pliant

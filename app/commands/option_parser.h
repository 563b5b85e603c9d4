#pragma once

#include <CLI/CLI.hpp>
#include <set>
#include <string>
#include <vector>

#include "app/commands/command.h"
#include "app/run/options.h"

namespace pliant {

/// How a command writes the options of a stage.
struct Spelling {
  bool own = true;  ///< the stage's own command: --fps, or --simulate.fps; else only brief_options() need no prefix
  std::set<std::string> left_out;
};

/// Adds the options of a table to a command.  Options with a prefix are shown by --help-all alone.  Spellings that are
/// refused are noted in program.renamed.
void add_options(CLI::App& command, Program& program, const OptionTable& table, const Spelling& spelling = {});

/// What stands for the value of an option in the help: "FILE", "x,y,z", "N".
std::string value_text(const Option& option);

/// Help of at most 100 columns: the name of an option, what stands for its value, its sentence and its default.
class HelpFormatter : public CLI::Formatter {
 public:
  /// `all`: options with a prefix are shown as well.
  explicit HelpFormatter(bool all) : all_(all) {}
  std::string make_group(std::string group, bool is_positional, std::vector<const CLI::Option*> options) const override;
  std::string make_option(const CLI::Option* option, bool is_positional) const override;
  /// Without two empty lines in a row.
  std::string make_help(const CLI::App* app, std::string name, CLI::AppFormatMode mode) const override;

 private:
  bool all_;
};

}  // namespace pliant

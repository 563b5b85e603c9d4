#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <set>
#include <string>
#include <variant>
#include <vector>

namespace pliant {

/// Takes the words that were given, for what is no plain field.
using OptionParser = std::function<void(const std::vector<std::string>& words)>;

struct CountField {
  size_t* value;  ///< written 5000, 200k or 1.5M; 0 = not given
};
struct TimeField {
  double* value;  ///< [s], written 90, 90s, 10m or 1h; 0 = not given
};

/// The field that an option sets.  A bool is a flag; a vector of strings takes a repeated option, a vector of numbers
/// one word with commas.
using OptionField = std::variant<bool*, int*, double*, std::optional<int>*, std::optional<double>*, std::string*,
                                 std::vector<std::string>*, std::vector<double>*, CountField, TimeField, OptionParser>;

/// One option of a stage: the only place that names, bounds and explains it.
struct Option {
  std::string name;  ///< with dashes: "pin-below"
  OptionField field;
  std::string help;     ///< one sentence, with the unit in brackets
  std::string value{};  ///< what stands for the value in the help: "FILE", "x,y,z,r"; empty = by the field's type
  std::string group{};  ///< heading in the help; empty = the stage's
  double low = -std::numeric_limits<double>::infinity(), high = std::numeric_limits<double>::infinity();
  bool positive = false;               ///< more than 0
  std::vector<std::string> choices{};  ///< the words that are allowed; empty = any; with `exists`, besides files
  bool exists = false;                 ///< the value names a file or folder that is there
  bool off = false;                    ///< a flag that makes its field false
  size_t numbers = 0;                  ///< length of a vector of numbers; 0 = any
  std::string formerly{};              ///< an earlier name, which is refused with this one
};

/// The options of a stage.
struct OptionTable {
  std::string stage;  ///< prefix where several stages meet: --simulate.fps
  std::vector<Option> options;
};

/// `count` finite numbers separated by commas; a usage error names the option and the bad word.
std::vector<double> parse_numbers(const std::string& option, const std::string& text, size_t count);
/// A count such as 5000, 200k or 1.5M, or a time such as 90, 90s, 10m or 1h in seconds; a usage error names the option
/// and the value.
size_t parse_count(const std::string& option, const std::string& text);
double parse_duration(const std::string& option, const std::string& text);

/// Options that need no prefix where several stages meet, which is in `run`: those that most people need.
const std::set<std::string>& brief_options();

/// Value of a field as text, for the help; empty for an unset one and for a parser.
std::string field_text(const OptionField& field);

}  // namespace pliant

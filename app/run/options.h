#pragma once

#include <limits>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <set>
#include <string>
#include <variant>
#include <vector>

namespace pliant {

struct CountField {
  size_t* value;  ///< written 5000, 200k or 1.5M; 0 = not given
};
struct TimeField {
  double* value;  ///< [s], written 90, 90s, 10m or 1h; 0 = not given
};
struct EntryField {
  std::map<std::string, double>* values;
  std::string name;  ///< of the entry, which is there once it is given
};
struct LevelField {
  std::optional<int>* value;  ///< a number from 0 on, or "all" (kAllLevels)
};

/// The field that an option sets.  A bool is a flag; a vector of strings takes a repeated option, a vector of numbers
/// one word with commas.
using OptionField =
    std::variant<bool*, int*, double*, std::optional<int>*, std::optional<double>*, std::string*,
                 std::vector<std::string>*, std::vector<double>*, CountField, TimeField, EntryField, LevelField>;

/// What counts of an option where a result is recorded (StageKey).
enum class Recorded {
  kValue,
  kContents,  ///< of the files and folders that it names, not their names
  kElsewhere  ///< the stage's inputs say what follows from it; or it changes no result
};

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
  Recorded recorded = Recorded::kValue;
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

/// A word of a command line, in quotes where a shell would read it otherwise.
std::string quoted_word(const std::string& word);

/// Options that need no prefix where several stages meet, which is in `run`: those that most people need.
const std::set<std::string>& brief_options();

/// Value of a field as text, for the help; empty for an unset one.
std::string field_text(const OptionField& field);

/// Value of a field, null for an unset one.
nlohmann::json field_json(const OptionField& field);

/// Sets a field to such a value.
void set_field(const OptionField& field, const nlohmann::json& value);

/// The words of a field that names files: none, one, or several.
std::vector<std::string> field_words(const OptionField& field);

}  // namespace pliant

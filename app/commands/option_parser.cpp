#include "app/commands/option_parser.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <sstream>

#include "gaussians/base/error.h"
#include "gaussians/io/splats/sog.h"

namespace pliant {
namespace {

constexpr size_t kNameWidth = 30, kLineWidth = 100;
/// What the headings of options with a prefix begin with, in the help.
constexpr const char* kStageHeading = "Stage ";

std::string joined(const std::vector<std::string>& words, const std::string& separator) {
  return fmt::format("{}", fmt::join(words, separator));
}

/// Says what is wrong with a number that an option does not take; empty where it is right.
std::string out_of_range(const Option& option, const std::string& text) {
  char* stop = nullptr;
  const double value = std::strtod(text.c_str(), &stop);
  if (text.empty() || *stop != 0 || !std::isfinite(value)) return "'" + text + "' is not a number";
  if (option.positive && !(value > 0)) return "'" + text + "' is not positive";
  if (value >= option.low && value <= option.high) return "";
  return std::isfinite(option.high) ? fmt::format("'{}' is not in {:g} to {:g}", text, option.low, option.high)
                                    : fmt::format("'{}' is less than {:g}", text, option.low);
}

CLI::Option* bound(CLI::App& command, const std::string& names, const Option& option) {
  const auto texts = [&](std::function<void(const std::vector<std::string>&)> take) {
    return repeatable(command.add_option_function<std::vector<std::string>>(names, std::move(take), option.help));
  };
  const std::string shown = names.substr(0, names.find(','));
  return std::visit(
      [&](const auto& field) -> CLI::Option* {
        using Field = std::decay_t<decltype(field)>;
        if constexpr (std::is_same_v<Field, bool*>) {
          return command.add_flag_callback(
              names, [field, value = !option.off] { *field = value; }, option.help);
        } else if constexpr (std::is_same_v<Field, EntryField>) {
          return command.add_option_function<double>(
              names, [field](double value) { (*field.values)[field.name] = value; }, option.help);
        } else if constexpr (std::is_same_v<Field, LevelField>) {
          return command.add_option_function<std::string>(
              names,
              [field, shown](const std::string& text) {
                const double level = text == "all" ? 0 : parse_numbers(shown, text, 1)[0];
                if (!(level >= 0 && level <= std::numeric_limits<int>::max() && level == std::floor(level)))
                  throw usage_error(shown, "", "'" + text + "' is not a whole number from 0 on", "or give all");
                *field.value = text == "all" ? kAllLevels : static_cast<int>(level);
              },
              option.help);
        } else if constexpr (std::is_same_v<Field, std::vector<std::string>*>) {
          return texts([field](const std::vector<std::string>& words) { *field = words; });
        } else if constexpr (std::is_same_v<Field, std::vector<double>*>) {
          return command.add_option_function<std::string>(
              names,
              [field, option, shown](const std::string& text) {
                *field = parse_numbers(shown, text, option.numbers);
                for (const double value : *field)
                  if (const std::string wrong = out_of_range(option, fmt::format("{:g}", value)); !wrong.empty())
                    throw usage_error(shown, text, wrong, "");
              },
              option.help);
        } else if constexpr (std::is_same_v<Field, CountField> || std::is_same_v<Field, TimeField>) {
          return command.add_option_function<std::string>(
              names,
              [field, shown](const std::string& text) {
                if constexpr (std::is_same_v<Field, CountField>)
                  *field.value = parse_count(shown, text);
                else
                  *field.value = parse_duration(shown, text);
              },
              option.help);
        } else if constexpr (std::is_same_v<Field, std::string*>) {
          return command.add_option(names, *field, option.help);
        } else {
          return command.add_option(names, *field, option.help)->check([option](const std::string& text) {
            return out_of_range(option, text);
          });
        }
      },
      option.field);
}

/// Notes how an option of `run` and of its stage's command was written before.  A name that stays, but needs a prefix
/// now, comes before a name that another option bore.
void note_earlier_spellings(Program& program, const CLI::App& command, const std::string& stage, const Option& option,
                            bool own, const std::string& now) {
  auto& renamed = program.renamed[command.get_name()];
  const auto note = [&](const std::string& before, bool stays) {
    if (before == now) return;
    if (stays)
      renamed[before] = now;
    else
      renamed.insert({before, now});
  };
  if (option.formerly.empty()) note("--" + option.name, true);
  for (const std::string& name : {option.name, option.formerly}) {
    if (name.empty()) continue;
    note("--" + stage + "." + name, false);
    if (!own) note("--" + stage + "-" + name, false);
  }
  if (!option.formerly.empty()) note("--" + option.formerly, false);
  note("--" + option.name, false);
}

}  // namespace

std::string value_text(const Option& option) {
  if (!option.value.empty()) return option.value;
  if (!option.choices.empty()) return joined(option.choices, "|");
  if (std::holds_alternative<int*>(option.field) || std::holds_alternative<std::optional<int>*>(option.field))
    return "N";
  return std::holds_alternative<std::string*>(option.field) ? "TEXT" : "X";
}

void add_options(CLI::App& command, Program& program, const OptionTable& table, const Spelling& spelling) {
  for (const Option& option : table.options) {
    if (spelling.left_out.count(option.name)) continue;
    const std::string plain = "--" + option.name, full = "--" + table.stage + "." + option.name;
    const bool brief = spelling.own || brief_options().count(option.name);
    note_earlier_spellings(program, command, table.stage, option, spelling.own, brief ? plain : full);
    CLI::Option* added = bound(command, brief ? plain + "," + full : full, option);
    if (!option.choices.empty() && option.exists)
      added->check(CLI::IsMember(option.choices) | CLI::ExistingPath);
    else if (!option.choices.empty())
      added->check(CLI::IsMember(option.choices));
    else if (option.exists)
      added->check(CLI::ExistingPath);

    // The help: groups, what stands for the value, and the default.
    std::string group = option.group;
    if (group.empty()) group = spelling.own ? "Options" : "Object, material and motion";
    if (!brief) group = kStageHeading + table.stage + (option.group.empty() ? "" : ": " + option.group);
    added->group(group);
    if (std::holds_alternative<bool*>(option.field)) continue;
    added->option_text(value_text(option));
    const std::string usual = field_text(option.field);
    if (!usual.empty() && option.help.find("(default") == std::string::npos)
      added->description(option.help + " [" + usual + "]");
  }
}

std::string HelpFormatter::make_group(std::string group, bool is_positional,
                                      std::vector<const CLI::Option*> options) const {
  // A group without a name would be hidden too, but CLI11 then leaves the names of its options out of its errors.
  if (!all_ && group.starts_with(kStageHeading)) return "";
  return CLI::Formatter::make_group(std::move(group), is_positional, std::move(options));
}

std::string HelpFormatter::make_help(const CLI::App* app, std::string name, CLI::AppFormatMode mode) const {
  std::string text = CLI::Formatter::make_help(app, std::move(name), mode);
  for (size_t at = 0; (at = text.find("\n\n\n", at)) != std::string::npos;) text.erase(at, 1);
  return text;
}

std::string HelpFormatter::make_option(const CLI::Option* option, bool is_positional) const {
  std::string name = is_positional ? option->get_name(true, false) : "--" + option->get_lnames().front();
  if (!is_positional && option->get_type_size() != 0) name += " " + option->get_option_text();
  std::string line = "  " + name, out;
  if (line.size() + 1 > kNameWidth) {
    out = line + "\n";
    line.clear();
  }
  line.resize(kNameWidth, ' ');
  std::istringstream words(make_option_desc(option) + (option->get_required() ? " (required)" : ""));
  bool begun = false;
  for (std::string word; words >> word; begun = true) {
    if (begun && line.size() + 1 + word.size() > kLineWidth) {
      out += line + "\n";
      line = std::string(kNameWidth, ' ') + word;
    } else {
      line += (begun ? " " : "") + word;
    }
  }
  return out + line + "\n";
}

}  // namespace pliant

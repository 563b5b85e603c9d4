#include "app/run/options.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <map>
#include <nlohmann/json.hpp>

#include "gaussians/base/error.h"
#include "gaussians/io/files/text.h"
#include "gaussians/io/splats/sog.h"

namespace pliant {
using nlohmann::json;

namespace {

std::string text_of(const std::string& value) { return value; }
std::string text_of(bool value) { return value ? "on" : ""; }
std::string text_of(int value) { return fmt::format("{}", value); }
std::string text_of(double value) { return fmt::format("{:g}", value); }
std::string text_of(const std::vector<std::string>& values) { return fmt::format("{}", fmt::join(values, " ")); }
std::string text_of(const std::vector<double>& values) { return fmt::format("{:g}", fmt::join(values, ",")); }
template <class T>
std::string text_of(const std::optional<T>& value) {
  return value ? text_of(*value) : "";
}

/// A positive number with one of the suffixes.
double parse_with_suffix(const std::string& option, const std::string& text,
                         const std::map<std::string, double>& suffixes) {
  char* stop = nullptr;
  const double value = std::strtod(text.c_str(), &stop);
  const auto suffix = suffixes.find(stop);
  if (stop == text.c_str() || suffix == suffixes.end() || !std::isfinite(value) || !(value * suffix->second > 0)) {
    std::string known;
    for (const auto& [name, factor] : suffixes)
      if (!name.empty()) known += (known.empty() ? "" : ", ") + name;
    throw usage_error(option, "", "'" + text + "' is not a positive number, with or without " + known, "");
  }
  return value * suffix->second;
}

}  // namespace

size_t parse_count(const std::string& option, const std::string& text) {
  const double count = parse_with_suffix(option, text, {{"", 1}, {"k", 1e3}, {"K", 1e3}, {"M", 1e6}});
  if (!(count >= 1 && count <= 1e9)) throw usage_error(option, "", "'" + text + "' is not in 1..1000M", "");
  return static_cast<size_t>(std::llround(count));
}

double parse_duration(const std::string& option, const std::string& text) {
  return parse_with_suffix(option, text, {{"", 1}, {"s", 1}, {"m", 60}, {"h", 3600}});
}

std::vector<double> parse_numbers(const std::string& option, const std::string& text, size_t count) {
  std::vector<double> values;
  for (const std::string& word : split(text, ',')) {
    char* stop = nullptr;
    const double value = std::strtod(word.c_str(), &stop);
    if (word.empty() || *stop != 0 || !std::isfinite(value))
      throw usage_error(option, "", "'" + word + "' in '" + text + "' is not a number", "");
    values.push_back(value);
  }
  if (values.size() != count)
    throw usage_error(option, "", fmt::format("'{}' has {} numbers, {} are needed", text, values.size(), count), "");
  return values;
}

std::string quoted_word(const std::string& word) {
  constexpr const char* kPlain = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_@%+=:,./-";
  if (!word.empty() && word.find_first_not_of(kPlain) == std::string::npos) return word;
  std::string out = "'";
  for (const char c : word) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

const std::set<std::string>& brief_options() {
  static const std::set<std::string> names = {
      "up",      "metres-per-unit", "object-height", "time-limit", "box",       "click",        "stroke",
      "aabb",    "masks",           "auto",          "object",     "pin-below", "video",        "video-camera",
      "label",   "softness",        "young",         "poisson",    "density",   "interactions", "duration",
      "no-html", "html-size",       "size"};
  return names;
}

std::string field_text(const OptionField& field) {
  return std::visit(
      [](const auto& target) -> std::string {
        using Field = std::decay_t<decltype(target)>;
        if constexpr (std::is_same_v<Field, CountField> || std::is_same_v<Field, TimeField>) {
          return *target.value == 0 ? "" : fmt::format("{}", *target.value);
        } else if constexpr (std::is_same_v<Field, EntryField>) {
          const auto entry = target.values->find(target.name);
          return entry == target.values->end() ? "" : text_of(entry->second);
        } else if constexpr (std::is_same_v<Field, LevelField>) {
          return *target.value == kAllLevels ? "all" : text_of(*target.value);
        } else {
          return text_of(*target);
        }
      },
      field);
}

json field_json(const OptionField& field) {
  return std::visit(
      [](const auto& target) -> json {
        using Field = std::decay_t<decltype(target)>;
        if constexpr (std::is_same_v<Field, CountField> || std::is_same_v<Field, TimeField>) {
          return *target.value == 0 ? json() : json(*target.value);
        } else if constexpr (std::is_same_v<Field, EntryField>) {
          const auto entry = target.values->find(target.name);
          return entry == target.values->end() ? json() : json(entry->second);
        } else if constexpr (std::is_same_v<Field, LevelField>) {
          return *target.value ? json(**target.value) : json();
        } else if constexpr (std::is_same_v<Field, std::optional<int>*> ||
                             std::is_same_v<Field, std::optional<double>*>) {
          return *target ? json(**target) : json();
        } else {
          return json(*target);
        }
      },
      field);
}

void set_field(const OptionField& field, const json& value) {
  std::visit(
      [&value](const auto& target) {
        using Field = std::decay_t<decltype(target)>;
        if constexpr (std::is_same_v<Field, CountField> || std::is_same_v<Field, TimeField>) {
          *target.value = 0;
          if (!value.is_null()) value.get_to(*target.value);
        } else if constexpr (std::is_same_v<Field, EntryField>) {
          target.values->erase(target.name);
          if (!value.is_null()) (*target.values)[target.name] = value.get<double>();
        } else if constexpr (std::is_same_v<Field, LevelField>) {
          target.value->reset();
          if (!value.is_null()) *target.value = value.get<int>();
        } else if constexpr (std::is_same_v<Field, std::optional<int>*> ||
                             std::is_same_v<Field, std::optional<double>*>) {
          target->reset();
          if (!value.is_null()) *target = value.get<typename std::remove_pointer_t<Field>::value_type>();
        } else {
          value.get_to(*target);
        }
      },
      field);
}

std::vector<std::string> field_words(const OptionField& field) {
  if (const auto* word = std::get_if<std::string*>(&field))
    return (*word)->empty() ? std::vector<std::string>{} : std::vector<std::string>{**word};
  if (const auto* words = std::get_if<std::vector<std::string>*>(&field)) return **words;
  return {};
}

}  // namespace pliant

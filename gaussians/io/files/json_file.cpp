#include "gaussians/io/files/json_file.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "gaussians/io/files/files.h"

namespace pliant {
namespace {

std::string shortened(const nlohmann::json& value) {
  if (value.is_object()) return "an object";
  if (value.is_array()) return "an array of " + std::to_string(value.size());
  const std::string text = value.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  return text.size() > 60 ? text.substr(0, 60) + "..." : text;
}

constexpr int kDeepest = 500;

/// Largest depth of brackets outside strings.
int depth_of(const std::string& text) {
  int depth = 0, deepest = 0;
  bool quoted = false;
  for (size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '"')
      quoted = !quoted;
    else if (quoted)
      i += c == '\\';
    else if (c == '[' || c == '{')
      deepest = std::max(deepest, ++depth);
    else if (c == ']' || c == '}')
      --depth;
  }
  return deepest;
}

}  // namespace

nlohmann::json parse_json(const std::string& text, const std::string& file, const std::string& field) {
  // Each level costs far more memory than its bracket.
  if (depth_of(text) > kDeepest)
    throw input_error(file, field, "is nested deeper than 500 levels", "the file is damaged");
  try {
    return nlohmann::json::parse(text);
  } catch (const nlohmann::json::exception& error) {
    throw input_error(file, field, std::string("is not valid JSON: ") + error.what(), "correct the file");
  }
}

nlohmann::json read_json(const std::filesystem::path& file) { return parse_json(read_text(file), file.string()); }

void write_json(const std::filesystem::path& file, const nlohmann::json& value) {
  write_text(file, value.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
}

JsonObject::JsonObject(const nlohmann::json& value, std::string file, std::string field, Failure failure)
    : value_(&value), file_(std::move(file)), field_(std::move(field)), failure_(failure) {
  if (!value.is_object()) throw Error(failure_, file_, field_, "is " + shortened(value), "it must be an object {...}");
}

bool JsonObject::has(const std::string& key) const { return value_->contains(key); }

Error JsonObject::complaint(const std::string& key, const std::string& problem, const std::string& remedy) const {
  return {failure_, file_, path_of(key), problem, remedy};
}

const nlohmann::json& JsonObject::at(const std::string& key) const {
  const auto found = value_->find(key);
  if (found == value_->end()) throw complaint(key, "is missing", "add it");
  return *found;
}

double JsonObject::number(const std::string& key) const {
  const nlohmann::json& value = at(key);
  if (!value.is_number()) throw complaint(key, "is " + shortened(value), "it must be a number");
  return value.get<double>();
}

double JsonObject::number(const std::string& key, double otherwise) const { return has(key) ? number(key) : otherwise; }

bool JsonObject::flag(const std::string& key) const {
  const nlohmann::json& value = at(key);
  if (!value.is_boolean()) throw complaint(key, "is " + shortened(value), "it must be true or false");
  return value.get<bool>();
}

std::string JsonObject::text(const std::string& key) const {
  const nlohmann::json& value = at(key);
  if (!value.is_string()) throw complaint(key, "is " + shortened(value), "it must be a string in quotes");
  return value.get<std::string>();
}

const nlohmann::json& JsonObject::array(const std::string& key) const {
  const nlohmann::json& value = at(key);
  if (!value.is_array()) throw complaint(key, "is " + shortened(value), "it must be an array [...]");
  return value;
}

std::vector<double> JsonObject::numbers(const std::string& key, size_t count) const {
  const nlohmann::json& value = array(key);
  const std::string remedy = "it must be an array of " + std::to_string(count) + " numbers";
  if (value.size() != count) throw complaint(key, "is " + shortened(value), remedy);
  std::vector<double> numbers;
  for (const nlohmann::json& element : value) {
    if (!element.is_number()) throw complaint(key, "holds " + shortened(element), remedy);
    numbers.push_back(element.get<double>());
  }
  return numbers;
}

std::vector<std::string> JsonObject::keys() const {
  std::vector<std::string> keys;
  for (const auto& [key, value] : value_->items()) keys.push_back(key);
  return keys;
}

JsonObject JsonObject::object(const std::string& key) const { return {at(key), file_, path_of(key), failure_}; }

void JsonObject::refuse_unknown(const std::vector<std::string>& known) const {
  for (const auto& [key, value] : value_->items()) {
    bool found = false;
    for (const std::string& name : known) found = found || name == key;
    if (!found) throw complaint(key, "is an unknown key", "did you mean '" + nearest_name(key, known) + "'?");
  }
}

}  // namespace pliant

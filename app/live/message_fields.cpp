#include "app/live/message_fields.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "gaussians/base/error.h"
#include "gaussians/io/files/utf8.h"

namespace pliant {
using nlohmann::json;

namespace {

constexpr int kMostDepth = 16;
constexpr double kLargest = 1e6;

Error wrong(const json& value, const std::string& field, const std::string& remedy) {
  return usage_error("message", field,
                     "is " + beginning_of(value.dump(-1, ' ', false, json::error_handler_t::replace), 40), remedy);
}

}  // namespace

json parse_message(std::string_view text, const std::string& described) {
  bool deep = false;
  const auto callback = [&](int depth, json::parse_event_t, json&) {
    deep |= depth > kMostDepth;
    return !deep;
  };
  json value = json::parse(text, callback, false);
  if (deep || value.is_discarded() || !value.is_object())
    throw usage_error("message", "", "is not a JSON object", "see " + described);
  return value;
}

int64_t whole_number(const json& value, const std::string& field, int64_t least, int64_t most) {
  if (!value.is_number_integer() || value < least || value > most)
    throw wrong(value, field, fmt::format("give a whole number from {} to {}", least, most));
  return value;
}

double finite_number(const json& value, const std::string& field) {
  if (!value.is_number() || !(std::abs(value.get<double>()) < kLargest))
    throw wrong(value, field, fmt::format("give a number between -{0:g} and {0:g}", kLargest));
  return value;
}

bool truth_value(const json& value, const std::string& field) {
  if (!value.is_boolean()) throw wrong(value, field, "give true or false");
  return value;
}

std::string short_text(const json& value, const std::string& field, size_t longest) {
  if (!value.is_string() || value.get_ref<const std::string&>().size() > longest)
    throw wrong(value, field, fmt::format("give a text of at most {} bytes", longest));
  return value;
}

}  // namespace pliant

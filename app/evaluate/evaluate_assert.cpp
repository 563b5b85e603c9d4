#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "app/evaluate/evaluate.h"
#include "app/evaluate/metrics.h"
#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/files/text.h"

using nlohmann::json;

namespace pliant {
namespace {

/// Keys of all numbers (and nulls), nested ones joined by a dot.
void collect(const json& object, const std::string& prefix, std::vector<std::string>& keys) {
  for (const auto& [key, value] : object.items()) {
    if (value.is_object())
      collect(value, prefix + key + ".", keys);
    else if (value.is_number() || value.is_null())
      keys.push_back(prefix + key);
  }
}

}  // namespace

std::vector<std::string> assert_metrics(const json& metrics, const std::vector<std::string>& conditions) {
  std::vector<std::string> failures;
  for (const std::string& condition : conditions) {
    const size_t at = condition.find_first_of("<>=");
    const auto unreadable = [&](const std::string& problem) {
      return usage_error("--assert", condition, problem, "write it like psnr>=30, with one of >= <= > < ==");
    };
    if (at == std::string::npos) throw unreadable("has no comparison");
    const size_t end = condition.find_first_not_of("<>=", at);
    const std::string key = trimmed(condition.substr(0, at)), operation = condition.substr(at, end - at);
    const std::string bound_text = end == std::string::npos ? "" : trimmed(condition.substr(end));
    char* rest = nullptr;
    const double bound = std::strtod(bound_text.c_str(), &rest);
    if (bound_text.empty() || *rest != '\0' || std::isnan(bound))
      throw unreadable("has no number after the comparison");
    const json* found = find_value(metrics, key);
    if (!found || (!found->is_number() && !found->is_null())) {
      std::vector<std::string> keys;
      collect(metrics, "", keys);
      throw usage_error("--assert", key, "is not a metric of this evaluation",
                        "did you mean '" + nearest_name(key, keys) + "'?");
    }
    const double value = found->is_null() ? NAN : found->get<double>();
    bool holds = false;
    if (operation == ">=")
      holds = value >= bound;
    else if (operation == "<=")
      holds = value <= bound;
    else if (operation == ">")
      holds = value > bound;
    else if (operation == "<")
      holds = value < bound;
    else if (operation == "==")
      holds = value == bound;
    else
      throw unreadable("has the unknown comparison '" + operation + "'");
    if (holds) continue;
    char number[32];
    std::snprintf(number, sizeof number, "%.6g", value);
    failures.push_back(key + " is " + (std::isnan(value) ? "undefined" : number) + " but " + condition +
                       " was required");
  }
  return failures;
}

}  // namespace pliant

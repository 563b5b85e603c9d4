#include "app/evaluate/study/study_tables.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

using nlohmann::json;

namespace pliant {
namespace {

std::string percent_text(const json& value, const json& low, const json& high) {
  if (!value.is_number()) return "-";
  std::string text = fmt::format("{:.1f} %", 100 * value.get<double>());
  if (low.is_number()) text += fmt::format(" [{:.1f}, {:.1f}]", 100 * low.get<double>(), 100 * high.get<double>());
  return text;
}

}  // namespace

std::vector<TextTable> study_tables(const json& statistics) {
  const std::string ours = statistics["ours"], level = number_text(100 * statistics["level"].get<double>(), 6) + " %";
  TextTable people{"Participants", {"", "number"}, {}};
  people.rows = {{"all", statistics["participants"].dump()},
                 {"left out, chose broken clips", statistics["excluded"].dump()},
                 {"professionals", statistics["professionals"].dump()},
                 {"others", statistics["others"].dump()},
                 {"incomplete", statistics["incomplete"].dump()}};
  TextTable choices{"How often " + ours + " was chosen (" + level + " intervals)",
                    {"group", "question", "over", "chosen", "share, by participants", "Wilson", "p", "p (Holm)"},
                    {}};
  for (const json& row : statistics["choices"])
    choices.rows.push_back({row["group"], row["question"], row["baseline"],
                            row["wins"].dump() + " of " + row["trials"].dump(),
                            percent_text(row["share"], row["low"], row["high"]),
                            percent_text(row["share"], row["wilson_low"], row["wilson_high"]),
                            number_text(row["p_value"], 2), number_text(row["p_holm"], 2)});
  TextTable ratings{"Mean scores (" + level + " intervals, by participants)",
                    {"group", "rating", "method", "scores", "mean", ours + " minus it"},
                    {}};
  for (const json& row : statistics["ratings"])
    ratings.rows.push_back({row["group"], row["rating"], row["method"], row["scores"].dump(),
                            estimate_text(row["mean"], row["low"], row["high"]),
                            estimate_text(row["ours_minus_it"], row["difference_low"], row["difference_high"])});
  return {people, choices, ratings};
}

}  // namespace pliant

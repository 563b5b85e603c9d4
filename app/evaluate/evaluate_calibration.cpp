#include "app/evaluate/evaluate_calibration.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>

#include "app/statistics/calibration.h"
#include "fitting/predict/csv_rows.h"
#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"

using nlohmann::json;

namespace pliant {
namespace {

constexpr size_t kLeastRows = 8;
const std::vector<double> kLevels = {0.68, 0.9};

using Rows = std::vector<StatedBand>;

/// Rows by quantity, all of them under "all".
std::map<std::string, Rows> read_bands(const std::filesystem::path& file, const std::optional<double>& band) {
  std::string text = read_text(file);
  const std::string name = file.string();
  // Spreadsheets mark UTF-8 with these bytes.
  if (text.starts_with("\xEF\xBB\xBF")) text.erase(0, 3);
  std::string head = text.substr(0, text.find('\n'));
  std::erase(head, '\r');
  const std::vector<std::string> titles = split_list(head, ',');
  const auto has = [&](const char* title) { return std::find(titles.begin(), titles.end(), title) != titles.end(); };
  for (const std::string& title : titles)
    if (title != "quantity" && title != "estimate" && title != "truth" && title != "sigma" && title != "low" &&
        title != "high")
      throw input_error(name, "line 1", "title '" + title + "'",
                        "the columns are estimate, truth, sigma or low and high, and quantity");
  const bool symmetric = has("sigma");
  if (!has("estimate") || !has("truth") || has("low") == symmetric || has("high") == symmetric)
    throw input_error(name, "line 1", "titles '" + head + "'",
                      "give estimate, truth, and either sigma or low and high");
  if (symmetric && band)
    throw usage_error("evaluate", "--band", "does nothing with sigma, which '" + name + "' gives", "leave it out");
  const CsvTable table(text, name, titles);
  const double width = normal_half_width(band.value_or(kUsualBand));
  std::map<std::string, Rows> rows;
  for (const CsvRow& row : table.rows) {
    StatedBand stated;
    stated.estimate = row.number("estimate");
    stated.truth = row.number("truth");
    stated.sigma_below = symmetric ? row.number("sigma") : (stated.estimate - row.number("low")) / width;
    stated.sigma_above = symmetric ? row.number("sigma") : (row.number("high") - stated.estimate) / width;
    if (!(stated.sigma_below > 0 && stated.sigma_above > 0))
      throw row.complaint(symmetric ? "sigma" : "low", "makes a band without width around the estimate",
                          "give sigma > 0, or low < estimate < high");
    rows["all"].push_back(stated);
    if (!has("quantity")) continue;
    if (row.text("quantity") == "all")
      throw row.complaint("quantity", "'all' is the name of all rows together", "give it another name");
    rows[row.text("quantity")].push_back(stated);
  }
  if (rows.size() == 2) rows.erase("all");
  for (const auto& [quantity, bands] : rows)
    if (bands.size() < kLeastRows)
      throw input_error(name, quantity, fmt::format("has {} rows", bands.size()),
                        fmt::format("half of them gives the factor and half checks it: give {} or more", kLeastRows));
  return rows;
}

void add_coverage(json& row, const std::string& name, const std::optional<Coverage>& coverage) {
  const auto or_null = [&](auto&& value) { return coverage ? json(value(*coverage)) : json(); };
  row[name] = or_null([](const Coverage& c) { return c.share; });
  row[name + "_low"] = or_null([](const Coverage& c) { return c.interval.low; });
  row[name + "_high"] = or_null([](const Coverage& c) { return c.interval.high; });
  row[name + "_as_stated"] = or_null([](const Coverage& c) { return c.as_stated; });
}

json factor_or_null(const std::optional<double>& factor) { return factor ? json(*factor) : json(); }

}  // namespace

json evaluate_calibration(const std::filesystem::path& table, const CalibrationOptions& options) {
  json out = {{"kind", "calibration"}, {"seed", options.seed}, {"factors", json::object()}, {"levels", json::array()}};
  for (const auto& [quantity, rows] : read_bands(table, options.band)) {
    const Calibration found = calibrate(rows, kLevels, options.seed);
    out["factors"][quantity] = factor_or_null(found.factor);
    for (const CalibrationLevel& level : found.levels) {
      json row = {{"quantity", quantity},
                  {"nominal", level.nominal},
                  {"rows", rows.size()},
                  {"inside", level.stated.inside},
                  {"factor", factor_or_null(level.factor)},
                  {"rows_second_half", level.second_half.rows}};
      add_coverage(row, "coverage", level.stated);
      add_coverage(row, "second_half", level.second_half);
      add_coverage(row, "with_factor", level.with_factor);
      add_coverage(row, "with_one_factor", level.with_one_factor);
      out["levels"].push_back(std::move(row));
    }
  }
  return out;
}

std::vector<TextTable> calibration_tables(const json& calibration) {
  TextTable table{
      "Coverage of stated bands, with exact 95 % intervals",
      {"quantity", "stated", "rows", "covered", "factor", "second half", "with its factor", "with one factor"},
      {}};
  const auto percent = [](const json& row, const std::string& name) -> std::string {
    if (row[name].is_null()) return "-";
    return fmt::format("{:.1f} % [{:.1f}, {:.1f}]{}", 100 * row[name].get<double>(),
                       100 * row[name + "_low"].get<double>(), 100 * row[name + "_high"].get<double>(),
                       row[name + "_as_stated"].get<bool>() ? "" : " (off)");
  };
  for (const json& row : calibration["levels"])
    table.rows.push_back({row["quantity"], fmt::format("{:.0f} %", 100 * row["nominal"].get<double>()),
                          row["rows"].dump(), percent(row, "coverage"),
                          row["factor"].is_null() ? "too few rows" : number_text(row["factor"]),
                          percent(row, "second_half"), percent(row, "with_factor"), percent(row, "with_one_factor")});
  TextTable factors{"One factor for all levels", {"quantity", "factor"}, {}};
  for (const auto& [quantity, factor] : calibration["factors"].items())
    factors.rows.push_back({quantity, number_text(factor)});
  return {table, factors};
}

}  // namespace pliant

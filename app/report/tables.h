#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace pliant {

/// A table to read.
struct TextTable {
  std::string title;
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows;
};
std::string markdown_of(const TextTable& table);

/// Rows, an array of flat objects, with a column for each key of the first one (RFC 4180); null is an empty cell.
std::string csv_of(const nlohmann::json& rows);

/// Writes kind.json, kind.md with all tables, and kind_ARRAY.csv for every array named, into `folder`; `kind` is that
/// of the result.
void write_tables(const std::filesystem::path& folder, const nlohmann::json& result,
                  const std::vector<std::string>& arrays, const std::vector<TextTable>& tables);

/// "0.123", with `digits` significant ones; "-" for what is not known.
std::string number_text(const nlohmann::json& value, int digits = 3);
/// "0.12 [0.10, 0.15]".
std::string estimate_text(const nlohmann::json& value, const nlohmann::json& low, const nlohmann::json& high);
/// NaN has no place in JSON: null.
nlohmann::json number_or_null(double value);

}  // namespace pliant

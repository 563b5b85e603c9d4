#include "app/report/tables.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/files/json_file.h"

using nlohmann::json;

namespace pliant {
namespace {

std::string csv_cell(const json& value) {
  if (value.is_null()) return "";
  const std::string text = value.is_string() ? value.get<std::string>() : value.dump();
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

std::string markdown_row(const std::vector<std::string>& cells) {
  std::string row = "|";
  for (const std::string& cell : cells) {
    row += ' ';
    for (const char c : cell) row += c == '|' ? std::string("\\|") : std::string(1, c);
    row += " |";
  }
  return row + "\n";
}

}  // namespace

std::string markdown_of(const TextTable& table) {
  std::string out = "### " + table.title + "\n\n" + markdown_row(table.columns) + "|";
  for (size_t i = 0; i < table.columns.size(); ++i) out += "---|";
  out += "\n";
  for (const auto& row : table.rows) {
    CHECK(row.size() == table.columns.size());
    out += markdown_row(row);
  }
  return out;
}

std::string csv_of(const json& rows) {
  std::string out;
  if (rows.empty()) return out;
  const auto line = [&](auto&& cell) {
    bool first = true;
    for (const auto& [key, value] : rows[0].items()) {
      out += (first ? "" : ",") + cell(key);
      first = false;
    }
    out += "\r\n";
  };
  line([](const std::string& key) { return csv_cell(key); });
  for (const json& row : rows) line([&](const std::string& key) { return csv_cell(row.value(key, json())); });
  return out;
}

void write_tables(const std::filesystem::path& folder, const json& result, const std::vector<std::string>& arrays,
                  const std::vector<TextTable>& tables) {
  const std::string kind = result.at("kind");
  std::filesystem::create_directories(folder);
  write_json(folder / (kind + ".json"), result);
  std::string text;
  for (const TextTable& table : tables) text += (text.empty() ? "" : "\n") + markdown_of(table);
  write_text(folder / (kind + ".md"), text);
  for (const std::string& array : arrays) write_text(folder / (kind + "_" + array + ".csv"), csv_of(result.at(array)));
}

std::string number_text(const json& value, int digits) {
  return value.is_number() ? fmt::format("{:.{}g}", value.get<double>(), digits) : "-";
}

std::string estimate_text(const json& value, const json& low, const json& high) {
  if (!low.is_number() || !high.is_number()) return number_text(value);
  return fmt::format("{} [{}, {}]", number_text(value), number_text(low), number_text(high));
}

json number_or_null(double value) { return std::isfinite(value) ? json(value) : json(); }

}  // namespace pliant

#include "fitting/predict/csv_rows.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <stdexcept>

#include "gaussians/io/files/text.h"

namespace pliant {
namespace {

std::vector<std::string> pieces_of(std::string_view text, char separator) {
  std::vector<std::string> pieces = split(text, separator);
  for (std::string& piece : pieces) piece = trimmed(piece);
  return pieces;
}

}  // namespace

std::vector<std::string> split_list(std::string_view text, char separator) {
  std::vector<std::string> pieces = pieces_of(text, separator);
  std::erase(pieces, "");
  return pieces;
}

double exact_number(const std::string& text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
    throw std::invalid_argument("'" + text + "' is not a number");
  return value;
}

const std::string& CsvRow::text(const std::string& column) const {
  const auto found = std::find(titles->begin(), titles->end(), column);
  CHECK(found != titles->end());
  return cells[found - titles->begin()];
}

double CsvRow::number(const std::string& column) const {
  try {
    return exact_number(text(column));
  } catch (const std::invalid_argument& error) {
    throw complaint(column, error.what(), "write it as 0.3 or 2e6");
  }
}

std::vector<std::string> CsvRow::list(const std::string& column, char separator) const {
  return split_list(text(column), separator);
}

Error CsvRow::complaint(const std::string& column, const std::string& problem, const std::string& remedy) const {
  return input_error(file, "line " + std::to_string(line) + ", " + column, problem, remedy);
}

CsvTable::CsvTable(std::string_view text, const std::string& file, std::vector<std::string> wanted)
    : titles(std::move(wanted)) {
  size_t line = 0;
  for (const std::string& content : pieces_of(text, '\n')) {
    ++line;
    if (content.empty()) continue;
    const std::string where = "line " + std::to_string(line);
    if (content.find('"') != std::string::npos)
      throw input_error(file, where, "a quote", "separate cells with commas; cells cannot contain quotes or commas");
    std::vector<std::string> cells = pieces_of(content, ',');
    if (cells.size() != titles.size())
      throw input_error(file, where, std::to_string(cells.size()) + " cells, '" + content.substr(0, 40) + "'",
                        "give one for each of the " + std::to_string(titles.size()) + " titles");
    if (line > 1) {
      rows.push_back({file, line, &titles, std::move(cells)});
      continue;
    }
    for (size_t i = 0; i < titles.size(); ++i)
      if (cells[i] != titles[i])
        throw input_error(file, where, "title '" + cells[i] + "'", "write '" + titles[i] + "' there");
  }
  if (rows.empty()) throw input_error(file, "", "no rows", "give titles and at least one row");
}

}  // namespace pliant

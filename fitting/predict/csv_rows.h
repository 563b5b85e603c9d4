#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "gaussians/base/error.h"

namespace pliant {

/// A line of a table, whose complaints name file, line, column and value.
struct CsvRow {
  std::string file;
  size_t line = 0;
  const std::vector<std::string>* titles = nullptr;
  std::vector<std::string> cells;

  const std::string& text(const std::string& column) const;
  double number(const std::string& column) const;  ///< finite; throws Error{kInput}
  std::vector<std::string> list(const std::string& column, char separator = ';') const;  ///< without empty items
  Error complaint(const std::string& column, const std::string& problem, const std::string& remedy) const;
};

/// A table with these titles, in this order, in its first line.  Cells are parted by commas and hold no quotes.
struct CsvTable {
  CsvTable(std::string_view text, const std::string& file, std::vector<std::string> titles);  ///< throws Error{kInput}
  CsvTable(const CsvTable&) = delete;

  std::vector<std::string> titles;
  std::vector<CsvRow> rows;
};

/// The pieces of a text between separators, without spaces around them and without empty ones.
std::vector<std::string> split_list(std::string_view text, char separator);
/// Throws std::invalid_argument unless the whole text is a finite number.
double exact_number(const std::string& text);

}  // namespace pliant

#include "gaussians/io/files/npy.h"

#include <cctype>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>

#include "gaussians/base/error.h"

namespace pliant {
using nlohmann::json;

namespace {

constexpr std::string_view kMagic = "\x93NUMPY";

/// The dictionary of Python in the header as JSON: quotes and brackets are replaced, commas before a closing bracket
/// dropped.  Names of columns hold none of these.
json header_json(std::string_view text) {
  std::string out;
  for (size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == ')' || c == '}' || c == ']')
      while (!out.empty() && (out.back() == ',' || std::isspace(static_cast<unsigned char>(out.back()))))
        out.pop_back();
    if (text.substr(i, 5) == "False") {
      out += "false";
      i += 4;
    } else if (text.substr(i, 4) == "True") {
      out += "true";
      i += 3;
    } else {
      out += c == '\'' ? '"' : c == '(' ? '[' : c == ')' ? ']' : c;
    }
  }
  return json::parse(out, nullptr, false);
}

struct Column {
  std::string name;
  char kind;    // f, i or u
  size_t size;  // bytes
};

template <class T>
double value_as(const char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  return static_cast<double>(value);
}

double value_at(const Column& column, const char* bytes) {
  if (column.kind == 'f') return column.size == 4 ? value_as<float>(bytes) : value_as<double>(bytes);
  const bool sign = column.kind == 'i';
  switch (column.size) {
    case 1:
      return sign ? value_as<int8_t>(bytes) : value_as<uint8_t>(bytes);
    case 2:
      return sign ? value_as<int16_t>(bytes) : value_as<uint16_t>(bytes);
    case 4:
      return sign ? value_as<int32_t>(bytes) : value_as<uint32_t>(bytes);
    default:
      return sign ? value_as<int64_t>(bytes) : value_as<uint64_t>(bytes);
  }
}

/// {"name", "<f4"}
Column column_of(const json& row, const std::string& where) {
  const auto refuse = [&] {
    return input_error(where, "descr", "has a column " + row.dump() + " that is no little-endian number",
                       "save a structured array of <f4, <f8 or integers");
  };
  if (!row.is_array() || row.size() != 2 || !row[0].is_string() || !row[1].is_string()) throw refuse();
  const std::string type = row[1];
  if (type.size() != 3 || std::string("fiu").find(type[1]) == std::string::npos ||
      std::string("1248").find(type[2]) == std::string::npos)
    throw refuse();
  const Column column{row[0], type[1], static_cast<size_t>(type[2] - '0')};
  const bool order = type[0] == '<' || (column.size == 1 && type[0] == '|');
  if (!order || (column.kind == 'f' && column.size < 4)) throw refuse();
  return column;
}

struct Opened {
  json header;
  std::string_view data;
};

/// The header, whose `descr` and `shape` are there, and what follows it.
Opened open_npy(std::string_view bytes, const std::string& where) {
  const auto refuse = [&](const std::string& why) {
    return input_error(where, "header", why, "save the array with NumPy again");
  };
  if (bytes.size() < 12 || bytes.substr(0, kMagic.size()) != kMagic) throw refuse("is none of a NumPy array");
  const int version = bytes[6];
  if (version < 1 || version > 3) throw refuse("is of version " + std::to_string(version));
  const size_t start = version == 1 ? 10 : 12;
  const size_t length =
      static_cast<size_t>(version == 1 ? value_as<uint16_t>(&bytes[8]) : value_as<uint32_t>(&bytes[8]));
  if (length > bytes.size() - start) throw refuse("is cut off");
  const json header = header_json(bytes.substr(start, length));
  if (!header.is_object() || !header.contains("descr") || !header.contains("shape") || !header["shape"].is_array())
    throw refuse("cannot be read");
  return {header, bytes.substr(start + length)};
}

Error too_short(const std::string& where, size_t bytes, uint64_t rows) {
  return input_error(where, "data",
                     "has " + std::to_string(bytes) + " bytes, which are fewer than " + std::to_string(rows) + " rows",
                     "the file is cut off");
}

}  // namespace

std::map<std::string, std::vector<double>> read_npy_columns(std::string_view bytes, const std::string& where) {
  const auto [header, data] = open_npy(bytes, where);
  if (!header["descr"].is_array() || header["shape"].size() != 1 || !header["shape"][0].is_number_unsigned())
    throw input_error(where, "shape", "is " + header["shape"].dump() + " of " + header["descr"].dump(),
                      "a structured array of one dimension is needed");
  std::vector<Column> columns;
  size_t row_bytes = 0;
  for (const json& row : header["descr"]) {
    columns.push_back(column_of(row, where));
    row_bytes += columns.back().size;
  }
  const uint64_t rows = header["shape"][0];
  if (row_bytes == 0 || rows > data.size() / row_bytes) throw too_short(where, data.size(), rows);
  std::map<std::string, std::vector<double>> out;
  const char* at = data.data();
  for (const Column& column : columns) out[column.name].reserve(rows);
  for (uint64_t r = 0; r < rows; ++r)
    for (const Column& column : columns) {
      out[column.name].push_back(value_at(column, at));
      at += column.size;
    }
  return out;
}

std::string npy_of_columns(const std::vector<std::pair<std::string, std::vector<float>>>& columns) {
  CHECK(!columns.empty());
  const size_t rows = columns[0].second.size();
  std::string header = "{'descr': [";
  for (const auto& [name, values] : columns) {
    CHECK(values.size() == rows);
    header += std::string(header.back() == '[' ? "" : ", ") + "('" + name + "', '<f4')";
  }
  header += "], 'fortran_order': False, 'shape': (" + std::to_string(rows) + ",), }";
  while ((10 + header.size() + 1) % 64) header += ' ';
  header += '\n';
  CHECK(header.size() < 65536);
  std::string out(kMagic);
  out += {'\1', '\0', static_cast<char>(header.size() & 255), static_cast<char>(header.size() >> 8)};
  out += header;
  for (size_t r = 0; r < rows; ++r)
    for (const auto& [name, values] : columns) out.append(reinterpret_cast<const char*>(&values[r]), sizeof(float));
  return out;
}

NpyArray read_npy_array(std::string_view bytes, const std::string& where) {
  const auto [header, data] = open_npy(bytes, where);
  const Column column = column_of({"values", header["descr"]}, where);
  NpyArray array;
  size_t count = 1;
  for (const json& side : header["shape"]) {
    const uint64_t length = side.is_number_unsigned() ? side.get<uint64_t>() : 0;
    if (length == 0 || length > data.size())
      throw input_error(where, "shape", "is " + header["shape"].dump(), "an array that is not empty is needed");
    if (length > data.size() / column.size / count) throw too_short(where, data.size(), length * count);
    array.shape.push_back(length);
    count *= length;
  }
  if (count > data.size() / column.size) throw too_short(where, data.size(), count);  // the one value without sides
  if (header.value("fortran_order", false) && array.shape.size() > 1)
    throw input_error(where, "fortran_order", "is True", "save numpy.ascontiguousarray of the array");
  array.values.reserve(count);
  for (size_t i = 0; i < count; ++i) array.values.push_back(value_at(column, data.data() + i * column.size));
  return array;
}

}  // namespace pliant

#pragma once

#include <cstdint>
#include <filesystem>
#include <istream>
#include <string>
#include <vector>

namespace pliant {

/// Scalar types of PLY.
enum class PlyType { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat, kDouble };

size_t ply_size(PlyType type);
/// The little-endian value at `bytes`.
double ply_value(PlyType type, const char* bytes);

/// The value of a color that stands for 1, where `largest` is the largest of the file: 255 of bytes and of other
/// integers, or 65535 where one is larger than 255; 1 of floats, or 255 where one is above 2, as no brightness is.
float ply_full_color(PlyType type, double largest);

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::kFloat;
  bool list = false;
  PlyType count_type = PlyType::kUint8;  ///< of the length of a list
};

struct PlyElement {
  std::string name;
  uint64_t count = 0;
  std::vector<PlyProperty> properties;

  bool has_list() const;
  size_t row_bytes() const;                     ///< of a binary row; only without lists
  int find(const std::string& property) const;  ///< index, -1 = absent
};

struct PlyHeader {
  bool ascii = false;
  std::vector<PlyElement> elements;
  std::vector<std::string> comments;

  const PlyElement* find(const std::string& element) const;
};

/// Reads the header and leaves `in` at the first byte of data.  Line ends may be LF or CRLF; the header must end
/// inside 128 KB.  Throws Error{kInput} naming `file` and the element or property.
PlyHeader read_ply_header(std::istream& in, const std::filesystem::path& file);

}  // namespace pliant

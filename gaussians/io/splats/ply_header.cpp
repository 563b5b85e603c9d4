#include "gaussians/io/splats/ply_header.h"

#include <charconv>
#include <cstring>
#include <map>
#include <sstream>

#include "gaussians/base/error.h"

namespace pliant {
namespace {

constexpr size_t kHeaderLimit = 128 * 1024;

template <class T>
double value_at(const char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  return static_cast<double>(value);
}

const std::map<std::string, PlyType>& type_names() {
  static const std::map<std::string, PlyType> names = {
      {"char", PlyType::kInt8},     {"int8", PlyType::kInt8},     {"uchar", PlyType::kUint8},
      {"uint8", PlyType::kUint8},   {"short", PlyType::kInt16},   {"int16", PlyType::kInt16},
      {"ushort", PlyType::kUint16}, {"uint16", PlyType::kUint16}, {"int", PlyType::kInt32},
      {"int32", PlyType::kInt32},   {"uint", PlyType::kUint32},   {"uint32", PlyType::kUint32},
      {"float", PlyType::kFloat},   {"float32", PlyType::kFloat}, {"double", PlyType::kDouble},
      {"float64", PlyType::kDouble}};
  return names;
}

/// Header lines of one file and the complaints about them.
class HeaderParser {
 public:
  HeaderParser(std::istream& in, const std::filesystem::path& file) : in_(in), file_(file.string()) {}

  PlyHeader parse() {
    if (next_line() != "ply") throw complain("", "does not begin with the line 'ply'", "give a PLY file");
    bool has_format = false;
    for (;;) {
      const std::string line = next_line();
      std::istringstream words(line);
      std::string keyword;
      words >> keyword;
      if (keyword == "end_header") break;
      if (keyword == "comment" || keyword == "obj_info") {
        header_.comments.push_back(line.substr(line.find(keyword) + keyword.size()));
      } else if (keyword == "format") {
        read_format(words);
        has_format = true;
      } else if (keyword == "element") {
        read_element(words);
      } else if (keyword == "property") {
        read_property(words);
      } else if (!keyword.empty()) {
        throw complain("header", "unknown line '" + line.substr(0, 60) + "'", "the file is damaged");
      }
    }
    if (!has_format) throw complain("format", "is missing in the header", "the file is damaged");
    return std::move(header_);
  }

 private:
  Error complain(const std::string& field, const std::string& problem, const std::string& remedy) const {
    return input_error(file_, field, problem, remedy);
  }

  std::string next_line() {
    std::string line;
    for (int c; (c = in_.get()) != std::istream::traits_type::eof();) {
      if (++read_ > kHeaderLimit) throw complain("header", "does not end inside 128 KB", "the file is damaged");
      if (c == '\n') {
        if (!line.empty() && line.back() == '\r') line.pop_back();
        return line;
      }
      line += static_cast<char>(c);
    }
    throw complain("header", read_ == 0 ? "the file is empty" : "ends before 'end_header'", "the file is truncated");
  }

  void read_format(std::istringstream& words) {
    std::string name;
    words >> name;
    if (name == "binary_big_endian") {
      throw complain("format", "binary_big_endian is not supported", "save the file as binary_little_endian");
    }
    if (name != "ascii" && name != "binary_little_endian") {
      throw complain("format", "is '" + name + "'", "use ascii or binary_little_endian");
    }
    header_.ascii = name == "ascii";
  }

  void read_element(std::istringstream& words) {
    PlyElement element;
    std::string count;
    words >> element.name >> count;
    const auto [end, failed] = std::from_chars(count.data(), count.data() + count.size(), element.count);
    if (count.empty() || failed != std::errc() || end != count.data() + count.size()) {
      throw complain("element " + element.name, "has the count '" + count + "'", "it must be an integer >= 0");
    }
    if (header_.find(element.name)) throw complain("element " + element.name, "occurs twice", "the file is damaged");
    header_.elements.push_back(std::move(element));
  }

  void read_property(std::istringstream& words) {
    PlyProperty property;
    std::string type, count_type;
    words >> type;
    if (type == "list") {
      property.list = true;
      words >> count_type >> type;
    }
    words >> property.name;
    if (header_.elements.empty() || property.name.empty()) {
      throw complain("property " + property.name, "has no element or no name", "the file is damaged");
    }
    PlyElement& element = header_.elements.back();
    const std::string field = "property " + property.name;
    property.type = type_of(field, type);
    if (property.list) {
      property.count_type = type_of(field, count_type);
      if (property.count_type == PlyType::kFloat || property.count_type == PlyType::kDouble) {
        throw complain(field, "has a list length of type " + count_type, "it must be an integer type");
      }
    }
    if (element.find(property.name) >= 0) throw complain(field, "occurs twice", "the file is damaged");
    element.properties.push_back(std::move(property));
  }

  PlyType type_of(const std::string& field, const std::string& name) const {
    const auto found = type_names().find(name);
    if (found == type_names().end())
      throw complain(field, "has the unknown type '" + name + "'", "the file is damaged");
    return found->second;
  }

  std::istream& in_;
  std::string file_;
  size_t read_ = 0;
  PlyHeader header_;
};

}  // namespace

size_t ply_size(PlyType type) {
  switch (type) {
    case PlyType::kInt8:
    case PlyType::kUint8:
      return 1;
    case PlyType::kInt16:
    case PlyType::kUint16:
      return 2;
    case PlyType::kDouble:
      return 8;
    default:
      return 4;
  }
}

double ply_value(PlyType type, const char* bytes) {
  switch (type) {
    case PlyType::kInt8:
      return value_at<int8_t>(bytes);
    case PlyType::kUint8:
      return value_at<uint8_t>(bytes);
    case PlyType::kInt16:
      return value_at<int16_t>(bytes);
    case PlyType::kUint16:
      return value_at<uint16_t>(bytes);
    case PlyType::kInt32:
      return value_at<int32_t>(bytes);
    case PlyType::kUint32:
      return value_at<uint32_t>(bytes);
    case PlyType::kFloat:
      return value_at<float>(bytes);
    case PlyType::kDouble:
      return value_at<double>(bytes);
  }
  return 0;
}

float ply_full_color(PlyType type, double largest) {
  if (type == PlyType::kFloat || type == PlyType::kDouble) return largest > 2 ? 255 : 1;
  return largest > 255 ? 65535 : 255;
}

bool PlyElement::has_list() const {
  for (const PlyProperty& property : properties) {
    if (property.list) return true;
  }
  return false;
}

size_t PlyElement::row_bytes() const {
  size_t bytes = 0;
  for (const PlyProperty& property : properties) bytes += ply_size(property.type);
  return bytes;
}

int PlyElement::find(const std::string& property) const {
  for (size_t i = 0; i < properties.size(); ++i) {
    if (properties[i].name == property) return static_cast<int>(i);
  }
  return -1;
}

const PlyElement* PlyHeader::find(const std::string& element) const {
  for (const PlyElement& candidate : elements) {
    if (candidate.name == element) return &candidate;
  }
  return nullptr;
}

PlyHeader read_ply_header(std::istream& in, const std::filesystem::path& file) {
  return HeaderParser(in, file).parse();
}

}  // namespace pliant

#include "gaussians/io/splats/ply_rows.h"

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <cstring>

namespace pliant {
namespace {

constexpr size_t kBlockRows = 4096;

}  // namespace

PlyRows::PlyRows(std::istream& in, const PlyHeader& header, const PlyElement& element, std::string file, uint64_t size)
    : in_(in), element_(element), file_(std::move(file)), ascii_(header.ascii), size_(size) {
  for (const PlyProperty& property : element.properties) {
    offset_.push_back(row_bytes_);
    row_bytes_ += ply_size(property.type);
  }
}

void PlyRows::check_size() {
  const uint64_t left = bytes_left();
  // In text a value takes a character and a separator; the last one may lack the separator.
  const uint64_t row = ascii_ ? 2 * element_.properties.size() : row_bytes_;
  const uint64_t available = ascii_ ? left + 1 : left;
  if (row > 0 && element_.count > available / row) {
    throw input_error(file_, "element " + element_.name,
                      "the header declares " + std::to_string(element_.count) + " rows but only " +
                          std::to_string(left) + " bytes follow (room for " + std::to_string(available / row) + ")",
                      "the file is truncated or its header is wrong");
  }
}

void PlyRows::skip() {
  if (!ascii_ && !element_.has_list()) {
    check_size();
    in_.seekg(static_cast<std::streamoff>(element_.count * row_bytes_), std::ios::cur);
    return;
  }
  if (element_.properties.empty()) return;
  for (uint64_t row = 0; row < element_.count; ++row) {
    for (const PlyProperty& property : element_.properties) {
      const double length = property.list ? read_scalar(property, property.count_type) : 1;
      if (!(length >= 0) || length > static_cast<double>(bytes_left())) throw truncated(property);
      if (ascii_) {
        for (double k = 0; k < length; ++k) read_scalar(property, property.type);
      } else {
        const auto bytes = static_cast<uint64_t>(length) * ply_size(property.type);
        if (bytes > bytes_left()) throw truncated(property);
        in_.seekg(static_cast<std::streamoff>(bytes), std::ios::cur);
      }
    }
  }
}

void PlyRows::for_each_row(const std::function<void(const float* values)>& use) {
  std::vector<float> values(element_.properties.size());
  std::vector<char> block;
  for (uint64_t row = 0; row < element_.count; ++row) {
    if (ascii_) {
      for (size_t i = 0; i < values.size(); ++i) {
        values[i] = static_cast<float>(read_scalar(element_.properties[i], element_.properties[i].type));
      }
    } else {
      if (row % kBlockRows == 0) {
        block.resize(std::min<uint64_t>(kBlockRows, element_.count - row) * row_bytes_);
        in_.read(block.data(), static_cast<std::streamsize>(block.size()));
        if (!in_) throw truncated(element_.properties.back());
      }
      const char* bytes = block.data() + (row % kBlockRows) * row_bytes_;
      for (size_t i = 0; i < values.size(); ++i) {
        if (element_.properties[i].type == PlyType::kFloat)
          std::memcpy(&values[i], bytes + offset_[i], 4);
        else
          values[i] = static_cast<float>(ply_value(element_.properties[i].type, bytes + offset_[i]));
      }
    }
    use(values.data());
  }
}

std::string PlyRows::bytes() {
  if (ascii_ || element_.has_list()) {
    throw input_error(file_, "element " + element_.name, "is ascii or holds lists", "packed data are binary");
  }
  check_size();
  std::string rows(element_.count * row_bytes_, '\0');
  in_.read(rows.data(), static_cast<std::streamsize>(rows.size()));
  if (!in_) throw input_error(file_, "element " + element_.name, "the data end early", "the file is truncated");
  return rows;
}

uint64_t PlyRows::bytes_left() {
  const std::streamoff at = in_.tellg();
  return at < 0 || static_cast<uint64_t>(at) > size_ ? 0 : size_ - static_cast<uint64_t>(at);
}

Error PlyRows::truncated(const PlyProperty& property) const {
  return input_error(file_, "property " + property.name, "the data of element " + element_.name + " end early",
                     "the file is truncated");
}

double PlyRows::read_scalar(const PlyProperty& property, PlyType type) {
  if (!ascii_) {
    char bytes[8];
    if (!in_.read(bytes, static_cast<std::streamsize>(ply_size(type)))) throw truncated(property);
    return ply_value(type, bytes);
  }
  if (!(in_ >> word_)) throw truncated(property);
  const char* begin = word_.data() + (word_[0] == '+' ? 1 : 0);
  double value = 0;
  const auto [end, failed] = std::from_chars(begin, word_.data() + word_.size(), value);
  if (end != word_.data() + word_.size() || (failed != std::errc() && failed != std::errc::result_out_of_range)) {
    throw input_error(file_, "property " + property.name, "has the value '" + word_.substr(0, 40) + "'",
                      "it must be a number");
  }
  // Out of range: infinite, or next to zero.
  return failed == std::errc() ? value : std::strtod(begin, nullptr);
}

}  // namespace pliant

#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

#include "gaussians/base/error.h"

namespace pliant {

static_assert(std::endian::native == std::endian::little, "binary formats are read as they lie in memory");

/// Cursor over the bytes of a little-endian file; what is missing is an Error{kInput} that names file and field.
class ByteReader {
 public:
  ByteReader(std::string_view bytes, std::string file) : bytes_(bytes), file_(std::move(file)) {}

  template <class T>
  T take(const std::string& field) {
    T value;
    std::memcpy(&value, take_bytes(sizeof value, field).data(), sizeof value);
    return value;
  }

  std::string_view take_bytes(uint64_t count, const std::string& field) {
    if (count > left()) throw input_error(file_, field, "the file ends inside it", "the file is truncated");
    const std::string_view taken = bytes_.substr(at_, count);
    at_ += count;
    return taken;
  }

  /// Text up to the next zero byte, which is passed over.
  std::string_view take_text(const std::string& field) {
    const size_t end = bytes_.find('\0', at_);
    if (end == std::string_view::npos)
      throw input_error(file_, field, "the file ends inside it", "the file is truncated");
    const std::string_view taken = bytes_.substr(at_, end - at_);
    at_ = end + 1;
    return taken;
  }

  /// Compares a promised count with the bytes that are left, before anything is allocated for it.
  void expect(uint64_t count, uint64_t bytes_each, const std::string& field) const {
    if (count <= left() / bytes_each) return;
    throw input_error(file_, field,
                      "is " + std::to_string(count) + " but only " + std::to_string(left()) +
                          " bytes follow (room for " + std::to_string(left() / bytes_each) + ")",
                      "the file is truncated or its header is wrong");
  }

  uint64_t left() const { return bytes_.size() - at_; }
  const std::string& file() const { return file_; }

 private:
  std::string_view bytes_;
  std::string file_;
  uint64_t at_ = 0;
};

}  // namespace pliant

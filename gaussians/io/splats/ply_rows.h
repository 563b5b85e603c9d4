#pragma once

#include <cstdint>
#include <functional>
#include <istream>
#include <string>
#include <vector>

#include "gaussians/base/error.h"
#include "gaussians/io/splats/ply_header.h"

namespace pliant {

/// Reads the rows of one element as floats, ascii or binary.  `size` is that of the whole file.
class PlyRows {
 public:
  PlyRows(std::istream& in, const PlyHeader& header, const PlyElement& element, std::string file, uint64_t size);

  /// Compares the promised rows with the bytes that are left, before anything is allocated.
  void check_size();
  /// Passes over the whole element, which may hold lists.
  void skip();
  /// Calls use(values, one for each property) for every row.
  void for_each_row(const std::function<void(const float* values)>& use);
  /// All rows as they lie in a binary file.
  std::string bytes();

 private:
  uint64_t bytes_left();
  Error truncated(const PlyProperty& property) const;
  double read_scalar(const PlyProperty& property, PlyType type);

  std::istream& in_;
  const PlyElement& element_;
  std::string file_, word_;
  bool ascii_;
  uint64_t size_;
  size_t row_bytes_ = 0;
  std::vector<size_t> offset_;
};

}  // namespace pliant

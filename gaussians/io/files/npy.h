#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace pliant {

/// The columns of a structured one-dimensional NumPy array (format 1 or 2, little-endian floats and integers), by name.
/// Throws Error{kInput} naming `where`.
std::map<std::string, std::vector<double>> read_npy_columns(std::string_view bytes, const std::string& where);

/// The bytes of such an array of 32-bit floats; columns of one length, in this order.
std::string npy_of_columns(const std::vector<std::pair<std::string, std::vector<float>>>& columns);

/// An array of numbers, in C order.
struct NpyArray {
  std::vector<size_t> shape;
  std::vector<double> values;
};
/// An array of little-endian floats or integers, stored in C order (format 1 to 3).  Throws Error{kInput} naming
/// `where`.
NpyArray read_npy_array(std::string_view bytes, const std::string& where);

}  // namespace pliant

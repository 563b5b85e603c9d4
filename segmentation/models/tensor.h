#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace pliant {

/// A dense array that goes into a network or comes out of it, row-major.
struct Tensor {
  enum class Type : uint8_t { kFloat32, kInt64, kBool, kFloat16, kFloat64, kInt32, kOther };

  Type type = Type::kFloat32;
  std::vector<int64_t> shape;
  std::vector<float> values;      ///< of kFloat32
  std::vector<int64_t> integers;  ///< of kInt64 and kBool; other types carry no data

  static Tensor floats(std::vector<int64_t> shape, float value = 0);
  static Tensor floats(std::vector<int64_t> shape, std::vector<float> values);
  static Tensor whole(std::vector<int64_t> shape, std::vector<int64_t> integers, Type type = Type::kInt64);

  /// Product of the shape.
  int64_t count() const;
};

const char* name_of(Tensor::Type type);                     ///< float32, int64, ...
std::string shape_text(const std::vector<int64_t>& shape);  ///< [1,3,416,416]

}  // namespace pliant

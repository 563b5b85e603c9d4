#include "segmentation/models/tensor.h"

#include "gaussians/base/error.h"

namespace pliant {

Tensor Tensor::floats(std::vector<int64_t> shape, float value) {
  Tensor tensor;
  tensor.shape = std::move(shape);
  tensor.values.assign(tensor.count(), value);
  return tensor;
}

Tensor Tensor::floats(std::vector<int64_t> shape, std::vector<float> values) {
  Tensor tensor;
  tensor.shape = std::move(shape);
  tensor.values = std::move(values);
  CHECK(tensor.count() == static_cast<int64_t>(tensor.values.size()));
  return tensor;
}

Tensor Tensor::whole(std::vector<int64_t> shape, std::vector<int64_t> integers, Type type) {
  Tensor tensor;
  tensor.type = type;
  tensor.shape = std::move(shape);
  tensor.integers = std::move(integers);
  CHECK(tensor.count() == static_cast<int64_t>(tensor.integers.size()));
  return tensor;
}

int64_t Tensor::count() const {
  int64_t product = 1;
  for (const int64_t length : shape) product *= length;
  return product;
}

const char* name_of(Tensor::Type type) {
  static const char* const names[] = {"float32", "int64", "bool", "float16", "float64", "int32", "another type"};
  return names[static_cast<int>(type)];
}

std::string shape_text(const std::vector<int64_t>& shape) {
  std::string text = "[";
  for (const int64_t length : shape) text.append(text.size() > 1 ? "," : "").append(std::to_string(length));
  return text + "]";
}

}  // namespace pliant

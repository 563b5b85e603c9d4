#include "fitting/fields/part_field.h"

#include <algorithm>

#include "gaussians/base/error.h"

namespace pliant {

PartField::PartField(std::vector<uint32_t> part, int channels) : part_(std::move(part)), channels_(channels) {
  for (const uint32_t p : part_) parts_ = std::max<size_t>(parts_, p + 1);
}

std::vector<double> PartField::constant(std::span<const double> value) const {
  CHECK(value.size() == static_cast<size_t>(channels_));
  std::vector<double> parameters;
  for (size_t p = 0; p < parts_; ++p) parameters.insert(parameters.end(), value.begin(), value.end());
  return parameters;
}

std::vector<double> PartField::values(std::span<const double> parameters) const {
  CHECK(parameters.size() == parts_ * channels_);
  std::vector<double> values(part_.size() * channels_);
  for (size_t i = 0; i < part_.size(); ++i)
    for (int c = 0; c < channels_; ++c) values[i * channels_ + c] = parameters[part_[i] * channels_ + c];
  return values;
}

std::vector<double> PartField::values_adjoint(std::span<const double> parameters,
                                              std::span<const double> adj_values) const {
  CHECK(parameters.size() == parts_ * channels_ && adj_values.size() == part_.size() * channels_);
  std::vector<double> adj(parameters.size(), 0.0);
  for (size_t i = 0; i < part_.size(); ++i)
    for (int c = 0; c < channels_; ++c) adj[part_[i] * channels_ + c] += adj_values[i * channels_ + c];
  return adj;
}

}  // namespace pliant

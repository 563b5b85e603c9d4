#include "fitting/fields/axes_field.h"

#include "gaussians/base/error.h"

namespace pliant {
namespace {

std::span<const double> of_axis(std::span<const double> parameters, int axis) {
  const size_t each = parameters.size() / 3;
  return parameters.subspan(axis * each, each);
}

}  // namespace

AxesField::AxesField(std::shared_ptr<const Field> field) : field_(std::move(field)) { CHECK(field_->channels() == 1); }

std::vector<double> AxesField::constant(std::span<const double> value) const {
  CHECK(value.size() == 3);
  std::vector<double> parameters;
  for (int axis = 0; axis < 3; ++axis) {
    const std::vector<double> one = field_->constant(value.subspan(axis, 1));
    parameters.insert(parameters.end(), one.begin(), one.end());
  }
  return parameters;
}

std::vector<double> AxesField::values(std::span<const double> parameters) const {
  std::vector<double> out(3 * points());
  for (int axis = 0; axis < 3; ++axis) {
    const std::vector<double> one = field_->values(of_axis(parameters, axis));
    for (size_t i = 0; i < one.size(); ++i) out[3 * i + axis] = one[i];
  }
  return out;
}

std::vector<double> AxesField::values_adjoint(std::span<const double> parameters,
                                              std::span<const double> adj_values) const {
  CHECK(adj_values.size() == 3 * points());
  std::vector<double> adj;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> one(points());
    for (size_t i = 0; i < one.size(); ++i) one[i] = adj_values[3 * i + axis];
    const std::vector<double> part = field_->values_adjoint(of_axis(parameters, axis), one);
    adj.insert(adj.end(), part.begin(), part.end());
  }
  return adj;
}

}  // namespace pliant

#include "fitting/fields/weighted_field.h"

#include <algorithm>

#include "gaussians/base/error.h"

namespace pliant {

WeightedField::WeightedField(std::shared_ptr<const Field> field, std::vector<double> weight)
    : field_(std::move(field)), weight_(std::move(weight)) {
  CHECK(weight_.size() == field_->points());
  CHECK(std::any_of(weight_.begin(), weight_.end(), [](double w) { return w != 0; }));
}

std::vector<double> WeightedField::weighted(std::vector<double> values) const {
  const size_t channels = static_cast<size_t>(field_->channels());
  for (size_t i = 0; i < values.size(); ++i) values[i] *= weight_[i / channels];
  return values;
}

std::vector<double> WeightedField::constant(std::span<const double> value) const {
  const double largest =
      *std::max_element(weight_.begin(), weight_.end(), [](double a, double b) { return std::abs(a) < std::abs(b); });
  std::vector<double> inner(value.begin(), value.end());
  for (double& v : inner) v /= largest;
  return field_->constant(inner);
}

std::vector<double> WeightedField::values(std::span<const double> parameters) const {
  return weighted(field_->values(parameters));
}

std::vector<double> WeightedField::values_adjoint(std::span<const double> parameters,
                                                  std::span<const double> adj_values) const {
  return field_->values_adjoint(parameters, weighted({adj_values.begin(), adj_values.end()}));
}

std::vector<double> free_particles(const Particles& particles, const std::vector<Interaction>& interactions) {
  std::vector<double> free(particles.size(), 1.0);
  for (const Interaction& it : interactions)
    if (it.type == InteractionType::kPin && it.start <= 0 && std::isinf(it.end()))
      for (size_t i = 0; i < free.size(); ++i)
        if (it.region.contains(particles.position[i].cast<double>())) free[i] = 0;
  return free;
}

}  // namespace pliant

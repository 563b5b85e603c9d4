#pragma once

#include <memory>

#include "fitting/fields/field.h"

namespace pliant {

/// Three channels from a field of one: its parameters once for each axis, one after the other.
class AxesField : public Field {
 public:
  explicit AxesField(std::shared_ptr<const Field> field);

  size_t points() const override { return field_->points(); }
  int channels() const override { return 3; }
  std::vector<double> constant(std::span<const double> value) const override;
  std::vector<double> values(std::span<const double> parameters) const override;
  std::vector<double> values_adjoint(std::span<const double> parameters,
                                     std::span<const double> adj_values) const override;

 private:
  std::shared_ptr<const Field> field_;
};

}  // namespace pliant

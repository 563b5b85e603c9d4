#pragma once

#include <span>
#include <vector>

namespace pliant {

/// Values at fixed points as a function of parameters: one channel for log E [ln Pa], three for a velocity [m/s].  The
/// same optimiser drives every kind.
class Field {
 public:
  virtual ~Field() = default;
  virtual size_t points() const = 0;
  virtual int channels() const = 0;
  /// [P] parameters under which the field has `value` [channels] everywhere, as nearly as it can.
  virtual std::vector<double> constant(std::span<const double> value) const = 0;
  /// [points, channels]
  virtual std::vector<double> values(std::span<const double> parameters) const = 0;
  /// dL/dparameters [P] from dL/dvalues [points, channels].
  virtual std::vector<double> values_adjoint(std::span<const double> parameters,
                                             std::span<const double> adj_values) const = 0;
  /// What the loss gets for roughness; adds its derivatives times `weight` to `gradient` [P] unless that is empty.
  virtual double roughness(std::span<const double> parameters, double weight, std::span<double> gradient) const {
    return (void)parameters, (void)weight, (void)gradient, 0.0;
  }
};

}  // namespace pliant

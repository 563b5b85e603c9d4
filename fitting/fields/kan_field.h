#pragma once

#include <cmath>
#include <cstdint>

#include "fitting/fields/field.h"
#include "gaussians/base/types.h"

namespace pliant {

struct KanFieldOptions {
  int hidden = 16;          ///< sums between the two layers
  double bound = INFINITY;  ///< that the values approach smoothly, either way
  uint64_t seed = 0;
};

/// Kolmogorov-Arnold network (Liu et al. 2024) from a place in the box of the points to one channel, DreamPhysics' kind
/// of material field (Huang et al. 2025): two layers, in which a function of one variable stands on every edge and
/// nodes add up.  A function is w silu(x) plus a cubic spline of eight coefficients on [-1, 1], which falls to nothing
/// outside.  Parameters: w and coefficients of every edge of the first layer, [hidden, 3, 9], and of the second,
/// [hidden, 9]; then a constant that is added.  The second layer starts as nothing, so that the field is constant at
/// first.
class KanField : public Field {
 public:
  /// Throws Error{kUsage} for impossible options or no points.
  KanField(const KanFieldOptions& options, std::span<const Vec3f> points);

  size_t points() const override { return place_.size(); }
  int channels() const override { return 1; }
  size_t parameters() const;
  std::vector<double> constant(std::span<const double> value) const override;
  std::vector<double> values(std::span<const double> parameters) const override;
  std::vector<double> values_adjoint(std::span<const double> parameters,
                                     std::span<const double> adj_values) const override;

 private:
  KanFieldOptions options_;
  std::vector<Vec3d> place_;  // in [-1, 1]
};

}  // namespace pliant

#pragma once

#include <cstdint>

#include "fitting/fields/field.h"

namespace pliant {

/// One value for each part of a body: few unknowns, robust.  With one part, the homogeneous field.
class PartField : public Field {
 public:
  /// `part` [points], numbered from 0 without gaps; a part without points keeps whatever it is given.
  PartField(std::vector<uint32_t> part, int channels);
  /// One part.
  PartField(size_t points, int channels) : PartField(std::vector<uint32_t>(points, 0), channels) {}

  size_t points() const override { return part_.size(); }
  int channels() const override { return channels_; }
  size_t parts() const { return parts_; }
  std::vector<double> constant(std::span<const double> value) const override;
  std::vector<double> values(std::span<const double> parameters) const override;
  std::vector<double> values_adjoint(std::span<const double> parameters,
                                     std::span<const double> adj_values) const override;

 private:
  std::vector<uint32_t> part_;
  int channels_ = 1;
  size_t parts_ = 1;
};

}  // namespace pliant

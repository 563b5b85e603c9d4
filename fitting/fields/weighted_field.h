#pragma once

#include <memory>

#include "fitting/fields/field.h"
#include "physics/mpm/particles.h"
#include "physics/simulate/interaction.h"

namespace pliant {

/// A field times a weight at each point: 0 leaves the point as it is, another changes the unit.
class WeightedField : public Field {
 public:
  /// `weight` [points], not all 0.
  WeightedField(std::shared_ptr<const Field> field, std::vector<double> weight);

  size_t points() const override { return weight_.size(); }
  int channels() const override { return field_->channels(); }
  /// Where the weight is largest.
  std::vector<double> constant(std::span<const double> value) const override;
  std::vector<double> values(std::span<const double> parameters) const override;
  std::vector<double> values_adjoint(std::span<const double> parameters,
                                     std::span<const double> adj_values) const override;
  double roughness(std::span<const double> parameters, double weight, std::span<double> gradient) const override {
    return field_->roughness(parameters, weight, gradient);
  }

 private:
  /// [points, channels] times the weights.
  std::vector<double> weighted(std::vector<double> values) const;

  std::shared_ptr<const Field> field_;
  std::vector<double> weight_;
};

/// [N] 0 for particles inside a region that is pinned from the start on for good, 1 for all others (PhysDreamer's
/// frozen ones).
std::vector<double> free_particles(const Particles& particles, const std::vector<Interaction>& interactions);

}  // namespace pliant

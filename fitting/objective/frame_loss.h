#pragma once

#include <span>

#include "physics/mpm/adjoint/step_adjoint.h"
#include "physics/mpm/particles.h"

namespace pliant {

/// One term of an objective over the frames of a roll-out.
template <class T>
class FrameLoss {
 public:
  virtual ~FrameLoss() = default;
  /// What frame `frame` of the roll-out (0 = its start) adds to the loss; 0 where nothing is known of it.
  virtual double value(int frame, const BasicSimulationState<T>& state) const = 0;
  /// The same; adds its derivatives times `adj_value` to `gradient`.
  virtual double value_adjoint(int frame, const BasicSimulationState<T>& state, double adj_value,
                               StateGradient<T>& gradient) const = 0;
};

/// One that looks at all frames of a roll-out together.
template <class T>
class RolloutLoss {
 public:
  virtual ~RolloutLoss() = default;
  virtual double value(std::span<const BasicSimulationState<T>> frames) const = 0;
  /// The same; adds its derivatives times `adj_value` to `gradient` [frames].
  virtual double value_adjoint(std::span<const BasicSimulationState<T>> frames, double adj_value,
                               std::span<StateGradient<T>> gradient) const = 0;
};

}  // namespace pliant

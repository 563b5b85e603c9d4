#pragma once

#include <memory>

#include "fitting/objective/frame_loss.h"
#include "physics/simulate/rollout.h"

namespace pliant {

/// A body, how it starts and what acts on it: everything that a roll-out needs.
template <class T>
struct Motion {
  BasicParticles<T> particles;
  BasicSimulationState<T> start;
  std::vector<Interaction> interactions;
  RolloutOptions options;
};

/// Terms of an objective, each with its weight.
template <class T>
struct Objective {
  struct Term {
    double weight = 1;
    std::shared_ptr<const FrameLoss<T>> loss;
  };
  struct WholeTerm {
    double weight = 1;
    std::shared_ptr<const RolloutLoss<T>> loss;
  };
  std::vector<Term> terms;
  std::vector<WholeTerm> whole;  ///< of all frames together

  double of(const Rollout<T>& rollout) const;
};

template <class T>
struct MotionGradient {
  double loss = 0;
  RolloutGradient<T> by;
  double rollout_seconds = 0, frames_seconds = 0, reverse_seconds = 0;  ///< wall time: forward, terms, backward
};

/// The loss of a motion; and with its derivatives by all that the roll-out starts from.
template <class T>
double motion_loss(const Motion<T>& motion, const Objective<T>& objective);
template <class T>
MotionGradient<T> motion_loss_adjoint(const Motion<T>& motion, const Objective<T>& objective);

}  // namespace pliant

#pragma once

#include <memory>

#include "fitting/objective/drawn_object.h"
#include "fitting/objective/frame_loss.h"
#include "fitting/observe/guidance.h"

namespace pliant {

/// What another program thinks of a drawn motion (guidance.h), as in score distillation: it sees frame `lead` of the
/// roll-out, every `every`-th after it, clamped to [0, 1], and says in which direction each of their colours should
/// change.
/// `against_still` subtracts what it thinks of the first of these frames held, asked as the same step, so that looks
/// and noise cancel and motion stays (DreamPhysics, Huang et al. 2025, motion distillation).
class GuidanceLoss : public RolloutLoss<float> {
 public:
  struct Frames {
    int lead = 0, every = 1;
    double fps = 24;  ///< of those that it sees
    bool against_still = false;
  };
  GuidanceLoss(std::shared_ptr<Guidance> guide, std::shared_ptr<const DrawnObject<float>> object, Camera camera,
               Frames frames)
      : guide_(std::move(guide)), object_(std::move(object)), camera_(std::move(camera)), frames_(frames) {}

  double value(std::span<const SimulationState> frames) const override;
  double value_adjoint(std::span<const SimulationState> frames, double adj_value,
                       std::span<StateGradient<float>> gradient) const override;

 private:
  GuidanceResult ask(std::span<const SimulationState> frames) const;

  std::shared_ptr<Guidance> guide_;
  std::shared_ptr<const DrawnObject<float>> object_;
  Camera camera_;
  Frames frames_;
};

}  // namespace pliant

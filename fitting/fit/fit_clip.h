#pragma once

#include <memory>
#include <string>

#include "fitting/fit/fit_gradient.h"

namespace pliant {

/// What gradients vary, and how.
struct ClipFitOptions {
  std::shared_ptr<const Field> material, velocity, poisson, density;  ///< see GradientFitFields; null = stays
  bool damping = true;                                                ///< where the motion has any
  bool keep_mass = true;
  std::optional<AddedYoung> added_young;
  GradientFitOptions gradient;

  GradientFitFields fields() const {
    return {material.get(), velocity.get(), damping, poisson.get(), added_young, density.get(), keep_mass};
  }
};

struct ClipFit {
  Motion<float> motion;  ///< with what was found
  std::vector<GradientFitRow> iterations;
  std::string stopped_by;  ///< "no better loss" or "iterations"
  double seconds = 0;
};

/// fit_gradient from fields that change nothing, or from an earlier state on.  Throws Error{kInterrupted} when `keep`
/// says false.
ClipFit fit_clip(const ClipFitOptions& options, const Motion<float>& motion, const Objective<float>& objective,
                 GradientFitState state, const std::function<void(const std::string&)>& progress = {},
                 const GradientFitSink& keep = {});

}  // namespace pliant

#pragma once

#include "app/fit/fit_scene.h"
#include "fitting/fit/fit_material.h"

namespace pliant {

/// What the roll-outs of every fit share with `simulate`, which replays them: the solver, and the friction of touching
/// parts.
SimulateOptions rollout_options(const FitStage& stage);

/// What a stage asks of the fit of `fit`, to its videos or, without any, to a guiding program, whose first step is
/// `first_step`.
MaterialFitOptions material_fit_options(const Context& context, const RunDirectory& run, const Scene& scene,
                                        const FitStage& stage, const FitScene& fit, int first_step);

/// Of the first parameters of networks: 0, that of their fields, where the program's is its default.
uint64_t network_seed(const Context& context);

/// Starts the program of stage.compare.guide, which talks through fit/guide/.
std::shared_ptr<Guidance> start_guide(const Context& context, const RunDirectory& run, const CompareStage& stage,
                                      int first_step);

}  // namespace pliant

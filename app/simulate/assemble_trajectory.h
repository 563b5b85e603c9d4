#pragma once

#include "app/simulate/frame_store.h"
#include "app/simulate/simulated_body.h"
#include "app/store/trajectory.h"

namespace pliant {

/// The frames from 0 to below `count` in the scene's units and axes, with the deformation that Gaussians follow.  It is
/// that from the captured shape, also where a solved rest shape is `loaded`; `start` is the motion's, before gravity.
TrajectoryFile assemble_trajectory(const FrameStore& frames, int count, const SimulatedBody& body,
                                   const SimulationState& start, bool loaded);

}  // namespace pliant

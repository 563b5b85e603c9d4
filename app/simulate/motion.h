#pragma once

#include <nlohmann/json_fwd.hpp>

#include "app/store/particles.h"
#include "app/store/trajectory.h"

namespace pliant {

/// How the tip (mean of the highest tenth along `up`) moved, as shares of `height` [scene units]: tip_peak, tip_end,
/// tip_drift_before (largest displacement in the first `quiet` seconds), and the largest motion of any particle.
nlohmann::json describe_motion(const TrajectoryFile& trajectory, const ParticleFile& particles, const Vec3d& up,
                               double height, double quiet = 0.25);

}  // namespace pliant

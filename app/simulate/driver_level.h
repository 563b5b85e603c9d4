#pragma once

#include <optional>
#include <vector>

#include "app/simulate/moving_scene.h"

namespace pliant {

/// Driving particles at one instant, scene units.
struct DriverFrame {
  std::vector<Vec3f> position;  ///< [M, 3]
  std::vector<Mat3f> F;         ///< [M]
};

/// The same object with about `count` driving particles, clustered anew from its solid samples; the file itself where
/// it has no more.
ParticleFile with_drivers(const ParticleFile& file, const Scene& scene, int count);

/// The driving particles of `level` to those of `file`, of which with_drivers made it: each follows only what hangs
/// together with its own samples.
Binding bind_level(const ParticleFile& file, const ParticleFile& level);

/// What the simulated particles do to those of another clustering, each carried by those that bind_level gives it.
std::vector<DriverFrame> motion_of(const MovingScene& moving, const ParticleFile& level);

/// What they remember in the first frame, likewise.
std::optional<TrajectoryFile::Memory> memory_of(const MovingScene& moving, const ParticleFile& level);

}  // namespace pliant

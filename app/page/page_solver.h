#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "app/page/clip_budget.h"
#include "app/simulate/session_body.h"

namespace pliant {

/// A body of fewer driving particles, for devices that cannot move those of the motion in real time.
struct SolverLevel {
  int clustered_to = 0;  ///< number of driving particles that with_drivers was asked for
  ParticleFile file;
  Binding binding;                               ///< of the object's Gaussians
  std::optional<TrajectoryFile::Memory> memory;  ///< in the motion's first frame, see memory_of
};

/// Those that a page offers; none where the object cannot be played with.
std::vector<SolverLevel> solver_levels(const SessionSetup& setup, const Scene& scene, const MovingScene& moving);

/// Of these, at most so many that a page has beside `motion_level`, the coarsest.
std::span<const SolverLevel> levels_beside(const ParticleFile& motion_level, std::span<const SolverLevel> levels,
                                           size_t most = SIZE_MAX);

/// Bytes that add_solver takes in the file; `packer` has its sections then.
size_t solver_bytes(const SolverLevel& motion_level, const SessionSetup& setup, const Scene& scene,
                    std::span<const SolverLevel> levels, SectionPacker& packer);

/// Appends what the page's solver needs: the sections `levels` and `solver`, and what the header says of them.  Where
/// the object cannot be played with, the header says why.  Of `motion_level` the file and the memory count.  The arrays
/// level{l}.from.driver and .weight bind the drivers of the other levels to its own (see bind_level).
void add_solver(ClipFile& file, const SolverLevel& motion_level, const SessionSetup& setup, const Scene& scene,
                std::span<const SolverLevel> levels);

}  // namespace pliant

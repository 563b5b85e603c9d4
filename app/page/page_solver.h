#pragma once

#include <vector>

#include "app/page/clip_budget.h"
#include "app/simulate/session_body.h"

namespace pliant {

/// A body of fewer driving particles, for devices that cannot move those of the motion in real time.
struct SolverLevel {
  int clustered_to = 0;  ///< number of driving particles that with_drivers was asked for
  ParticleFile file;
  Binding binding;  ///< of the object's Gaussians
};

/// Those that a page offers; none where the object cannot be played with.
std::vector<SolverLevel> solver_levels(const SessionSetup& setup, const Scene& scene, const MovingScene& moving);

/// Bytes that add_solver takes at most in the file; `packer` has its sections then.
size_t solver_bytes(const SessionSetup& setup, const Scene& scene, const MovingScene& moving,
                    const std::vector<SolverLevel>& levels, SectionPacker& packer);

/// Appends what the page's solver needs: the sections `levels` and `solver`, and what the header says of them.  Where
/// the object cannot be played with, the header says why.
void add_solver(ClipFile& file, const ParticleFile& motion_level, const SessionSetup& setup, const Scene& scene,
                const std::vector<SolverLevel>& levels);

}  // namespace pliant

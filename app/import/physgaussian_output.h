#pragma once

#include <filesystem>

#include "app/import/physgaussian_space.h"
#include "app/store/trajectory.h"

namespace pliant {

/// What PhysGaussian writes with --output_h5 and --output_ply, from a finished trajectory:
/// simulation_ply/sim_0000000000.h5 ... with x (3, N), time (1, 1), f_tensor (9, N), v (3, N), C (9, N), and .ply of
/// the same numbers with x y z; all in simulation space.  C is not part of a trajectory and is its finite difference
/// (dF/dt) F^-1.
struct PhysGaussianOutput {
  bool h5 = true, ply = true;
};
void write_physgaussian_output(const std::filesystem::path& folder, const PhysGaussianOutput& what,
                               const TrajectoryFile& trajectory, const SimulationSpace& space);

/// Removes such files, .h5 and .ply, of frame `first` and those behind it, which a longer motion left.
void remove_physgaussian_frames(const std::filesystem::path& folder, size_t first);

}  // namespace pliant

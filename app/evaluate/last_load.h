#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>

#include "app/store/trajectory.h"

namespace pliant {

/// Frames that a fit of an oscillation needs.
constexpr size_t kLeastFree = 8;

/// When the loads on the object of a trajectory.h5 change last before `until` [s]: the latest begin or end in the
/// interactions.json beside it, or in its run directory when `simulate` wrote both.  What lasts longer, such as the
/// ground or a steady force, counts by its begin, but `until` when it moves along a path until then.  Empty when there
/// is no such file, or it is of a run with a configuration of PhysGaussian.
std::optional<double> last_load_change(const std::filesystem::path& trajectory, double until);

/// From when on nothing pushes what a trajectory.h5 holds, s from its first frame: last_load_change before `until` [s],
/// where it is known and leaves kLeastFree frames before `until`.
std::optional<double> release_of(const std::filesystem::path& file, const TrajectoryFile& trajectory, double until);

}  // namespace pliant

#pragma once

#include <filesystem>
#include <optional>

namespace pliant {

/// When the loads on the object of a trajectory.h5 change last before `until` [s]: the latest begin or end in the
/// interactions.json beside it, or in its run directory when `simulate` wrote both.  What lasts longer, such as the
/// ground or a steady force, counts by its begin, but `until` when it moves along a path until then.  Empty when there
/// is no such file.
std::optional<double> last_load_change(const std::filesystem::path& trajectory, double until);

}  // namespace pliant

#pragma once

#include <filesystem>

#include "physics/mpm/particles.h"

namespace pliant {

/// One frame of a running simulation as `folder`/NNNN.bin: everything from which it continues bit for bit.  Written
/// under a temporary name with a checksum, so a frame is whole or absent.
void write_frame(const std::filesystem::path& folder, const SimulationState& state);
/// Throws Error{kInput} when the frame is missing, truncated or changed.
SimulationState read_frame(const std::filesystem::path& folder, int frame);
/// The largest n for which the frames 0 to n are all whole; -1 = none.
int last_frame(const std::filesystem::path& folder);

}  // namespace pliant

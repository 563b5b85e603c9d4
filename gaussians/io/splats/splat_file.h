#pragma once

#include <filesystem>

#include "gaussians/base/gaussian_cloud.h"
#include "gaussians/io/splats/read_report.h"

namespace pliant {

/// Reads a .splat file: rows of 32 bytes without a header, each a position (3 floats), standard deviations (3 floats),
/// colour and opacity (4 bytes) and a quaternion w, x, y, z (4 bytes, 128 = 0).  Throws Error{kInput} naming the file.
GaussianCloud read_splat(const std::filesystem::path& file, ReadReport* report = nullptr);

/// Writes the same, atomically.  The format has no harmonics; colours are clamped to [0, 1].
void write_splat(const std::filesystem::path& file, const GaussianCloud& cloud);

}  // namespace pliant

#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "gaussians/base/gaussian_cloud.h"

namespace pliant {

/// What was met while reading a splat file, in sentences for the user.
struct ReadReport {
  std::string format;                 ///< for example "3DGS PLY, SH degree 3"
  size_t rows = 0;                    ///< records in the file
  size_t dropped = 0;                 ///< rows with NaN or infinite values that were left out
  bool antialiased = false;           ///< the file says that it was trained with mip-splatting
  std::vector<std::string> warnings;
};

/// Reads a 3DGS PLY by property name (INRIA order and dialects: extra properties and elements, float/double/uchar
/// types, missing normals, any SH degree 0..3, ascii or binary little endian, 2DGS without scale_2).
/// Throws Error{kInput} naming the file and the property.
GaussianCloud read_ply(const std::filesystem::path& file, ReadReport* report = nullptr);

/// Writes the canonical INRIA layout (binary little endian, f_rest channel-major), atomically.  `antialiased` adds the
/// comment by which mip-splatting scenes are recognised.
void write_ply(const std::filesystem::path& file, const GaussianCloud& cloud, bool antialiased = false);

}  // namespace pliant

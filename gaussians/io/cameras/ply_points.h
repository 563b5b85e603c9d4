#pragma once

#include "gaussians/io/cameras/sparse_points.h"

namespace pliant {

/// x, y, z and, when there are such properties, red, green, blue (see ply_full_color) of the vertices of a PLY.  Those
/// whose position is not finite are left out with a warning.  Throws Error{kInput} naming file and property.
SparsePoints read_ply_points(const std::filesystem::path& file);

/// Writes x, y, z and red, green, blue in bytes, binary little endian, atomically.
void write_ply_points(const std::filesystem::path& file, const SparsePoints& points);

}  // namespace pliant

#pragma once

#include <filesystem>

#include "gaussians/base/gaussian_cloud.h"
#include "gaussians/io/splats/read_report.h"

namespace pliant {

/// Reads a 3DGS PLY by property name (INRIA order and dialects: extra properties and elements, float/double/uchar
/// types, missing normals, any SH degree 0..3, ascii or binary little endian, 2DGS without scale_2), Gaussian
/// Grouping's obj_dc_*, the 3D filter of Mip-Splatting, or a compressed PLY (compressed_ply.h). Throws Error{kInput}
/// naming the file and the property.
GaussianCloud read_ply(const std::filesystem::path& file, ReadReport* report = nullptr);

/// Whether a file is a PLY of points or of a mesh, such as nerfstudio's sparse_pc.ply, not of Gaussians.  Throws
/// Error{kInput} for a damaged header.
bool is_point_cloud(const std::filesystem::path& file);

/// Writes the canonical INRIA layout (binary little endian, f_rest channel-major), atomically.  `antialiased` adds the
/// comment by which mip-splatting scenes are recognised, `z_is_up` that of nerfstudio.
void write_ply(const std::filesystem::path& file, const GaussianCloud& cloud, bool antialiased = false,
               bool z_is_up = false);

}  // namespace pliant

#pragma once

#include <filesystem>

#include "gaussians/base/gaussian_cloud.h"

namespace pliant {

/// Writes binary glTF 2.0 with KHR_gaussian_splatting (Khronos), atomically: a mesh of points with
/// position, rotation (x, y, z, w), scale (linear), opacity and harmonics as 32-bit floats, and COLOR_0 for readers
/// without the extension.  The axes of 3DGS PLY (x right, y down, z forward), or those of a cloud whose `z_is_up`, are
/// turned to those of glTF (y up). Throws Error{kInput} for more than 4 GiB.
void write_glb(const std::filesystem::path& file, const GaussianCloud& cloud, bool z_is_up = false);

}  // namespace pliant

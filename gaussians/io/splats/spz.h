#pragma once

#include <filesystem>

#include "gaussians/base/gaussian_cloud.h"
#include "gaussians/io/splats/read_report.h"

namespace pliant {

/// Reads .spz of Niantic, versions 1 to 3 (one gzip stream, or the same without gzip) and 4 (Zstandard streams).
/// The axes of the specification (x right, y up, z back), or those that an extension of the file names, are turned to
/// those of 3DGS PLY (x right, y down, z forward); files whose writer left the axes of a PLY without saying so stand on
/// their head.  Harmonics of degree 4 are cut to degree 3 with a warning.  Throws Error{kInput} naming the file and
/// the field.
GaussianCloud read_spz(const std::filesystem::path& file, ReadReport* report = nullptr);

/// Writes version 4, atomically, with as many fractional bits as the extent of the scene allows; where these are fewer
/// than the 12 of Niantic's writer, up to 12, as 99.9 % of the Gaussians allow.  Steps: positions 2^-bits within
/// 8388606 steps, log scales 1/16 in [-10, 5.94], opacity 1/255, rotations 2^-9/sqrt(2), colour 1/255/0.15, harmonics
/// 1/128 in [-1, 1).  Returns how many Gaussians have values outside these ranges, which are clamped.  The axes of 3DGS
/// PLY, or those of a cloud whose `z_is_up`, are turned to those of the specification.
size_t write_spz(const std::filesystem::path& file, const GaussianCloud& cloud, bool antialiased = false,
                 bool z_is_up = false);

}  // namespace pliant

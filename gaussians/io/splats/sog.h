#pragma once

#include <filesystem>

#include "gaussians/base/gaussian_cloud.h"
#include "gaussians/io/splats/read_report.h"

namespace pliant {

/// Reads SOG version 2 (PlayCanvas): a zip archive, or a folder named by its meta.json.  Positions in 16 bits of
/// sign(x) ln(1 + |x|), rotations as the smallest three components in 8 bits, scales and colours by codebooks,
/// harmonics by a palette; all in lossless WebP pictures.  Throws Error{kInput} naming file, key and value.
GaussianCloud read_sog(const std::filesystem::path& file, ReadReport* report = nullptr);

constexpr int kAllLevels = -1;    ///< every level of detail, one over the other
constexpr int kFinestLevel = -2;  ///< the finest level whose files are all there

/// Reads one level of detail of a streamed SOG, named by its lod-meta.json: 0 is the finest.  Level names that are
/// absent are an error when they were asked for.  The environment, where there is one, belongs to every level; a
/// warning tells when its file is absent.
GaussianCloud read_sog_levels(const std::filesystem::path& file, int level, ReadReport* report = nullptr);

}  // namespace pliant

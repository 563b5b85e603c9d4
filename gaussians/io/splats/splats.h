#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "gaussians/base/gaussian_cloud.h"
#include "gaussians/io/splats/read_report.h"
#include "gaussians/io/splats/sog.h"

namespace pliant {

/// The file to read when `path` names splats: the path itself, or the lod-meta.json or meta.json of a folder that is
/// an unbundled SOG.  Told by content, and by extension where the content says nothing (.splat).  Empty when `path`
/// names something else.
std::filesystem::path splats_at(const std::filesystem::path& path);

/// Reads Gaussians of any format: 3DGS, 2DGS and Gaussian Grouping PLY, compressed PLY, .splat, .spz, SOG (.sog,
/// meta.json, lod-meta.json or their folder).  `level` chooses the level of detail of a streamed SOG.  Throws
/// Error{kInput} naming file and field; every count is compared with the size of the file before it is believed.
GaussianCloud read_splats(const std::filesystem::path& path, ReadReport* report = nullptr, int level = kFinestLevel);

/// Writes the format of the extension (.ply, .splat, .spz, .glb), atomically.  Returns what the format could not hold,
/// in sentences for the user.  A cloud whose `z_is_up` is turned for the formats that have y up.
std::vector<std::string> write_splats(const std::filesystem::path& file, const GaussianCloud& cloud,
                                      bool antialiased = false, bool z_is_up = false);

}  // namespace pliant

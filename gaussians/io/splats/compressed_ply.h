#pragma once

#include <istream>
#include <string>

#include "gaussians/base/gaussian_cloud.h"
#include "gaussians/io/splats/ply_header.h"
#include "gaussians/io/splats/read_report.h"

namespace pliant {

/// Whether the header is that of a compressed PLY (PlayCanvas, SuperSplat).
bool is_compressed_ply(const PlyHeader& header);

/// Reads the data behind the header of a compressed PLY: chunks of 256 Gaussians, each with the bounds of its values;
/// positions and scales in 11-10-11 bits, rotations as the smallest three components in 10 bits each, colours and
/// opacity in 8 bits, optional harmonics in 8 bits.  `size` is that of the whole file.  Counts, format and warnings go
/// to `report`.  Throws Error{kInput} naming the file and the element or property.
GaussianCloud read_compressed_ply(std::istream& in, const PlyHeader& header, const std::string& name, uint64_t size,
                                  ReadReport& report);

}  // namespace pliant

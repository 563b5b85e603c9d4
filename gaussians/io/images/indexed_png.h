#pragma once

#include <filesystem>
#include <optional>

#include "gaussians/base/image.h"

namespace pliant {

/// Indices of a PNG with a palette (DAVIS, XMem, DEVA and PIL's mode P write ids like that, where the colours mean
/// nothing); nothing when the file is not a PNG with a palette.  Throws Error{kInput} when it is damaged or interlaced.
std::optional<IdImage> read_palette_indices(const std::filesystem::path& file);

}  // namespace pliant

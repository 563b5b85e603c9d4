#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "gaussians/base/image.h"

namespace pliant {

/// Decodes a lossless WebP picture as R, G, B, A of 8 bits.  `most_pixels` is what the picture may hold at most, which
/// is checked before anything is allocated.  Throws Error{kInput} naming `file`.
ImageU8 decode_webp(std::string_view bytes, size_t most_pixels, const std::string& file);

/// R, G, B of 8 bits as a lossy WebP picture; quality 0..100.
std::string encode_webp(const ImageU8& image, float quality);

}  // namespace pliant

#pragma once

#include <filesystem>

#include "gaussians/base/image.h"

namespace pliant {

/// Reads a photo as RGB in [0, 1], [H, W, 3].  Throws Error{kInput} naming the file.
ImageF read_image(const std::filesystem::path& file);
/// Values in [0, 1], clamped and rounded to 8 bit.
ImageU8 to_8_bit(const ImageF& image);
/// Writes RGB, RGBA (not premultiplied) or grey, clamped to [0, 1] and rounded to 8 bit; the format follows the
/// extension (png, jpg); atomic.
void write_image(const std::filesystem::path& file, const ImageF& image);
/// Writes one channel, in [0, 1], as grey PNG of 16 bit; atomic.
void write_grey_16(const std::filesystem::path& file, const ImageF& image);
/// The largest id that a picture holds.
constexpr uint32_t kLargestId = (1u << 24) - 1;
/// Reads an id picture: PNG with 8 or 16 bits and one channel (value = id), with a palette (index = id), or RGB with
/// id = R + 256 G + 65536 B, as DEVA writes; where R = G = B in all pixels, it is one channel that was saved as RGB.
IdImage read_ids(const std::filesystem::path& file);
/// Writes ids as 8-bit PNG when they fit, else 16-bit, else RGB.
void write_ids(const std::filesystem::path& file, const IdImage& ids);

}  // namespace pliant

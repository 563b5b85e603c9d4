#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

namespace pliant {

constexpr int kSpzFractionalBits = 24;  ///< most that a position can have
constexpr uint8_t kSpzAntialiased = 1;  ///< of the flags

/// The fields that all versions of .spz share.
struct SpzHeader {
  uint32_t magic = 0x5053474e, version = 4, count = 0;  ///< NGSP, the newest version
  uint8_t sh_degree = 0, fractional_bits = 0, flags = 0, streams = 0;
};

/// Attributes, in the order in which they are stored.
enum SpzAttribute { kSpzPositions, kSpzAlphas, kSpzColours, kSpzScales, kSpzRotations, kSpzHarmonics, kSpzAttributes };

/// Coefficients of each colour behind the first.
inline int spz_rest_count(int degree) { return (degree + 1) * (degree + 1) - 1; }

/// Bytes for each Gaussian of each attribute.
std::array<uint64_t, kSpzAttributes> spz_widths(const SpzHeader& header);

/// What a file holds, unpacked.
struct SpzContents {
  SpzHeader header;
  std::string attributes;  ///< of all Gaussians, one attribute behind the other
  std::string extensions;
};

/// Of the bytes of a file of versions 1 to 4.  Throws Error{kInput} naming `file` and the field for anything else, for
/// counts that the file cannot hold and for streams that are damaged.
SpzContents read_spz_contents(std::string_view bytes, const std::string& file);

/// The bytes of a file of version 4, from those of each attribute.
std::string spz_bytes(SpzHeader header, const std::array<std::string, kSpzAttributes>& attributes);

}  // namespace pliant

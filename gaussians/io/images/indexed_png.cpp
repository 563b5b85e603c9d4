#include "gaussians/io/images/indexed_png.h"

#include <zlib.h>

#include <cstdlib>
#include <fstream>
#include <string>

#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"

namespace pliant {
namespace {

uint32_t big_endian(const char* at) {
  uint32_t value = 0;
  for (int k = 0; k < 4; ++k) value = value << 8 | static_cast<uint8_t>(at[k]);
  return value;
}

/// Undoes the filter of one row of bytes (PNG specification, 9.2) with one byte to a pixel or less.
bool unfilter(int filter, const std::string& above, std::string& row) {
  for (size_t x = 0; x < row.size(); ++x) {
    const int left = x ? static_cast<uint8_t>(row[x - 1]) : 0, up = static_cast<uint8_t>(above[x]);
    const int corner = x ? static_cast<uint8_t>(above[x - 1]) : 0;
    int guess = 0;
    if (filter == 1) guess = left;
    if (filter == 2) guess = up;
    if (filter == 3) guess = (left + up) / 2;
    if (filter == 4) {
      const int p = left + up - corner, a = std::abs(p - left), b = std::abs(p - up), c = std::abs(p - corner);
      guess = a <= b && a <= c ? left : b <= c ? up : corner;
    }
    row[x] = static_cast<char>(static_cast<uint8_t>(row[x]) + guess);
  }
  return filter >= 0 && filter <= 4;
}

}  // namespace

std::optional<IdImage> read_palette_indices(const std::filesystem::path& file) {
  // Signature, length, "IHDR", width, height, bit depth, colour type, compression, filter method, interlacing.
  std::ifstream in(file, std::ios::binary);
  char head[33] = {};
  if (!in.read(head, sizeof head) || std::string(head, 8) != "\x89PNG\r\n\x1a\n" ||
      std::string(head + 12, 4) != "IHDR" || head[25] != 3)
    return std::nullopt;
  const auto refuse = [&](const std::string& field, const std::string& problem) {
    return input_error(file.string(), field, problem, "save it again as a PNG with a palette or with one channel");
  };
  const uint32_t width = big_endian(head + 16), height = big_endian(head + 20);
  const int depth = head[24];
  if (width == 0 || height == 0 || width > 65535 || height > 65535)
    throw refuse("IHDR", "gives the size " + std::to_string(width) + "x" + std::to_string(height));
  if (depth != 1 && depth != 2 && depth != 4 && depth != 8)
    throw refuse("IHDR", "gives a palette " + std::to_string(depth) + " bits");
  if (head[28] != 0) throw refuse("IHDR", "says that the image is interlaced, which is not supported with a palette");

  const std::string bytes = read_text(file);
  std::string data;
  for (size_t at = 8; at + 12 <= bytes.size();) {
    const uint32_t length = big_endian(bytes.data() + at);
    const std::string type = bytes.substr(at + 4, 4);
    if (length > bytes.size() - at - 12) throw refuse(type, "reaches beyond the end of the file");
    const auto sum = crc32(0, reinterpret_cast<const Bytef*>(bytes.data() + at + 4), length + 4);
    if (sum != big_endian(bytes.data() + at + 8 + length)) throw refuse(type, "has a wrong checksum");
    if (type == "IDAT") data.append(bytes, at + 8, length);
    if (type == "IEND") break;
    at += 12 + length;
  }
  const size_t row_bytes = (static_cast<size_t>(width) * depth + 7) / 8, expected = (row_bytes + 1) * height;
  if (expected / 1032 > data.size()) throw refuse("IDAT", "is too short for the image");  // deflate's highest ratio
  std::string raw(expected + 1, '\0');
  uLongf got = static_cast<uLongf>(raw.size());
  const int status = uncompress(reinterpret_cast<Bytef*>(raw.data()), &got, reinterpret_cast<const Bytef*>(data.data()),
                                static_cast<uLong>(data.size()));
  if (status != Z_OK || got != expected) throw refuse("IDAT", "does not contain the pixels of the image");

  IdImage ids(static_cast<int>(width), static_cast<int>(height), 1);
  std::string above(row_bytes, '\0'), row;
  for (uint32_t y = 0; y < height; ++y) {
    const size_t at = y * (row_bytes + 1);
    row = raw.substr(at + 1, row_bytes);
    if (!unfilter(static_cast<uint8_t>(raw[at]), above, row))
      throw refuse("IDAT", "has an unknown filter in row " + std::to_string(y));
    for (uint32_t x = 0; x < width; ++x) {
      const size_t bit = static_cast<size_t>(x) * depth;
      const int shift = 8 - depth - static_cast<int>(bit % 8);
      ids(static_cast<int>(x), static_cast<int>(y)) = static_cast<uint8_t>(row[bit / 8]) >> shift & ((1 << depth) - 1);
    }
    above = row;
  }
  return ids;
}

}  // namespace pliant

// Id pictures with a palette are read by index, whatever the colours; damaged ones are refused.

#include "gaussians/io/images/indexed_png.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include "gaussians/io/images/image_io.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

std::string big_endian(uint32_t value) {
  std::string out;
  for (int k = 3; k >= 0; --k) out += static_cast<char>(value >> (8 * k) & 255);
  return out;
}

std::string chunk(const std::string& type, const std::string& data) {
  const std::string body = type + data;
  return big_endian(static_cast<uint32_t>(data.size())) + body +
         big_endian(static_cast<uint32_t>(
             crc32(0, reinterpret_cast<const Bytef*>(body.data()), static_cast<uInt>(body.size()))));
}

/// A PNG with a palette of one shade for all, whose rows use the filters none, sub, up, average and Paeth in turn.
std::string palette_png(const IdImage& ids, int depth, int interlace = 0) {
  std::string raw, above((ids.width * depth + 7) / 8, '\0');
  for (int y = 0; y < ids.height; ++y) {
    std::string row(above.size(), '\0');
    for (int x = 0; x < ids.width; ++x)
      row[x * depth / 8] |= static_cast<char>(ids(x, y) << (8 - depth - x * depth % 8));
    const int filter = y % 5;
    raw += static_cast<char>(filter);
    for (size_t k = 0; k < row.size(); ++k) {
      const int a = k ? uint8_t(row[k - 1]) : 0, b = uint8_t(above[k]), c = k ? uint8_t(above[k - 1]) : 0,
                p = a + b - c;
      const int paeth = std::abs(p - a) <= std::abs(p - b) && std::abs(p - a) <= std::abs(p - c) ? a
                        : std::abs(p - b) <= std::abs(p - c)                                     ? b
                                                                                                 : c;
      const int guess[5] = {0, a, b, (a + b) / 2, paeth};
      raw += static_cast<char>(uint8_t(row[k]) - guess[filter]);
    }
    above = row;
  }
  std::string packed(compressBound(raw.size()), '\0');
  uLongf size = packed.size();
  compress(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(raw.data()), raw.size());
  packed.resize(size);
  const std::string head = big_endian(ids.width) + big_endian(ids.height) +
                           std::string{static_cast<char>(depth), 3, 0, 0, static_cast<char>(interlace)};
  return "\x89PNG\r\n\x1a\n" + chunk("IHDR", head) + chunk("PLTE", std::string(3 << depth, '\x50')) +
         chunk("IDAT", packed.substr(0, 9)) + chunk("IDAT", packed.substr(9)) + chunk("IEND", "");
}

IdImage some_ids(int depth) {
  IdImage ids(13, 11, 1);
  for (size_t i = 0; i < ids.data.size(); ++i) ids.data[i] = static_cast<uint32_t>(i * i + i / 5) % (1u << depth);
  return ids;
}

TEST(IndexedPng, IdsAreIndicesAtEveryDepth) {
  const TemporaryFolder folder;
  for (int depth : {1, 2, 4, 8}) {
    const IdImage ids = some_ids(depth);
    EXPECT_EQ(read_ids(folder.file("ids.png", palette_png(ids, depth))).data, ids.data) << depth;
  }
}

TEST(IndexedPng, PicturesWithoutAPaletteAreLeftToTheOtherReader) {
  const TemporaryFolder folder;
  const IdImage ids = some_ids(8);
  write_ids(folder / "grey.png", ids);
  EXPECT_FALSE(read_palette_indices(folder / "grey.png"));
  EXPECT_EQ(read_ids(folder / "grey.png").data, ids.data);
}

TEST(IndexedPng, DamagedFilesAreRefusedAndNoneCrashes) {
  const TemporaryFolder folder;
  const std::string good = palette_png(some_ids(4), 4);
  expect_error(Failure::kInput, {"interlaced"},
               [&] { read_palette_indices(folder.file("i.png", palette_png(some_ids(4), 4, 1))); });
  std::string flipped = good;
  flipped[good.find("IDAT") + 6] ^= 1;
  expect_error(Failure::kInput, {"IDAT", "checksum"}, [&] { read_palette_indices(folder.file("f.png", flipped)); });
  std::string huge = good;
  huge.replace(16, 4, big_endian(60000));
  huge.replace(20, 4, big_endian(60000));
  huge.replace(29, 4,
               big_endian(static_cast<uint32_t>(crc32(0, reinterpret_cast<const Bytef*>(huge.data() + 12), 17))));
  expect_error(Failure::kInput, {"IDAT", "too short"}, [&] { read_palette_indices(folder.file("h.png", huge)); });
  for (size_t length = 0; length < good.size() - 12; length += 3) {
    const auto file = folder.file("cut.png", good.substr(0, length));
    if (length < 33)
      EXPECT_FALSE(read_palette_indices(file)) << length;
    else
      EXPECT_THROW(read_palette_indices(file), Error) << length;
  }
}

}  // namespace
}  // namespace pliant

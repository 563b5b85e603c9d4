#include "gaussians/io/splats/spz_contents.h"

#include <algorithm>
#include <span>
#include <utility>
#include <vector>

#include "gaussians/base/error.h"
#include "gaussians/io/files/byte_reader.h"
#include "gaussians/io/files/compression.h"

namespace pliant {
namespace {

constexpr uint8_t kExtensions = 2;          // of the flags
constexpr size_t kMostExtension = 1 << 20;  // bytes behind the attributes of versions 1 to 3
constexpr const char* kNames[kSpzAttributes] = {"positions", "alphas", "colours", "scales", "rotations", "harmonics"};
static_assert(sizeof(SpzHeader) == 16);

/// What version 4 has behind it.
struct TableField {
  uint32_t offset = 32;  // of the table of streams, from the beginning of the file
  uint8_t reserved[12] = {};
};

uint64_t row_bytes(const SpzHeader& header) {
  uint64_t sum = 0;
  for (uint64_t width : spz_widths(header)) sum += width;
  return sum;
}

SpzHeader checked(const SpzHeader& header, uint64_t file_bytes, const std::string& file) {
  if (header.magic != SpzHeader().magic) throw input_error(file, "magic", "is not 'NGSP'", "give an .spz file");
  const auto refuse = [&](const std::string& field, uint32_t value, const std::string& remedy) {
    return input_error(file, field, "is " + std::to_string(value), remedy);
  };
  if (header.version < 1 || header.version > SpzHeader().version)
    throw refuse("version", header.version, "versions 1 to 4 are read");
  if (header.sh_degree > 4) throw refuse("shDegree", header.sh_degree, "degrees 0 to 4 exist");
  if (header.fractional_bits > kSpzFractionalBits)
    throw refuse("fractionalBits", header.fractional_bits, "at most 24 are possible");
  if (header.count > INT32_MAX) throw refuse("numPoints", header.count, "at most 2147483647 are supported");
  check_expansion(header.count * row_bytes(header), file_bytes, file, "numPoints");
  return header;
}

/// Attributes of versions 1 to 3, one behind the other.
SpzContents read_legacy(std::string_view bytes, const std::string& file) {
  SpzHeader header;
  if (bytes.substr(0, 4) == "NGSP") {
    ByteReader in(bytes, file);
    header = checked(in.take<SpzHeader>("header"), bytes.size(), file);
    in.expect(header.count, row_bytes(header), "numPoints");
    return {header, std::string(in.take_bytes(header.count * row_bytes(header), "attributes")), ""};
  }
  GzipReader in(bytes, file);
  in.read({reinterpret_cast<char*>(&header), sizeof header}, "header");
  header = checked(header, bytes.size(), file);
  std::string raw(header.count * row_bytes(header), '\0');
  in.read(raw, "numPoints");
  return {header, std::move(raw), in.rest(header.flags & kExtensions ? kMostExtension : 0, "numPoints")};
}

/// Attributes of version 4, one behind the other.
SpzContents read_streams(std::string_view bytes, const std::string& file) {
  ByteReader in(bytes, file);
  const SpzHeader header = checked(in.take<SpzHeader>("header"), bytes.size(), file);
  const auto table = in.take<TableField>("header");
  if (table.offset < 32) {
    throw input_error(file, "tocByteOffset", "is " + std::to_string(table.offset),
                      "it must be after the header of 32 bytes");
  }
  const std::string_view between = in.take_bytes(table.offset - 32, "tocByteOffset");
  const auto width = spz_widths(header);
  const auto expected = static_cast<int>(std::count_if(width.begin(), width.end(), [](uint64_t w) { return w > 0; }));
  if (header.streams != expected) {
    throw input_error(file, "numStreams", "is " + std::to_string(header.streams),
                      "this SH degree has " + std::to_string(expected));
  }
  struct Sizes {
    uint64_t compressed, raw;
  };
  std::vector<Sizes> sizes;
  for (int k = 0; k < expected; ++k) sizes.push_back(in.take<Sizes>("table of streams"));
  std::string raw(header.count * row_bytes(header), '\0');
  std::span<char> rest(raw);
  for (int k = 0; k < expected; ++k) {
    const uint64_t size = header.count * width[k];
    if (sizes[k].raw != size) {
      throw input_error(file, kNames[k],
                        "has " + std::to_string(sizes[k].raw) + " bytes, numPoints needs " + std::to_string(size),
                        "the header is wrong");
    }
    decompress_zstd(in.take_bytes(sizes[k].compressed, kNames[k]), rest.first(size), file, kNames[k]);
    rest = rest.subspan(size);
  }
  return {header, std::move(raw), std::string(header.flags & kExtensions ? between : std::string_view())};
}

}  // namespace

std::array<uint64_t, kSpzAttributes> spz_widths(const SpzHeader& header) {
  const uint64_t position = header.version == 1 ? 6 : 9, rotation = header.version >= 3 ? 4 : 3;
  return {position, 1, 3, 3, rotation, 3 * static_cast<uint64_t>(spz_rest_count(header.sh_degree))};
}

SpzContents read_spz_contents(std::string_view bytes, const std::string& file) {
  const bool streams = bytes.size() >= 8 && bytes.compare(0, 4, "NGSP") == 0 && static_cast<uint8_t>(bytes[4]) >= 4;
  return streams ? read_streams(bytes, file) : read_legacy(bytes, file);
}

std::string spz_bytes(SpzHeader header, const std::array<std::string, kSpzAttributes>& attributes) {
  header.streams = header.sh_degree > 0 ? 6 : 5;
  std::string table, streams;
  for (int k = 0; k < header.streams; ++k) {
    const std::string compressed = compress_zstd(attributes[k]);
    const uint64_t sizes[2] = {compressed.size(), attributes[k].size()};
    table.append(reinterpret_cast<const char*>(sizes), sizeof sizes);
    streams += compressed;
  }
  const TableField field;
  std::string bytes(reinterpret_cast<const char*>(&header), sizeof header);
  bytes.append(reinterpret_cast<const char*>(&field), sizeof field);
  return bytes + table + streams;
}

}  // namespace pliant

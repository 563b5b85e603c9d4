#include "gaussians/io/splats/spz.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>

#include "gaussians/io/files/byte_reader.h"
#include "gaussians/io/files/compression.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/splats/cloud_builder.h"
#include "gaussians/io/splats/half_turn.h"

namespace pliant {
namespace {

constexpr uint32_t kMagic = 0x5053474e;  // NGSP
constexpr uint32_t kNewest = 4;
constexpr int kMostFractionalBits = 24;
constexpr int kUsualFractionalBits = 12;     // of Niantic's writer
constexpr float kLargestFixed = 8388606.0f;  // of 24 bits with a sign
constexpr uint8_t kAntialiased = 1, kExtensions = 2;
constexpr float kColourScale = 0.15f;       // of the first harmonic
constexpr size_t kMostExtension = 1 << 20;  // bytes behind the attributes of versions 1 to 3
constexpr uint32_t kComponentMask = 511;    // of the magnitude of a component of a rotation

/// The fields that all versions share.
struct Header {
  uint32_t magic = kMagic, version = kNewest, count = 0;
  uint8_t sh_degree = 0, fractional_bits = 0, flags = 0, streams = 0;
};
static_assert(sizeof(Header) == 16);

/// What version 4 has behind it.
struct TableField {
  uint32_t offset = 32;  // of the table of streams, from the beginning of the file
  uint8_t reserved[12] = {};
};

enum Attribute { kPositions, kAlphas, kColours, kScales, kRotations, kHarmonics, kAttributes };
constexpr const char* kNames[kAttributes] = {"positions", "alphas", "colours", "scales", "rotations", "harmonics"};

int rest_count(int degree) { return (degree + 1) * (degree + 1) - 1; }

/// Bytes for each Gaussian of each attribute.
std::array<uint64_t, kAttributes> widths(const Header& header) {
  const uint64_t position = header.version == 1 ? 6 : 9, rotation = header.version >= 3 ? 4 : 3;
  return {position, 1, 3, 3, rotation, 3 * static_cast<uint64_t>(rest_count(header.sh_degree))};
}

uint64_t row_bytes(const Header& header) {
  uint64_t sum = 0;
  for (uint64_t width : widths(header)) sum += width;
  return sum;
}

Header checked(const Header& header, uint64_t file_bytes, const std::string& file) {
  if (header.magic != kMagic) throw input_error(file, "magic", "is not 'NGSP'", "give an .spz file");
  const auto refuse = [&](const std::string& field, uint32_t value, const std::string& remedy) {
    return input_error(file, field, "is " + std::to_string(value), remedy);
  };
  if (header.version < 1 || header.version > kNewest)
    throw refuse("version", header.version, "versions 1 to 4 are read");
  if (header.sh_degree > 4) throw refuse("shDegree", header.sh_degree, "degrees 0 to 4 exist");
  if (header.fractional_bits > kMostFractionalBits)
    throw refuse("fractionalBits", header.fractional_bits, "at most 24 are possible");
  if (header.count > INT32_MAX) throw refuse("numPoints", header.count, "at most 2147483647 are supported");
  check_expansion(header.count * row_bytes(header), file_bytes, file, "numPoints");
  return header;
}

/// The half turn that takes the file's axes to those of 3DGS PLY (right, down, front); -1 = none.  An extension may
/// name the axes; otherwise they are right, up, back.
int half_turn_of(std::string_view extensions, const std::string& file) {
  constexpr uint32_t kCoordinates = 0xADBE0003;
  struct Record {
    uint32_t type, bytes;
  };
  ByteReader in(extensions, file);
  while (in.left() >= sizeof(Record)) {
    const auto record = in.take<Record>("extension");
    const std::string_view payload = in.take_bytes(record.bytes, "extension");
    if (record.type != kCoordinates) continue;
    switch (const auto axes = ByteReader(payload, file).take<uint32_t>("coordinate system")) {
      case 0:
      case 4:
        return 0;  // not said; right, up, back
      case 1:
        return 1;  // left, down, back
      case 6:
        return -1;  // right, down, front
      case 7:
        return 2;  // left, up, front
      default:
        throw input_error(file, "coordinate system", "is " + std::to_string(axes),
                          "LDB, RUB, RDF and LUF are read: 1, 4, 6 and 7");
    }
  }
  return 0;
}

/// Attributes of versions 1 to 3, one behind the other.
std::string read_legacy(std::string_view bytes, const std::string& file, Header& header, std::string& extensions) {
  if (bytes.substr(0, 4) == "NGSP") {
    ByteReader in(bytes, file);
    header = checked(in.take<Header>("header"), bytes.size(), file);
    in.expect(header.count, row_bytes(header), "numPoints");
    return std::string(in.take_bytes(header.count * row_bytes(header), "attributes"));
  }
  GzipReader in(bytes, file);
  in.read({reinterpret_cast<char*>(&header), sizeof header}, "header");
  header = checked(header, bytes.size(), file);
  std::string raw(header.count * row_bytes(header), '\0');
  in.read(raw, "numPoints");
  extensions = in.rest(header.flags & kExtensions ? kMostExtension : 0, "numPoints");
  return raw;
}

/// Attributes of version 4, one behind the other.
std::string read_streams(std::string_view bytes, const std::string& file, Header& header, std::string& extensions) {
  ByteReader in(bytes, file);
  header = checked(in.take<Header>("header"), bytes.size(), file);
  const auto table = in.take<TableField>("header");
  if (table.offset < 32) {
    throw input_error(file, "tocByteOffset", "is " + std::to_string(table.offset),
                      "it must be after the header of 32 bytes");
  }
  const std::string_view between = in.take_bytes(table.offset - 32, "tocByteOffset");
  if (header.flags & kExtensions) extensions = between;
  const auto width = widths(header);
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
  return raw;
}

Vec3f unpack_position(const uint8_t* bytes, const Header& header) {
  Vec3f x;
  for (int k = 0; k < 3; ++k) {
    if (header.version == 1) {
      x[k] = static_cast<float>(
          Eigen::numext::bit_cast<Eigen::half>(static_cast<uint16_t>(bytes[2 * k] | bytes[2 * k + 1] << 8)));
    } else {
      const uint32_t word = bytes[3 * k] | bytes[3 * k + 1] << 8 | static_cast<uint32_t>(bytes[3 * k + 2]) << 16;
      const int32_t fixed = static_cast<int32_t>(word << 8) >> 8;  // carries the sign
      x[k] = std::ldexp(static_cast<float>(fixed), -header.fractional_bits);
    }
  }
  return x;
}

/// Quaternion w, x, y, z; the file's order is x, y, z, w.
Vec4f unpack_rotation(const uint8_t* bytes, uint32_t version) {
  Vec4f xyzw = Vec4f::Zero();
  int largest = 3;
  if (version < 3) {
    for (int k = 0; k < 3; ++k) xyzw[k] = static_cast<float>(bytes[k]) / 127.5f - 1.0f;
  } else {
    uint32_t word;
    std::memcpy(&word, bytes, 4);
    largest = static_cast<int>(word >> 30);
    for (int k = 3; k >= 0; --k) {
      if (k == largest) continue;
      const float magnitude =
          static_cast<float>(M_SQRT1_2) * static_cast<float>(word & kComponentMask) / kComponentMask;
      xyzw[k] = word & (kComponentMask + 1) ? -magnitude : magnitude;
      word >>= 10;
    }
  }
  xyzw[largest] = std::sqrt(std::max(0.0f, 1.0f - xyzw.squaredNorm()));
  return {xyzw[3], xyzw[0], xyzw[1], xyzw[2]};
}

uint32_t pack_rotation(const Vec4f& wxyz) {
  Vec4f q = wxyz.normalized();
  q = Vec4f(q[1], q[2], q[3], q[0]);
  Eigen::Index largest;
  q.cwiseAbs().maxCoeff(&largest);
  if (q[largest] < 0) q = -q;
  auto word = static_cast<uint32_t>(largest);
  for (int k = 0; k < 4; ++k) {
    if (k == largest) continue;
    const auto magnitude =
        static_cast<uint32_t>(std::lround(std::abs(q[k]) * static_cast<float>(M_SQRT2) * kComponentMask));
    word = word << 10 | (q[k] < 0 ? kComponentMask + 1 : 0) | std::min(magnitude, kComponentMask);
  }
  return word;
}

/// Fractional bits of positions within so many units; negative where the format cannot store them.
int bits_within(float extent) {
  int bits = kMostFractionalBits;
  while (bits >= 0 && std::ldexp(extent, bits) > kLargestFixed) --bits;
  return bits;
}

/// Fractional bits with which positions are stored.  A few that are far away do not make those of all others coarse.
int bits_for(const std::vector<Vec3f>& position, const std::string& file) {
  constexpr double kShare = 0.999;
  std::vector<float> reach;
  for (const Vec3f& x : position) reach.push_back(x.cwiseAbs().maxCoeff());
  if (reach.empty()) return kMostFractionalBits;
  const int all = bits_within(*std::max_element(reach.begin(), reach.end()));
  if (all >= kUsualFractionalBits) return all;
  const auto most =
      reach.begin() + static_cast<std::ptrdiff_t>(std::ceil(kShare * static_cast<double>(reach.size()))) - 1;
  std::nth_element(reach.begin(), most, reach.end());
  const int bits = std::min(bits_within(*most), kUsualFractionalBits);
  if (bits < 0)
    throw input_error(file, "positions", "reach " + std::to_string(*most) + " units",
                      "the format stores up to 8388606: write a PLY");
  return bits;
}

/// The nearest byte; `clamped` is set where that is farther off than half a step.
uint8_t pack(float value, bool& clamped) {
  clamped = clamped || value < -0.5f || value > 255.5f;
  return static_cast<uint8_t>(std::clamp(std::lround(value), 0l, 255l));
}

}  // namespace

GaussianCloud read_spz(const std::filesystem::path& file, ReadReport* report) {
  const std::string bytes = read_text(file), name = file.string();
  Header header;
  const bool streams = bytes.size() >= 8 && bytes.compare(0, 4, "NGSP") == 0 && static_cast<uint8_t>(bytes[4]) >= 4;
  std::string extensions;
  const std::string raw =
      streams ? read_streams(bytes, name, header, extensions) : read_legacy(bytes, name, header, extensions);

  const auto width = widths(header);
  const uint8_t* at[kAttributes];
  const auto* begin = reinterpret_cast<const uint8_t*>(raw.data());
  for (int k = 0; k < kAttributes; ++k) {
    at[k] = begin;
    begin += header.count * width[k];
  }
  const int degree = std::min<int>(header.sh_degree, 3);
  CloudBuilder builder(degree, header.count);
  for (size_t i = 0; i < header.count; ++i) {
    SplatRow row;
    row.position = unpack_position(at[kPositions] + i * width[kPositions], header);
    row.rotation = unpack_rotation(at[kRotations] + i * width[kRotations], header.version);
    row.opacity_logit = logit_of_byte(at[kAlphas][i]);
    for (int k = 0; k < 3; ++k) {
      row.log_scale[k] = static_cast<float>(at[kScales][3 * i + k]) / 16.0f - 10.0f;
      row.sh[k] = (static_cast<float>(at[kColours][3 * i + k]) / 255.0f - 0.5f) / kColourScale;
    }
    const uint8_t* harmonics = at[kHarmonics] + i * width[kHarmonics];
    for (int k = 0; k < 3 * rest_count(degree); ++k)
      row.sh[3 + k] = (static_cast<float>(harmonics[k]) - 128.0f) / 128.0f;
    builder.add(row);
  }
  ReadReport found;
  found.format = "spz version " + std::to_string(header.version) + ", SH degree " + std::to_string(header.sh_degree);
  found.files = {file};
  found.antialiased = header.flags & kAntialiased;
  GaussianCloud cloud = builder.finish(found);
  if (const int axis = half_turn_of(extensions, name); axis >= 0) turn_half(cloud, axis);
  if (header.sh_degree > 3) found.warnings.push_back("harmonics of degree 4 are dropped");
  if (report) *report = std::move(found);
  return cloud;
}

size_t write_spz(const std::filesystem::path& file, const GaussianCloud& cloud, bool antialiased, bool z_is_up) {
  GaussianCloud turned = cloud;
  turn_y_up(turned, z_is_up);
  Header header;
  header.count = static_cast<uint32_t>(cloud.size());
  header.sh_degree = static_cast<uint8_t>(cloud.sh_degree);
  header.fractional_bits = static_cast<uint8_t>(bits_for(turned.position, file.string()));
  header.flags = antialiased ? kAntialiased : 0;
  std::string raw[kAttributes];
  size_t clamped_count = 0;
  for (size_t i = 0; i < turned.size(); ++i) {
    bool clamped = false;
    const float* sh = turned.sh_of(i);
    for (int k = 0; k < 3; ++k) {
      const float steps = std::ldexp(turned.position[i][k], header.fractional_bits);
      clamped = clamped || std::abs(steps) > kLargestFixed;
      const auto fixed = static_cast<uint32_t>(std::lround(std::clamp(steps, -kLargestFixed, kLargestFixed)));
      for (int byte = 0; byte < 3; ++byte) raw[kPositions].push_back(static_cast<char>(fixed >> 8 * byte));
      raw[kScales].push_back(static_cast<char>(pack((turned.log_scale[i][k] + 10.0f) * 16.0f, clamped)));
      raw[kColours].push_back(static_cast<char>(pack((sh[k] * kColourScale + 0.5f) * 255.0f, clamped)));
    }
    raw[kAlphas].push_back(static_cast<char>(byte_of(sigmoid(turned.opacity_logit[i]))));
    const uint32_t rotation = pack_rotation(turned.rotation[i]);
    raw[kRotations].append(reinterpret_cast<const char*>(&rotation), 4);
    for (int k = 0; k < 3 * rest_count(turned.sh_degree); ++k) {
      raw[kHarmonics].push_back(static_cast<char>(pack(sh[3 + k] * 128.0f + 128.0f, clamped)));
    }
    clamped_count += clamped;
  }
  header.streams = cloud.sh_degree > 0 ? 6 : 5;
  std::string table, streams;
  for (int k = 0; k < header.streams; ++k) {
    const std::string compressed = compress_zstd(raw[k]);
    const uint64_t sizes[2] = {compressed.size(), raw[k].size()};
    table.append(reinterpret_cast<const char*>(sizes), sizeof sizes);
    streams += compressed;
  }
  const TableField field;
  std::string bytes(reinterpret_cast<const char*>(&header), sizeof header);
  bytes.append(reinterpret_cast<const char*>(&field), sizeof field);
  write_text(file, bytes + table + streams);
  return clamped_count;
}

}  // namespace pliant

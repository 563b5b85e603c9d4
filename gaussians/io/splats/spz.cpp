#include "gaussians/io/splats/spz.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>

#include "gaussians/io/files/byte_reader.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/splats/cloud_builder.h"
#include "gaussians/io/splats/half_turn.h"
#include "gaussians/io/splats/spz_contents.h"

namespace pliant {
namespace {

constexpr int kUsualFractionalBits = 12;     // of Niantic's writer
constexpr float kLargestFixed = 8388606.0f;  // of 24 bits with a sign
constexpr float kColourScale = 0.15f;        // of the first harmonic
constexpr uint32_t kComponentMask = 511;     // of the magnitude of a component of a rotation

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

Vec3f unpack_position(const uint8_t* bytes, const SpzHeader& header) {
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
  int bits = kSpzFractionalBits;
  while (bits >= 0 && std::ldexp(extent, bits) > kLargestFixed) --bits;
  return bits;
}

/// Fractional bits with which positions are stored.  A few that are far away do not make those of all others coarse.
int bits_for(const std::vector<Vec3f>& position, const std::string& file) {
  constexpr double kShare = 0.999;
  std::vector<float> reach;
  for (const Vec3f& x : position) reach.push_back(x.cwiseAbs().maxCoeff());
  if (reach.empty()) return kSpzFractionalBits;
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
  const std::string name = file.string();
  const SpzContents contents = read_spz_contents(read_text(file), name);
  const SpzHeader& header = contents.header;
  const auto width = spz_widths(header);
  const uint8_t* at[kSpzAttributes];
  const auto* begin = reinterpret_cast<const uint8_t*>(contents.attributes.data());
  for (int k = 0; k < kSpzAttributes; ++k) {
    at[k] = begin;
    begin += header.count * width[k];
  }
  const int degree = std::min<int>(header.sh_degree, 3);
  CloudBuilder builder(degree, header.count);
  for (size_t i = 0; i < header.count; ++i) {
    SplatRow row;
    row.position = unpack_position(at[kSpzPositions] + i * width[kSpzPositions], header);
    row.rotation = unpack_rotation(at[kSpzRotations] + i * width[kSpzRotations], header.version);
    row.opacity_logit = logit_of_byte(at[kSpzAlphas][i]);
    for (int k = 0; k < 3; ++k) {
      row.log_scale[k] = static_cast<float>(at[kSpzScales][3 * i + k]) / 16.0f - 10.0f;
      row.sh[k] = (static_cast<float>(at[kSpzColours][3 * i + k]) / 255.0f - 0.5f) / kColourScale;
    }
    const uint8_t* harmonics = at[kSpzHarmonics] + i * width[kSpzHarmonics];
    for (int k = 0; k < 3 * spz_rest_count(degree); ++k)
      row.sh[3 + k] = (static_cast<float>(harmonics[k]) - 128.0f) / 128.0f;
    builder.add(row);
  }
  ReadReport found;
  found.format = "spz version " + std::to_string(header.version) + ", SH degree " + std::to_string(header.sh_degree);
  found.files = {file};
  found.antialiased = header.flags & kSpzAntialiased;
  GaussianCloud cloud = builder.finish(found);
  if (const int axis = half_turn_of(contents.extensions, name); axis >= 0) turn_half(cloud, axis);
  if (header.sh_degree > 3) found.warnings.push_back("harmonics of degree 4 are dropped");
  if (report) *report = std::move(found);
  return cloud;
}

size_t write_spz(const std::filesystem::path& file, const GaussianCloud& cloud, bool antialiased, bool z_is_up) {
  GaussianCloud turned = cloud;
  turn_y_up(turned, z_is_up);
  SpzHeader header;
  header.count = static_cast<uint32_t>(cloud.size());
  header.sh_degree = static_cast<uint8_t>(cloud.sh_degree);
  header.fractional_bits = static_cast<uint8_t>(bits_for(turned.position, file.string()));
  header.flags = antialiased ? kSpzAntialiased : 0;
  std::array<std::string, kSpzAttributes> raw;
  size_t clamped_count = 0;
  for (size_t i = 0; i < turned.size(); ++i) {
    bool clamped = false;
    const float* sh = turned.sh_of(i);
    for (int k = 0; k < 3; ++k) {
      const float steps = std::ldexp(turned.position[i][k], header.fractional_bits);
      clamped = clamped || std::abs(steps) > kLargestFixed;
      const auto fixed = static_cast<uint32_t>(std::lround(std::clamp(steps, -kLargestFixed, kLargestFixed)));
      for (int byte = 0; byte < 3; ++byte) raw[kSpzPositions].push_back(static_cast<char>(fixed >> 8 * byte));
      raw[kSpzScales].push_back(static_cast<char>(pack((turned.log_scale[i][k] + 10.0f) * 16.0f, clamped)));
      raw[kSpzColours].push_back(static_cast<char>(pack((sh[k] * kColourScale + 0.5f) * 255.0f, clamped)));
    }
    raw[kSpzAlphas].push_back(static_cast<char>(byte_of(sigmoid(turned.opacity_logit[i]))));
    const uint32_t rotation = pack_rotation(turned.rotation[i]);
    raw[kSpzRotations].append(reinterpret_cast<const char*>(&rotation), 4);
    for (int k = 0; k < 3 * spz_rest_count(turned.sh_degree); ++k) {
      raw[kSpzHarmonics].push_back(static_cast<char>(pack(sh[3 + k] * 128.0f + 128.0f, clamped)));
    }
    clamped_count += clamped;
  }
  write_text(file, spz_bytes(header, raw));
  return clamped_count;
}

}  // namespace pliant

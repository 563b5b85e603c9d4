#include "gaussians/io/splats/compressed_ply.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "gaussians/base/error.h"
#include "gaussians/io/splats/cloud_builder.h"
#include "gaussians/io/splats/ply_rows.h"

namespace pliant {
namespace {

constexpr size_t kChunk = 256;  // Gaussians that share their bounds

/// The rows of one element with columns found by name.
class Table {
 public:
  Table(const PlyElement& element, std::string rows, std::string file)
      : element_(&element), rows_(std::move(rows)), file_(std::move(file)), row_bytes_(element.row_bytes()) {}

  size_t column(const std::string& name, PlyType type) const {
    const int index = element_->find(name);
    if (index < 0 || element_->properties[index].type != type) {
      throw input_error(file_, "property " + name, "is missing in element " + element_->name + " or has another type",
                        "save the scene as a standard PLY");
    }
    size_t offset = 0;
    for (int i = 0; i < index; ++i) offset += ply_size(element_->properties[i].type);
    return offset;
  }

  template <class T>
  T value(size_t row, size_t column) const {
    T value;
    std::memcpy(&value, rows_.data() + row * row_bytes_ + column, sizeof value);
    return value;
  }

 private:
  const PlyElement* element_;
  std::string rows_, file_;
  size_t row_bytes_;
};

/// The `bits` bits of `word` that begin at `shift`, as a share of their largest value.
float share(uint32_t word, int shift, int bits) {
  const uint32_t mask = (1u << bits) - 1;
  return static_cast<float>((word >> shift) & mask) / static_cast<float>(mask);
}

Vec3f unpack_11_10_11(uint32_t word) { return {share(word, 21, 11), share(word, 11, 10), share(word, 0, 11)}; }

/// Quaternion w, x, y, z from the index of its largest component and the other three, which lie in [-1, 1] / sqrt(2).
Vec4f unpack_rotation(uint32_t word) {
  Vec4f q;
  const int largest = static_cast<int>(word >> 30);
  float rest = 1;
  for (int k = 0, shift = 20; k < 4; ++k) {
    if (k == largest) continue;
    q[k] = (share(word, shift, 10) - 0.5f) * static_cast<float>(M_SQRT2);
    rest -= q[k] * q[k];
    shift -= 10;
  }
  q[largest] = std::sqrt(std::max(rest, 0.0f));
  return q;
}

/// Harmonics in [-4, 4] from the middle of their step; the ends stand for themselves.
float unpack_harmonic(uint8_t byte) {
  const float middle = byte == 0 ? 0.0f : byte == 255 ? 1.0f : (static_cast<float>(byte) + 0.5f) / 256.0f;
  return (middle - 0.5f) * 8.0f;
}

/// Lower and upper bounds of three values, per chunk.
struct Bounds {
  Bounds(const Table& chunks, const std::string& infix, const char* axes) {
    for (int k = 0; k < 3; ++k) {
      low[k] = chunks.column("min_" + infix + axes[k], PlyType::kFloat);
      high[k] = chunks.column("max_" + infix + axes[k], PlyType::kFloat);
    }
  }
  Vec3f at(const Table& chunks, size_t chunk, const Vec3f& t) const {
    Vec3f value;
    for (int k = 0; k < 3; ++k) {
      value[k] = chunks.value<float>(chunk, low[k]) * (1 - t[k]) + chunks.value<float>(chunk, high[k]) * t[k];
    }
    return value;
  }
  std::array<size_t, 3> low, high;
};

/// SH degree from the number of f_rest properties of the element.
int degree_of(const PlyElement& harmonics, const std::string& file) {
  const size_t counts[] = {0, 9, 24, 45};
  const auto* degree = std::find(std::begin(counts), std::end(counts), harmonics.properties.size());
  if (degree == std::end(counts)) {
    throw input_error(file, "element sh", "has " + std::to_string(harmonics.properties.size()) + " properties",
                      "SH degrees 1 to 3 have 9, 24 or 45");
  }
  return static_cast<int>(degree - counts);
}

}  // namespace

bool is_compressed_ply(const PlyHeader& header) {
  const PlyElement* vertex = header.find("vertex");
  return header.find("chunk") && vertex && vertex->find("packed_position") >= 0;
}

GaussianCloud read_compressed_ply(std::istream& in, const PlyHeader& header, const std::string& name, uint64_t size,
                                  ReadReport& report) {
  const PlyElement &chunk = *header.find("chunk"), &vertex = *header.find("vertex");
  const PlyElement* sh = header.find("sh");
  if (vertex.count > INT32_MAX || chunk.count < (vertex.count + kChunk - 1) / kChunk) {
    throw input_error(name, "element chunk",
                      "has " + std::to_string(chunk.count) + " rows for " + std::to_string(vertex.count) + " Gaussians",
                      "every 256 Gaussians need one");
  }
  if (sh && sh->count != vertex.count) {
    throw input_error(name, "element sh",
                      "has " + std::to_string(sh->count) + " rows for " + std::to_string(vertex.count) + " Gaussians",
                      "both counts must be equal");
  }
  const int degree = sh ? degree_of(*sh, name) : 0;

  std::string chunk_rows, vertex_rows, sh_rows;
  for (const PlyElement& element : header.elements) {
    PlyRows rows(in, header, element, name, size);
    if (&element == &chunk)
      chunk_rows = rows.bytes();
    else if (&element == &vertex)
      vertex_rows = rows.bytes();
    else if (&element == sh)
      sh_rows = rows.bytes();
    else
      rows.skip();
  }
  const Table chunks(chunk, std::move(chunk_rows), name), packed(vertex, std::move(vertex_rows), name);
  const Bounds positions(chunks, "", "xyz"), scales(chunks, "scale_", "xyz");
  const bool coloured = chunk.find("min_r") >= 0;
  const Bounds colours = coloured ? Bounds(chunks, "", "rgb") : positions;
  size_t column[4];
  const char* names[] = {"packed_position", "packed_rotation", "packed_scale", "packed_color"};
  for (int k = 0; k < 4; ++k) column[k] = packed.column(names[k], PlyType::kUint32);
  const int rest = (degree + 1) * (degree + 1) - 1;
  std::vector<size_t> harmonic;
  const Table harmonics(sh ? *sh : vertex, std::move(sh_rows), name);
  for (int k = 0; k < 3 * rest; ++k)
    harmonic.push_back(harmonics.column("f_rest_" + std::to_string(k), PlyType::kUint8));

  CloudBuilder builder(degree, vertex.count);
  for (size_t i = 0; i < vertex.count; ++i) {
    SplatRow row;
    row.position = positions.at(chunks, i / kChunk, unpack_11_10_11(packed.value<uint32_t>(i, column[0])));
    row.rotation = unpack_rotation(packed.value<uint32_t>(i, column[1]));
    row.log_scale = scales.at(chunks, i / kChunk, unpack_11_10_11(packed.value<uint32_t>(i, column[2])));
    const auto rgba = packed.value<uint32_t>(i, column[3]);
    Vec3f colour(share(rgba, 24, 8), share(rgba, 16, 8), share(rgba, 8, 8));
    if (coloured) colour = colours.at(chunks, i / kChunk, colour);
    for (int c = 0; c < 3; ++c) row.sh[c] = sh_of_color(colour[c]);
    row.opacity_logit = logit_of_byte(static_cast<uint8_t>(rgba));
    for (int k = 0; k < rest; ++k) {
      for (int c = 0; c < 3; ++c)
        row.sh[3 + 3 * k + c] = unpack_harmonic(harmonics.value<uint8_t>(i, harmonic[c * rest + k]));
    }
    builder.add(row);
  }
  report.format = "compressed PLY, SH degree " + std::to_string(degree);
  return builder.finish(report);
}

}  // namespace pliant

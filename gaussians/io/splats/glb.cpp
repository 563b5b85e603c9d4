#include "gaussians/io/splats/glb.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/splats/half_turn.h"

namespace pliant {
using nlohmann::json;

namespace {

constexpr uint32_t kMagic = 0x46546C67, kVersion = 2, kJson = 0x4E4F534A, kBinary = 0x004E4942;
constexpr int kFloat = 5126, kVertices = 34962, kPoints = 0;  // of glTF: component type, buffer target, mode
const std::string kExtension = "KHR_gaussian_splatting";

/// The attributes of the points, one after the other in one buffer.
class Attributes {
 public:
  explicit Attributes(size_t points) : points_(points) {}

  /// value(g, out): writes the `width` numbers of Gaussian g.
  template <class Value>
  void add(const std::string& name, int width, const Value& value) {
    const size_t begin = bytes_.size(), length = points_ * width * sizeof(float);
    bytes_.resize(begin + length);
    float* out = reinterpret_cast<float*>(bytes_.data() + begin);
    for (size_t g = 0; g < points_; ++g) value(g, out + g * width);
    const char* const types[] = {"SCALAR", "VEC2", "VEC3", "VEC4"};
    names_[name] = accessors_.size();
    views_.push_back({{"buffer", 0}, {"byteOffset", begin}, {"byteLength", length}, {"target", kVertices}});
    accessors_.push_back(
        {{"bufferView", views_.size() - 1}, {"componentType", kFloat}, {"count", points_}, {"type", types[width - 1]}});
  }
  /// Bounds of the attribute that was added last.
  void bound(const Box& box) {
    accessors_.back()["min"] = {box.low.x(), box.low.y(), box.low.z()};
    accessors_.back()["max"] = {box.high.x(), box.high.y(), box.high.z()};
  }

  json document() const {
    const json splats = {{"kernel", "ellipse"}, {"colorSpace", "srgb_rec709_display"}},
               points = {{"attributes", names_}, {"mode", kPoints}, {"extensions", {{kExtension, splats}}}};
    json document;
    document["asset"] = {{"version", "2.0"}, {"generator", "Pliant " PLIANT_VERSION}};
    document["extensionsUsed"] = json::array({kExtension});
    document["scene"] = 0;
    document["scenes"] = json::array({json{{"nodes", json::array({0})}}});
    document["nodes"] = json::array({json{{"mesh", 0}}});
    document["meshes"] = json::array({json{{"primitives", json::array({points})}}});
    document["buffers"] = json::array({json{{"byteLength", bytes_.size()}}});
    document["bufferViews"] = views_;
    document["accessors"] = accessors_;
    return document;
  }
  const std::string& bytes() const { return bytes_; }

 private:
  size_t points_;
  std::string bytes_;
  json names_ = json::object(), views_ = json::array(), accessors_ = json::array();
};

void append(std::string& out, uint32_t value) { out.append(reinterpret_cast<const char*>(&value), sizeof value); }

void append_chunk(std::string& out, uint32_t kind, const std::string& content, char padding) {
  const size_t padded = (content.size() + 3) / 4 * 4;
  append(out, static_cast<uint32_t>(padded));
  append(out, kind);
  out += content;
  out.append(padded - content.size(), padding);
}

}  // namespace

void write_glb(const std::filesystem::path& file, const GaussianCloud& cloud, bool z_is_up) {
  const uint64_t floats = 3 + 4 + 3 + 1 + 4 + 3 * static_cast<uint64_t>(cloud.sh_count());
  if (cloud.size() * floats * sizeof(float) > UINT32_MAX - (1u << 20))
    throw input_error(file.string(), "", "would be larger than the 4 GiB of a .glb", "write .ply or .spz");
  GaussianCloud turned = cloud;
  turn_y_up(turned, z_is_up);
  Attributes attributes(turned.size());
  attributes.add("POSITION", 3, [&](size_t g, float* out) { std::copy_n(turned.position[g].data(), 3, out); });
  attributes.bound(turned.bounds());
  attributes.add("COLOR_0", 4, [&](size_t g, float* out) {
    for (int c = 0; c < 3; ++c) out[c] = std::clamp(dc_color(turned.sh_of(g)[c]), 0.0f, 1.0f);
    out[3] = sigmoid(turned.opacity_logit[g]);
  });
  attributes.add(kExtension + ":ROTATION", 4, [&](size_t g, float* out) {
    const float length = turned.rotation[g].norm();
    const Vec4f q = length > 0 ? Vec4f(turned.rotation[g] / length) : Vec4f(1, 0, 0, 0);
    for (int k = 0; k < 4; ++k) out[k] = q[(k + 1) % 4];
  });
  attributes.add(kExtension + ":SCALE", 3, [&](size_t g, float* out) {
    for (int k = 0; k < 3; ++k) out[k] = std::exp(turned.log_scale[g][k]);
  });
  attributes.add(kExtension + ":OPACITY", 1, [&](size_t g, float* out) { *out = sigmoid(turned.opacity_logit[g]); });
  for (int degree = 0; degree <= turned.sh_degree; ++degree)
    for (int n = 0; n < 2 * degree + 1; ++n)
      attributes.add(kExtension + ":SH_DEGREE_" + std::to_string(degree) + "_COEF_" + std::to_string(n), 3,
                     [&](size_t g, float* out) { std::copy_n(turned.sh_of(g) + 3 * (degree * degree + n), 3, out); });
  std::string chunks;
  append_chunk(chunks, kJson, attributes.document().dump(), ' ');
  append_chunk(chunks, kBinary, attributes.bytes(), '\0');
  std::string bytes;
  append(bytes, kMagic);
  append(bytes, kVersion);
  append(bytes, static_cast<uint32_t>(12 + chunks.size()));
  write_text(file, bytes + chunks);
}

}  // namespace pliant

#include "app/page/coded_splats.h"

#include <algorithm>
#include <cmath>

#include "gaussians/base/error.h"
#include "gaussians/base/quantile.h"

namespace pliant {
namespace {

constexpr float kLowestLogScale = -14;       // smaller standard deviations, in scene units, are not told apart
constexpr double kRare = 1e-4;               // share of the coefficients that may be cut to the range of the others
constexpr double kFarthestColour = 16;       // coefficients beyond are saturated in every picture
constexpr float kLeastAlpha = 1.0f / 255;    // below which nothing is drawn
constexpr uint32_t kQuaternionSteps = 1022;  // even, so that 0 is one of them

int steps_of(const SplatCoding& coding) { return coding.fine ? 65535 : 255; }

uint32_t rounded(double value, const CodedSplats::Range& range, uint32_t steps) {
  const double share = range.high > range.low ? (value - range.low) / (range.high - range.low) : 0;
  return static_cast<uint32_t>(std::lround(std::clamp(share, 0.0, 1.0) * steps));
}
float unrounded(uint32_t q, const CodedSplats::Range& range, uint32_t steps) {
  return static_cast<float>(range.low + q * (range.high - range.low) / steps);
}

/// The largest component, made positive, follows from the other three, which lie within 1 / sqrt(2).
uint32_t packed_rotation(const Vec4f& wxyz) {
  Vec4f q = wxyz.norm() > 0 ? Vec4f(wxyz.normalized()) : Vec4f(1, 0, 0, 0);
  int largest = 0;
  for (int k = 1; k < 4; ++k)
    if (std::abs(q[k]) > std::abs(q[largest])) largest = k;
  if (q[largest] < 0) q = -q;
  uint32_t packed = static_cast<uint32_t>(largest) << 30;
  for (int k = 0, shift = 0; k < 4; ++k) {
    if (k == largest) continue;
    packed |= rounded(q[k] * M_SQRT2, {-1, 1}, kQuaternionSteps) << shift;
    shift += 10;
  }
  return packed;
}

Vec4f unpacked_rotation(uint32_t packed) {
  const int largest = static_cast<int>(packed >> 30);
  Vec4f q = Vec4f::Zero();
  for (int k = 0, shift = 0; k < 4; ++k) {
    if (k == largest) continue;
    q[k] = unrounded(packed >> shift & 1023, {-1, 1}, kQuaternionSteps) / static_cast<float>(M_SQRT2);
    shift += 10;
  }
  q[largest] = std::sqrt(std::max(0.0f, 1 - q.squaredNorm()));
  return q;
}

/// The Gaussians that are drawn; all where none is.
std::vector<size_t> drawn_of(const GaussianCloud& cloud) {
  std::vector<size_t> drawn, all;
  for (size_t i = 0; i < cloud.size(); ++i) {
    if (sigmoid(cloud.opacity_logit[i]) >= kLeastAlpha) drawn.push_back(i);
    all.push_back(i);
  }
  return drawn.empty() ? all : drawn;
}

/// Of all values but a share of `rare` at either end, within [low, high].
CodedSplats::Range range_of(const std::vector<float>& values, double rare, double low, double high) {
  if (values.empty()) return {};
  return {std::clamp<double>(quantile(values, rare), low, high),
          std::clamp<double>(quantile(values, 1 - rare), low, high)};
}

void code_positions(const GaussianCloud& cloud, CodedSplats& out) {
  for (size_t begin = 0; begin < cloud.size(); begin += kSplatChunk) {
    const size_t end = std::min(cloud.size(), begin + kSplatChunk);
    Box box;
    for (size_t i = begin; i < end; ++i) box.add(cloud.position[i]);
    for (int a = 0; a < 3; ++a) {
      out.chunk_low.push_back(box.low[a]);
      out.chunk_size.push_back(box.size()[a]);
    }
    for (size_t i = begin; i < end; ++i)
      for (int a = 0; a < 3; ++a)
        out.position.push_back(static_cast<uint16_t>(rounded(cloud.position[i][a], {box.low[a], box.high[a]}, 65535)));
  }
}

/// Of all coefficients but the rarest, and symmetric, so that zero is hit within half a step.
CodedSplats::Range sh_range(const std::vector<float>& coefficients) {
  std::vector<float> size;
  for (const float c : coefficients) size.push_back(std::abs(c));
  if (size.empty()) return {};
  const float largest = quantile(std::move(size), 1 - kRare);
  return {-largest, largest};
}

}  // namespace

CodedSplats code_splats(const SplatCoding& coding, const GaussianCloud& given) {
  const GaussianCloud cloud = given.sh_degree > coding.sh_degree ? with_sh_degree(given, coding.sh_degree) : given;
  CodedSplats out;
  out.coding = {cloud.sh_degree, coding.fine};
  code_positions(cloud, out);
  const size_t n = cloud.size(), coefficients = 3 * static_cast<size_t>(cloud.sh_count());
  const uint32_t steps = steps_of(coding);
  std::vector<float> log_scales, colours, rest;
  for (const size_t i : drawn_of(cloud))
    for (int a = 0; a < 3; ++a) {
      log_scales.push_back(cloud.log_scale[i][a]);
      colours.push_back(cloud.sh_of(i)[a]);
    }
  out.log_scale_range = range_of(log_scales, 0, kLowestLogScale, INFINITY);
  out.colour_range = range_of(colours, kRare, -kFarthestColour, kFarthestColour);
  for (size_t i = 0; i < n; ++i) {
    for (int a = 0; a < 3; ++a) {
      out.log_scale.push_back(static_cast<uint16_t>(rounded(cloud.log_scale[i][a], out.log_scale_range, steps)));
      out.colour.push_back(static_cast<uint16_t>(rounded(cloud.sh_of(i)[a], out.colour_range, steps)));
    }
    out.opacity.push_back(static_cast<uint16_t>(rounded(sigmoid(cloud.opacity_logit[i]), out.opacity_range, steps)));
    out.rotation.push_back(packed_rotation(cloud.rotation[i]));
    rest.insert(rest.end(), cloud.sh_of(i) + 3, cloud.sh_of(i) + coefficients);
  }
  out.sh_range = sh_range(rest);
  for (const float c : rest) out.sh.push_back(static_cast<uint8_t>(rounded(c, out.sh_range, 255)));
  return out;
}

GaussianCloud decoded(const CodedSplats& splats) {
  GaussianCloud cloud;
  cloud.sh_degree = splats.coding.sh_degree;
  cloud.resize(splats.size());
  const uint32_t steps = steps_of(splats.coding);
  const size_t rest = 3 * (static_cast<size_t>(cloud.sh_count()) - 1);
  for (size_t i = 0; i < splats.size(); ++i) {
    for (int a = 0; a < 3; ++a) {
      const size_t chunk = i / kSplatChunk * 3 + a;
      cloud.position[i][a] = splats.chunk_low[chunk] + splats.position[3 * i + a] / 65535.0f * splats.chunk_size[chunk];
      cloud.log_scale[i][a] = unrounded(splats.log_scale[3 * i + a], splats.log_scale_range, steps);
      cloud.sh_of(i)[a] = unrounded(splats.colour[3 * i + a], splats.colour_range, steps);
    }
    constexpr float kEdge = 1e-6f;  // logits are finite
    cloud.opacity_logit[i] =
        logit(std::clamp(unrounded(splats.opacity[i], splats.opacity_range, steps), kEdge, 1 - kEdge));
    cloud.rotation[i] = unpacked_rotation(splats.rotation[i]);
    for (size_t k = 0; k < rest; ++k) cloud.sh_of(i)[3 + k] = unrounded(splats.sh[i * rest + k], splats.sh_range, 255);
  }
  return cloud;
}

void add_splats(ClipFile& clip, const std::string& prefix, const CodedSplats& splats) {
  const size_t n = splats.size(), chunks = splats.chunk_low.size() / 3;
  const auto add = [&](const char* name, std::vector<size_t> shape, auto values, std::vector<double> range = {}) {
    using V = typename decltype(values)::value_type;
    clip.add(prefix, prefix + "." + name, shape, std::span<const V>(values), range);
  };
  const auto add_rounded = [&](const char* name, std::vector<size_t> shape, const std::vector<uint16_t>& values,
                               const CodedSplats::Range& range) {
    const std::vector<double> ends = {range.low, range.high};
    if (splats.coding.fine)
      add(name, shape, values, ends);
    else
      add(name, shape, std::vector<uint8_t>(values.begin(), values.end()), ends);
  };
  add("chunk_low", {chunks, 3}, splats.chunk_low);
  add("chunk_size", {chunks, 3}, splats.chunk_size);
  add("position", {n, 3}, splats.position);
  add("rotation", {n}, splats.rotation);
  add_rounded("log_scale", {n, 3}, splats.log_scale, splats.log_scale_range);
  add_rounded("colour", {n, 3}, splats.colour, splats.colour_range);
  add_rounded("opacity", {n}, splats.opacity, splats.opacity_range);
  if (n > 0 && !splats.sh.empty())
    add("sh", {n, splats.sh.size() / n / 3, 3}, splats.sh, {splats.sh_range.low, splats.sh_range.high});
  clip.header[prefix] = {{"splats", n}, {"sh_degree", splats.coding.sh_degree}};
}

}  // namespace pliant

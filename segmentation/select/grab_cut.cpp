#include "segmentation/select/grab_cut.h"

#include <algorithm>
#include <cmath>

#include "gaussians/base/error.h"
#include "segmentation/graph/min_cut.h"

namespace pliant {
namespace {

constexpr float kHard = 1e4f;         // gain of a pixel whose label is given
constexpr size_t kFewestPixels = 20;  // a colour model needs more than a few

/// The middle of the levels between which each pixel flips.  Cuts with more log odds contain those with less (Gallo,
/// Grigoriadis and Tarjan 1989).
std::vector<float> logits_of(const std::vector<float>& levels, const GrabCutInput& input,
                             const std::vector<uint8_t>& label, const std::vector<float>& gain, MinCut& cut) {
  std::vector<float> logit(label.size()), shifted(label.size());
  for (size_t i = 0; i < label.size(); ++i) logit[i] = label[i] ? 0.5f * levels[0] : -0.5f * levels[0];
  for (size_t k = 0; k < levels.size(); ++k) {
    const float beyond = k + 1 < levels.size() ? 0.5f * (levels[k] + levels[k + 1]) : levels[k] + 1;
    for (const float sign : {1.0f, -1.0f}) {
      for (size_t i = 0; i < gain.size(); ++i)
        shifted[i] = input.seed[i] == PixelSeed::kUnknown ? gain[i] + sign * levels[k] : gain[i];
      const std::vector<uint8_t> other = cut.labels(shifted);
      for (size_t i = 0; i < gain.size(); ++i)
        if (label[i] == (sign < 0) && other[i] == label[i]) logit[i] = label[i] ? beyond : -beyond;
    }
  }
  return logit;
}

}  // namespace

std::vector<Vec3f> lab_pixels(const ImageF& rgb) {
  std::vector<Vec3f> lab(rgb.pixels());
  for (size_t i = 0; i < lab.size(); ++i) lab[i] = lab_of_rgb(Eigen::Map<const Vec3f>(rgb.data.data() + 3 * i));
  return lab;
}

std::vector<CutEdge> picture_edges(int width, int height, const std::vector<Vec3f>& lab) {
  constexpr int kStep[4][2] = {{1, 0}, {0, 1}, {1, 1}, {-1, 1}};
  std::vector<CutEdge> edges;
  edges.reserve(lab.size() * 4);
  double sum = 0;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (const auto& [dx, dy] : kStep) {
        if (x + dx < 0 || x + dx >= width || y + dy >= height) continue;
        const int a = y * width + x, b = (y + dy) * width + x + dx;
        edges.push_back({a, b, (lab[a] - lab[b]).squaredNorm()});
        sum += edges.back().weight;
      }
  const double beta = sum > 0 ? 0.5 * static_cast<double>(edges.size()) / sum : 0;
  for (CutEdge& edge : edges) {
    const bool diagonal = edge.b - edge.a != 1 && edge.b - edge.a != width;
    edge.weight = std::exp(static_cast<float>(-beta) * edge.weight) * (diagonal ? 0.70710678f : 1.0f);
  }
  return edges;
}

GrabCutResult grab_cut(const GrabCutOptions& options, const GrabCutInput& input) {
  const bool regions = !input.area.empty();
  const size_t n = regions ? input.area.size() : static_cast<size_t>(input.width) * input.height;
  CHECK(input.lab.size() == n && input.seed.size() == n && (input.prior.empty() || input.prior.size() == n) &&
        (input.start.empty() || input.start.size() == n));
  GrabCutResult result;
  std::vector<uint8_t>& label = result.foreground;
  label.resize(n);
  for (size_t i = 0; i < n; ++i)
    label[i] = input.seed[i] == PixelSeed::kForeground ||
               (input.seed[i] == PixelSeed::kUnknown && (input.start.empty() || input.start[i]));

  std::vector<CutEdge> edges = regions ? input.edges : picture_edges(input.width, input.height, input.lab);
  for (CutEdge& edge : edges) edge.weight *= options.gamma;
  MinCut cut(n, edges);
  ColorModel models[2];
  std::vector<float> gain(n);
  for (; result.iterations < options.iterations; ++result.iterations) {
    std::vector<Vec3f> colors[2];
    std::vector<float> weights[2];
    for (size_t i = 0; i < n; ++i) {
      colors[label[i]].push_back(input.lab[i]);
      if (regions) weights[label[i]].push_back(input.area[i]);
    }
    if (std::min(colors[0].size(), colors[1].size()) < kFewestPixels) break;
    for (int side = 0; side < 2; ++side)
      models[side] = ColorModel::fit(options.color, colors[side], weights[side], &models[side]);
    const std::vector<float> object = models[1].log_density(input.lab), rest = models[0].log_density(input.lab);
    for (size_t i = 0; i < n; ++i) {
      if (input.seed[i] == PixelSeed::kUnknown) {
        gain[i] = options.data * (object[i] - rest[i]);
        if (!input.prior.empty()) gain[i] += input.prior[i];
        if (regions) gain[i] *= input.area[i];
      } else {
        gain[i] = input.seed[i] == PixelSeed::kForeground ? kHard : -kHard;
      }
    }
    std::vector<uint8_t> next = cut.labels(gain);
    size_t moved = 0;
    for (size_t i = 0; i < n; ++i) moved += next[i] != label[i];
    label = std::move(next);
    if (moved * 2000 < n) {
      ++result.iterations;
      break;
    }
  }
  for (uint8_t l : label) result.pixels += l;
  if (!options.levels.empty()) result.logit = logits_of(options.levels, input, label, gain, cut);
  return result;
}

}  // namespace pliant

#include "segmentation/select/region_view.h"

#include <algorithm>
#include <cmath>

#include "gaussians/base/error.h"
#include "gaussians/render/blend_weights.h"
#include "segmentation/graph/color_model.h"
#include "segmentation/select/grab_cut.h"
#include "segmentation/select/superpixels.h"

namespace pliant {
namespace {

/// Sums of the edges between pixels of different regions.
std::vector<CutEdge> region_edges(const std::vector<CutEdge>& pixels, const std::vector<uint16_t>& region) {
  std::vector<CutEdge> edges;
  for (const CutEdge& e : pixels) {
    const int a = region[e.a], b = region[e.b];
    if (a != b) edges.push_back({std::min(a, b), std::max(a, b), e.weight});
  }
  std::stable_sort(edges.begin(), edges.end(),
                   [](const CutEdge& x, const CutEdge& y) { return x.a != y.a ? x.a < y.a : x.b < y.b; });
  size_t count = 0;
  for (const CutEdge& e : edges) {
    if (count > 0 && edges[count - 1].a == e.a && edges[count - 1].b == e.b)
      edges[count - 1].weight += e.weight;
    else
      edges[count++] = e;
  }
  edges.resize(count);
  return edges;
}

}  // namespace

RegionView region_view(const RegionViewOptions& options, const GaussianCloud& cloud, const WindowView& window) {
  RegionView out{window, {}, {}, {}, {}, {}, {}, {}, {}};
  const int width = window.camera.width, height = window.camera.height;
  const RenderOptions drawing = options.render.within(window.frame);
  const std::vector<Vec3f> lab = lab_pixels(render(cloud, window.camera, drawing).color);
  out.region = superpixels(width, height, lab, options.area, options.color);
  const size_t count = 1 + *std::max_element(out.region.begin(), out.region.end());
  out.lab.assign(count, Vec3f::Zero());
  out.area.assign(count, 0.0f);
  out.middle.assign(count, Vec2f::Zero());
  std::vector<uint32_t> start(count + 1, 0);
  for (size_t i = 0; i < lab.size(); ++i) {
    const uint16_t r = out.region[i];
    out.lab[r] += lab[i];
    out.area[r] += 1;
    out.middle[r] += Vec2f(static_cast<float>(i % width) + 0.5f, static_cast<float>(i / width) + 0.5f);
    ++start[r + 1];
  }
  for (size_t r = 0; r < count; ++r) {
    out.lab[r] /= std::max(1.0f, out.area[r]);
    out.middle[r] /= std::max(1.0f, out.area[r]);
    start[r + 1] += start[r];
  }
  out.edges = region_edges(picture_edges(width, height, lab), out.region);

  std::vector<uint32_t> pixels(lab.size()), next(start.begin(), start.end() - 1);
  for (size_t i = 0; i < lab.size(); ++i) pixels[next[out.region[i]]++] = static_cast<uint32_t>(i);
  const BlendWeights weights = blend_weights(cloud, window.camera, drawing);
  std::vector<float> sum(cloud.size(), 0.0f);
  std::vector<uint32_t> seen;
  out.row_start.push_back(0);
  for (size_t r = 0; r < count; ++r) {
    seen.clear();
    for (uint32_t k = start[r]; k < start[r + 1]; ++k)
      for (uint32_t e = weights.row_start[pixels[k]]; e < weights.row_start[pixels[k] + 1]; ++e) {
        float& w = sum[weights.gaussian[e]];
        if (w == 0 && weights.weight[e] > 0) seen.push_back(weights.gaussian[e]);
        w += weights.weight[e];
      }
    std::sort(seen.begin(), seen.end());
    for (const uint32_t p : seen) {
      if (sum[p] >= options.least * out.area[r]) {
        out.gaussian.push_back(p);
        out.weight.push_back(sum[p]);
      }
      sum[p] = 0;
    }
    out.row_start.push_back(static_cast<uint32_t>(out.gaussian.size()));
  }
  return out;
}

}  // namespace pliant

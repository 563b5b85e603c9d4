#include "segmentation/associate/footprint.h"

#include <algorithm>
#include <tuple>
#include <unordered_map>

#include "gaussians/base/error.h"
#include "gaussians/base/portable.h"
#include "gaussians/base/random.h"

namespace pliant {

std::vector<size_t> used_views(const std::vector<int>& held_out, const std::vector<Camera>& cameras,
                               const MaskSet& masks) {
  std::vector<size_t> order;
  for (size_t v = 0; v < masks.views.size(); ++v) {
    const int camera = masks.views[v].camera;
    CHECK(camera >= 0 && camera < static_cast<int>(cameras.size()));
    if (!std::count(held_out.begin(), held_out.end(), camera)) order.push_back(v);
  }
  std::sort(order.begin(), order.end(), [&](size_t a, size_t b) {
    const int i = masks.views[a].camera, j = masks.views[b].camera;
    return std::tie(cameras[i].name, i) < std::tie(cameras[j].name, j);
  });
  return order;
}

std::vector<int> masks_of_pixels(const IdImage& ids, std::vector<uint32_t>& id) {
  std::unordered_map<uint32_t, int> index;
  std::vector<int> mask(ids.data.size(), -1);
  id.clear();
  for (size_t i = 0; i < mask.size(); ++i) {
    if (ids.data[i] == 0) continue;
    const auto [it, fresh] = index.try_emplace(ids.data[i], static_cast<int>(id.size()));
    if (fresh) id.push_back(ids.data[i]);
    mask[i] = it->second;
  }
  return mask;
}

ViewFootprints footprints(const FootprintOptions& options, const GaussianCloud& cloud, const Camera& camera,
                          const MaskSet::View& view) {
  return footprints(options, blend_weights(cloud, camera, options.render), cloud.size(), view);
}

ViewFootprints footprints(const FootprintOptions& options, const BlendWeights& weights, size_t gaussians,
                          const MaskSet::View& view) {
  ViewFootprints out;
  out.camera = view.camera;
  const std::vector<int> mask = masks_of_pixels(view.ids, out.id);
  out.pixels.assign(out.id.size(), 0);
  for (int m : mask)
    if (m >= 0) ++out.pixels[m];

  // Majority mask of every Gaussian by weight: one pass proposes it (Boyer and Moore 1991), a second one weighs it.
  std::vector<float> total(gaussians, 0.0f), lead(gaussians, 0.0f), own(gaussians, 0.0f);
  std::vector<int> candidate(gaussians, -1);
  for (size_t pixel = 0; pixel < mask.size(); ++pixel)
    for (uint32_t e = weights.row_start[pixel]; e < weights.row_start[pixel + 1]; ++e) {
      const uint32_t p = weights.gaussian[e];
      const float w = weights.weight[e];
      total[p] += w;
      if (candidate[p] == mask[pixel])
        lead[p] += w;
      else if (lead[p] >= w)
        lead[p] -= w;
      else {
        candidate[p] = mask[pixel];
        lead[p] = w - lead[p];
      }
    }
  for (size_t pixel = 0; pixel < mask.size(); ++pixel)
    for (uint32_t e = weights.row_start[pixel]; e < weights.row_start[pixel + 1]; ++e)
      if (candidate[weights.gaussian[e]] == mask[pixel]) own[weights.gaussian[e]] += weights.weight[e];
  // Before an empty background, the rims of things are all that its mask would stand on.
  std::vector<double> cover(out.id.size(), 0.0);
  for (size_t p = 0; p < gaussians; ++p)
    if (candidate[p] >= 0) cover[candidate[p]] += own[p];
  for (size_t p = 0; p < gaussians; ++p) {
    if (total[p] < options.least_mass) continue;
    const int m = candidate[p];
    const bool stands =
        m >= 0 && own[p] >= options.decisive * total[p] && cover[m] >= options.least_cover * out.pixels[m];
    out.gaussian.push_back(static_cast<uint32_t>(p));
    out.mask.push_back(stands ? m : -1);
    out.mass.push_back(total[p]);
  }
  return out;
}

namespace {

/// The labelled Gaussians of a view that are compared, and the weight of every mask on them.
struct Sample {
  std::vector<uint32_t> gaussian;
  std::vector<int> mask;
  std::vector<float> mass, of_mask;
};

Sample sample_of(const ViewFootprints& view, double rate) {
  Sample sample;
  sample.of_mask.assign(view.masks(), 0.0f);
  for (size_t e = 0; e < view.gaussian.size(); ++e) {
    if (view.mask[e] < 0 || (rate < 1 && Random(0, view.gaussian[e]).uniform() >= rate)) continue;
    sample.gaussian.push_back(view.gaussian[e]);
    sample.mask.push_back(view.mask[e]);
    sample.mass.push_back(view.mass[e]);
    sample.of_mask[view.mask[e]] += view.mass[e];
  }
  return sample;
}

/// What two views see of the same Gaussians.
struct Common {
  size_t columns = 0;
  std::vector<float> both;                  ///< I_ij [masks of a, masks of b]
  std::vector<float> of_a, of_b;            ///< I_i., I_.j
  std::vector<float> seen_of_a, seen_of_b;  ///< mass of a mask's Gaussians, in its own view, that the other view labels
};

Common compare(const Sample& a, const Sample& b) {
  Common common;
  const size_t rows = a.of_mask.size(), columns = common.columns = b.of_mask.size();
  common.both.assign(rows * columns, 0.0f);
  common.of_a.assign(rows, 0.0f);
  common.seen_of_a.assign(rows, 0.0f);
  common.of_b.assign(columns, 0.0f);
  common.seen_of_b.assign(columns, 0.0f);
  for (size_t e = 0, f = 0; e < a.gaussian.size() && f < b.gaussian.size();) {
    if (a.gaussian[e] < b.gaussian[f]) {
      ++e;
    } else if (a.gaussian[e] > b.gaussian[f]) {
      ++f;
    } else {
      const float mass = std::min(a.mass[e], b.mass[f]);
      const int i = a.mask[e], j = b.mask[f];
      common.both[i * columns + j] += mass;
      common.of_a[i] += mass;
      common.of_b[j] += mass;
      common.seen_of_a[i] += a.mass[e];
      common.seen_of_b[j] += b.mass[f];
      ++e;
      ++f;
    }
  }
  return common;
}

}  // namespace

MaskRelations relate(const RelationOptions& options, std::span<const ViewFootprints> views) {
  const int V = static_cast<int>(views.size());
  MaskRelations out;
  out.first.assign(1, 0);
  double entries = 0;
  for (const ViewFootprints& view : views) {
    out.first.push_back(out.first.back() + static_cast<int>(view.masks()));
    entries += static_cast<double>(view.gaussian.size());
  }
  out.container.assign(static_cast<size_t>(out.masks()) * V, MaskRelations::kUnseen);
  out.nearest = out.container;
  const double steps = entries * V, rate = steps > options.most_steps ? options.most_steps / steps : 1.0;
  std::vector<Sample> samples(V);
  parallel_for(V, [&](std::ptrdiff_t v) { samples[v] = sample_of(views[v], rate); });

  parallel_for(static_cast<std::ptrdiff_t>(V) * V, [&](std::ptrdiff_t pair) {
    const int u = static_cast<int>(pair / V), v = static_cast<int>(pair % V);
    if (u >= v) return;
    const Common common = compare(samples[u], samples[v]);
    // Row by row for the masks of u, column by column for those of v.
    const auto place = [&](int own, int other, size_t i, float whole, float seen, float shared, auto&& both,
                           const std::vector<float>& of_other) {
      if (!(seen > 0) || seen < options.observed * whole) return;
      const size_t slot = static_cast<size_t>(out.first[own] + i) * V + other;
      float most = -1, nearest = -1;
      for (size_t j = 0; j < of_other.size(); ++j) {
        const float overlap = both(j), jaccard = overlap > 0 ? overlap / (shared + of_other[j] - overlap) : 0.0f;
        if (overlap > most) {
          most = overlap;
          out.container[slot] =
              overlap >= options.contained * shared ? out.first[other] + static_cast<int>(j) : MaskRelations::kDivided;
        }
        if (jaccard > nearest) {
          nearest = jaccard;
          out.nearest[slot] = out.first[other] + static_cast<int>(j);
        }
      }
    };
    for (size_t i = 0; i < common.of_a.size(); ++i)
      place(
          u, v, i, samples[u].of_mask[i], common.seen_of_a[i], common.of_a[i],
          [&](size_t j) { return common.both[i * common.columns + j]; }, common.of_b);
    for (size_t j = 0; j < common.of_b.size(); ++j)
      place(
          v, u, j, samples[v].of_mask[j], common.seen_of_b[j], common.of_b[j],
          [&](size_t i) { return common.both[i * common.columns + j]; }, common.of_a);
  });
  for (int v = 0; v < V; ++v)
    for (int m = out.first[v]; m < out.first[v + 1]; ++m)
      out.container[static_cast<size_t>(m) * V + v] = out.nearest[static_cast<size_t>(m) * V + v] = m;
  return out;
}

double id_consistency(const MaskRelations& relations, std::span<const ViewFootprints> views) {
  const int V = relations.views();
  std::vector<uint32_t> id;
  for (const ViewFootprints& view : views) id.insert(id.end(), view.id.begin(), view.id.end());
  size_t compared = 0, equal = 0;
  for (int v = 0; v < V; ++v)
    for (int m = relations.first[v]; m < relations.first[v + 1]; ++m)
      for (int other = 0; other < V; ++other) {
        const int nearest = relations.nearest_of(m, other);
        if (other == v || nearest < 0) continue;
        ++compared;
        equal += id[m] == id[nearest];
      }
  return compared > 0 ? static_cast<double>(equal) / static_cast<double>(compared) : 1.0;
}

}  // namespace pliant

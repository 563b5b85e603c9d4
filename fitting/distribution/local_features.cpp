#include "fitting/distribution/local_features.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>

#include "fitting/distribution/support_paths.h"
#include "gaussians/base/error.h"
#include "gaussians/base/nearest.h"
#include "gaussians/base/portable.h"
#include "physics/body/thin_parts.h"

namespace pliant {
namespace {

constexpr size_t kMostKept = 1000;    // samples that stand for the object
constexpr float kBand = 0.05f;        // of height, and of the size around a vertical: what lies beside a sample
constexpr float kSameColour = 0.12f;  // distance in sRGB
constexpr float kThinnest = 1e-3f, kThickest = 0.3f;  // thickness as a share of the size

float log_share(float share) { return std::log10(std::clamp(share, 1e-5f, 1.0f)); }

/// The object as the features see it: the kept samples in a frame of lengths 1.
struct Kept {
  float size = 1;  // metres
  std::vector<int> index;
  std::vector<Vec3f> place, colour;              // place / size
  std::vector<float> volume, height, thickness;  // shares of the whole, of the size, of the size
  std::vector<Vec3f> flat;                       // from the axis, across up
  float tallness = 0;
};

std::vector<float> log_thickness(const SolidSamples& samples, float size) {
  std::vector<float> out(samples.size(), std::log10(kThickest));
  for (size_t i = 0; i < samples.thickness.size(); ++i)
    if (samples.thickness[i] > 0) out[i] = std::log10(std::clamp(samples.thickness[i] / size, kThinnest, kThickest));
  return out;
}

/// Diameter about the axis through the centre, or the height if that is larger.
float size_of(const SolidSamples& samples, const Vec3f& up) {
  Vec3d centre = Vec3d::Zero();
  for (const Vec3f& x : samples.position) centre += x.cast<double>() / static_cast<double>(samples.size());
  float low = INFINITY, high = -INFINITY, wide = 0;
  for (const Vec3f& x : samples.position) {
    const Vec3f d = x - centre.cast<float>();
    const float h = d.dot(up);
    low = std::min(low, h);
    high = std::max(high, h);
    wide = std::max(wide, (d - h * up).norm());
  }
  return std::max({high - low, 2 * wide, 1e-6f});
}

Kept keep(const FeatureInput& o, const Vec3f& up) {
  Kept k;
  const size_t m = o.samples.size(), n = std::min(m, kMostKept);
  k.size = size_of(o.samples, up);
  double total = 0;
  for (size_t i = 0; i < n; ++i) {
    k.index.push_back(static_cast<int>(i * m / n));
    total += o.samples.volume[k.index[i]];
  }
  Vec3d centre = Vec3d::Zero();
  const std::vector<float> thickness = log_thickness(o.samples, k.size);
  for (const int i : k.index) {
    k.volume.push_back(static_cast<float>(o.samples.volume[i] / total));
    centre += o.samples.volume[i] / total * o.samples.position[i].cast<double>();
    k.colour.push_back(o.colour[i]);
    k.thickness.push_back(thickness[i]);
  }
  for (const int i : k.index) {
    const Vec3f d = (o.samples.position[i].cast<double>() - centre).cast<float>() / k.size;
    k.place.push_back(d);
    k.height.push_back(d.dot(up));
    k.flat.push_back(d - d.dot(up) * up);
  }
  const float low = *std::min_element(k.height.begin(), k.height.end());
  for (float& h : k.height) h -= low;
  k.tallness = std::max(1e-3f, *std::max_element(k.height.begin(), k.height.end()));
  return k;
}

float luminance(const Vec3f& c) { return 0.299f * c.x() + 0.587f * c.y() + 0.114f * c.z(); }

/// Shape and looks of the neighbourhood of one kept sample: 8 + 4 numbers.
void describe_neighbours(const Kept& k, const Vec3f& up, size_t i, const std::vector<NearestPoints::Hit>& hits,
                         std::vector<float>& out) {
  const Spread spread = spread_of(k.place, hits);
  const float largest = std::max(spread.value[2], 1e-12f);
  const float n = static_cast<float>(hits.size());
  Vec3f mean = Vec3f::Zero(), colour = Vec3f::Zero();
  float thickness = 0, height = 0;
  for (const auto& hit : hits) {
    mean += k.place[hit.index] / n;
    colour += k.colour[hit.index] / n;
    thickness += k.thickness[hit.index] / n;
    height += k.height[hit.index] / n;
  }
  const float reach = std::max(std::sqrt(spread.value.sum()), 1e-6f);
  const Vec3f shift = (mean - k.place[i]) / reach;  // toward where there is more of it: away from a surface
  const Vec3f outward = k.flat[i].norm() > 1e-6f ? Vec3f(k.flat[i].normalized()) : Vec3f::Zero();
  float variation = 0;
  for (const auto& hit : hits) variation += (k.colour[hit.index] - colour).squaredNorm() / n;
  out.insert(out.end(),
             {std::sqrt(std::max(0.0f, spread.value[1]) / largest),
              std::sqrt(std::max(0.0f, spread.value[0]) / largest), std::abs(spread.axes.col(2).dot(up)),
              std::abs(spread.axes.col(0).dot(up)), std::log10(reach), shift.norm(), shift.dot(up), shift.dot(outward),
              std::sqrt(variation), (k.colour[i] - colour).norm(), k.thickness[i] - thickness, k.height[i] - height});
}

/// What lies around one kept sample at its height, above it, and in its colour.
std::array<float, 4> describe_place(const Kept& k, size_t i) {
  float beside = 0, inner = 0, column = 0, above = 0, same = 0, same_height = 0;
  for (size_t j = 0; j < k.index.size(); ++j) {
    if (std::abs(k.height[j] - k.height[i]) <= kBand * k.tallness) {
      ++beside;
      inner += k.flat[j].norm() < k.flat[i].norm();
    }
    if ((k.flat[j] - k.flat[i]).norm() <= kBand) {
      ++column;
      above += k.height[j] > k.height[i];
    }
    if ((k.colour[j] - k.colour[i]).norm() <= kSameColour) {
      same += k.volume[j];
      same_height += k.volume[j] * k.height[j];
    }
  }
  return {inner / beside, above / column, log_share(same), same_height / std::max(same, 1e-9f) - k.height[i]};
}

/// Statistics of the parts, [parts] x kPartFeatures as differences from the whole object.
std::map<int, std::vector<float>> describe_parts(const FeatureInput& o, const Kept& k) {
  struct Sum {
    double volume = 0, height = 0, thickness = 0, radius = 0;
    Vec3d colour = Vec3d::Zero();
  };
  Sum whole;
  std::map<int, Sum> parts;
  for (size_t i = 0; i < k.index.size(); ++i)
    for (Sum* s : {&whole, &parts[o.part.empty() ? 0 : o.part[k.index[i]]]}) {
      s->volume += k.volume[i];
      s->height += k.volume[i] * k.height[i];
      s->thickness += k.volume[i] * k.thickness[i];
      s->radius += k.volume[i] * k.flat[i].norm();
      s->colour += k.volume[i] * k.colour[i].cast<double>();
    }
  std::map<int, std::vector<float>> out;
  for (const auto& [label, s] : parts) {
    const double v = std::max(s.volume, 1e-12);
    const double differences[] = {s.height / v - whole.height, s.thickness / v - whole.thickness,
                                  s.radius / v - whole.radius};
    const Vec3d colour = s.colour / v - whole.colour;
    std::vector<float>& row = out[label];
    row = {parts.size() > 1 ? log_share(static_cast<float>(s.volume)) : 0.0f};
    for (const double d : differences) row.push_back(parts.size() > 1 ? static_cast<float>(d) : 0.0f);
    row.push_back(parts.size() > 1 ? static_cast<float>(colour.norm()) : 0.0f);
    row.push_back(parts.size() > 1 ? luminance(colour.cast<float>()) : 0.0f);
  }
  return out;
}

/// The object as a whole: 11 numbers after the prior's two.
std::vector<float> describe_whole(const Kept& k, const YoungPrior& prior, double volume) {
  Vec3f colour = Vec3f::Zero();
  float thickness = 0, thin = 0, spread = 0, wide = 0, low = 0;
  for (size_t i = 0; i < k.index.size(); ++i) {
    colour += k.volume[i] * k.colour[i];
    thickness += k.volume[i] * k.thickness[i];
    thin += k.volume[i] * (k.thickness[i] < std::log10(kThickest));
    wide += k.volume[i] * k.flat[i].norm();
    low += k.volume[i] * (k.height[i] < 0.3f * k.tallness);
  }
  for (size_t i = 0; i < k.index.size(); ++i) spread += k.volume[i] * (k.colour[i] - colour).squaredNorm();
  return {static_cast<float>(std::log10(prior.typical)),
          static_cast<float>(std::log10(prior.high / prior.low)),
          std::log10(k.size),
          static_cast<float>(std::log10(std::clamp(volume / std::pow(double{k.size}, 3), 1e-6, 1.0))),
          k.tallness,
          thickness,
          thin,
          wide,
          low,
          std::sqrt(spread),
          colour.x(),
          colour.y(),
          colour.z()};
}

}  // namespace

std::string_view feature_names() {
  return "height below_top height_share radius size_thickness thickness_in_metres red green blue redness greenness "
         "brightness difference_from_mean_colour brightness_over_mean path path_share path_over_height beyond "
         "beyond_nearby line plane line_up normal_up reach shift shift_up shift_out colour_variation colour_step "
         "thickness_step height_step wide_line wide_plane wide_line_up wide_normal_up wide_shift wide_shift_up "
         "wide_shift_out wide_colour_variation wide_colour_step inner_share above_share same_colour same_colour_height "
         "part_share part_height part_thickness part_radius part_colour part_brightness prior_typical prior_band "
         "log_size fill tallness mean_thickness thin_share mean_radius low_share colour_spread mean_red mean_green "
         "mean_blue";
}

std::vector<float> local_features(const FeatureInput& o) {
  const size_t m = o.samples.size();
  CHECK(m > 0 && o.samples.volume.size() == m && o.colour.size() == m && (o.part.empty() || o.part.size() == m));
  CHECK(o.prior.low > 0 && o.prior.low <= o.prior.high && o.prior.typical > 0);
  const Vec3f up = o.up.normalized();
  const Kept k = keep(o, up);
  const size_t n = k.index.size();
  const SupportPaths paths = support_paths(k.place, k.volume, k.height);
  const auto parts = describe_parts(o, k);
  const std::vector<float> whole = describe_whole(k, o.prior, o.samples.total_volume());
  const Vec3f mean_colour(whole[10], whole[11], whole[12]);
  const float longest = std::max(1e-6f, *std::max_element(paths.length.begin(), paths.length.end()));
  const int near = std::max<int>(8, static_cast<int>(n / 100)), far = std::max<int>(24, static_cast<int>(n / 20));
  const NearestPoints tree(k.place);

  // What needs neighbours is worked out for the kept samples.
  std::vector<std::vector<float>> around(n);
  parallel_for(
      static_cast<std::ptrdiff_t>(n),
      [&](std::ptrdiff_t i) {
        std::vector<NearestPoints::Hit> hits;
        std::vector<float>& row = around[i];
        tree.query(k.place[i], near, hits);
        float carried = 0;
        for (const auto& hit : hits) carried += log_share(paths.beyond[hit.index]) / static_cast<float>(hits.size());
        row = {paths.length[i], paths.length[i] / longest, paths.length[i] - k.height[i], log_share(paths.beyond[i]),
               carried};
        describe_neighbours(k, up, i, hits, row);
        tree.query(k.place[i], far, hits);
        std::vector<float> wide;
        describe_neighbours(k, up, i, hits, wide);
        for (const int c : {0, 1, 2, 3, 5, 6, 7, 8, 9}) row.push_back(wide[c]);
        for (const float value : describe_place(k, i)) row.push_back(value);
      },
      16);

  const std::vector<float> thickness = log_thickness(o.samples, k.size);
  Vec3f origin = o.samples.position[k.index[0]] - k.size * k.place[0];
  const float ground = (k.place[0].dot(up) - k.height[0]);
  std::vector<float> out(m * kFeatures);
  parallel_for(
      static_cast<std::ptrdiff_t>(m),
      [&](std::ptrdiff_t i) {
        const Vec3f x = (o.samples.position[i] - origin) / k.size, c = o.colour[i];
        const float height = x.dot(up) - ground;
        std::vector<NearestPoints::Hit> hits;
        tree.query(x, 1, hits);
        const std::vector<float>& nearest =
            around[m == n ? static_cast<size_t>(i) : static_cast<size_t>(hits[0].index)];
        float* row = out.data() + i * kFeatures;
        int at = 0;
        const auto put = [&](float value) { row[at++] = value; };
        put(height);
        put(k.tallness - height);
        put(height / k.tallness);
        put((x - x.dot(up) * up).norm());
        put(thickness[i]);
        put(thickness[i] + std::log10(k.size));
        for (int channel = 0; channel < 3; ++channel) put(c[channel]);
        put(c.x() - 0.5f * (c.y() + c.z()));
        put(c.y() - 0.5f * (c.x() + c.z()));
        put(luminance(c));
        put((c - mean_colour).norm());
        put(luminance(c - mean_colour));
        for (const float value : nearest) put(value);
        const auto part = parts.find(o.part.empty() ? 0 : o.part[i]);
        for (int p = 0; p < kPartFeatures; ++p) put(part == parts.end() ? 0.0f : part->second[p]);
        for (const float value : whole) put(value);
        CHECK(at == kFeatures);
      },
      64);
  return out;
}

}  // namespace pliant

#include "segmentation/labels/segmentation.h"

#include <algorithm>
#include <cmath>

#include "gaussians/base/error.h"
#include "gaussians/base/portable.h"
#include "gaussians/base/quantile.h"
#include "gaussians/render/render.h"

namespace pliant {
namespace {

constexpr int kY = kSemanticChannels;
using Attribute = Eigen::Map<const Eigen::Array<float, kY, 1>>;

/// Logit of class c for attribute y.
float class_logit(const Segmentation& s, size_t c, const float* y) {
  return s.classifier_bias[c] + (Attribute(s.classifier.data() + c * kY) * Attribute(y)).sum();
}

size_t best_class(const Segmentation& s, const float* y) {
  size_t best = 0;
  float largest = -INFINITY;
  for (size_t c = 0; c < s.class_id.size(); ++c)
    if (const float value = class_logit(s, c, y); value > largest) {
      largest = value;
      best = c;
    }
  return best;
}

}  // namespace

int class_of_id(const Segmentation& segmentation, uint32_t id) {
  const auto it = std::lower_bound(segmentation.class_id.begin(), segmentation.class_id.end(), id);
  return it != segmentation.class_id.end() && *it == id ? static_cast<int>(it - segmentation.class_id.begin()) : -1;
}

std::vector<float> class_probabilities(const Segmentation& segmentation, size_t i) {
  const float* y = segmentation.attribute.data() + i * kY;
  std::vector<float> probability(segmentation.class_id.size());
  for (size_t c = 0; c < probability.size(); ++c) probability[c] = class_logit(segmentation, c, y);
  const float largest = *std::max_element(probability.begin(), probability.end());
  float sum = 0;
  for (float& p : probability) sum += p = std::exp(p - largest);
  for (float& p : probability) p /= sum;
  return probability;
}

void update_labels(Segmentation& segmentation) {
  const size_t n = segmentation.attribute.size() / kY;
  segmentation.label.resize(n);
  segmentation.confidence.resize(n);
  parallel_for(
      static_cast<std::ptrdiff_t>(n),
      [&](std::ptrdiff_t p) {
        const std::vector<float> probability = class_probabilities(segmentation, p);
        const auto best = std::max_element(probability.begin(), probability.end());
        segmentation.label[p] = segmentation.class_id[best - probability.begin()];
        segmentation.confidence[p] = *best;
      },
      1024);
}

std::vector<ObjectEntry> list_objects(const Segmentation& segmentation, const std::vector<Vec3f>& position) {
  CHECK(segmentation.label.size() == position.size());
  std::vector<std::vector<int>> members(segmentation.class_id.size());
  for (size_t p = 0; p < position.size(); ++p)
    members[class_of_id(segmentation, segmentation.label[p])].push_back(static_cast<int>(p));
  std::vector<ObjectEntry> entries;
  for (size_t c = 0; c < members.size(); ++c) {
    ObjectEntry entry;
    entry.id = segmentation.class_id[c];
    entry.name = segmentation.class_name[c];
    entry.gaussians = members[c].size();
    if (c < segmentation.class_cameras.size()) entry.views = static_cast<int>(segmentation.class_cameras[c].size());
    if (c < segmentation.class_origin.size()) entry.origin = segmentation.class_origin[c];
    if (!members[c].empty()) {
      double score = 0;
      for (int p : members[c]) score += segmentation.confidence[p];
      entry.score = static_cast<float>(score / static_cast<double>(members[c].size()));
      std::vector<float> values(members[c].size());
      for (int axis = 0; axis < 3; ++axis) {
        for (size_t k = 0; k < values.size(); ++k) values[k] = position[members[c][k]][axis];
        entry.bounds.low[axis] = quantile(values, 0.02);
        entry.bounds.high[axis] = quantile(values, 0.98);
      }
    }
    entries.push_back(std::move(entry));
  }
  return entries;
}

IdImage render_ids(const Segmentation& segmentation, const GaussianCloud& cloud, const Camera& camera) {
  CHECK(segmentation.attribute.size() == cloud.size() * kY);
  RenderOptions options;
  options.antialiased = segmentation.antialiased;
  RenderOptions of_labels = options;
  of_labels.screen_variance = segmentation.screen_variance;
  const RenderResult picture = render(cloud, camera, of_labels, segmentation.attribute, kY);
  // Whether there is anything at all does not depend on the filter of labels.
  const bool same = of_labels.screen_variance == options.screen_variance;
  const ImageF solid = same ? ImageF() : render(cloud, camera, options).alpha;
  const ImageF& alpha = same ? picture.alpha : solid;
  IdImage ids(camera.width, camera.height, 1);
  parallel_for(
      camera.height,
      [&](std::ptrdiff_t y) {
        for (int x = 0; x < camera.width; ++x)
          if (alpha(x, y) >= 0.5f)
            ids(x, y) = segmentation.class_id[best_class(segmentation, picture.features.at(x, y))];
      },
      8);
  return ids;
}

void find_class_cameras(const GaussianCloud& cloud, const std::vector<Camera>& cameras, Segmentation& segmentation) {
  segmentation.class_cameras.assign(segmentation.class_id.size(), {});
  for (size_t camera = 0; camera < cameras.size(); ++camera) {
    const IdImage ids = render_ids(segmentation, cloud, cameras[camera]);
    std::vector<uint8_t> met(segmentation.class_id.size(), 0);
    for (uint32_t id : ids.data)
      if (const int c = class_of_id(segmentation, id); c >= 0) met[c] = 1;
    for (size_t c = 0; c < met.size(); ++c)
      if (met[c]) segmentation.class_cameras[c].push_back(static_cast<int>(camera));
  }
}

uint32_t unused_id(const Segmentation& segmentation) {
  const uint32_t above = segmentation.class_id.empty() ? 1 : segmentation.class_id.back() + 1;
  return std::max(above, segmentation.next_id);
}

IdAgreement id_agreement(std::span<const IdImage> predicted, std::span<const IdImage> truth) {
  CHECK(predicted.size() == truth.size());
  struct Count {
    size_t both = 0, predicted = 0, truth = 0;
  };
  std::map<uint32_t, Count> counts;
  for (size_t v = 0; v < truth.size(); ++v) {
    CHECK(predicted[v].width == truth[v].width && predicted[v].height == truth[v].height);
    for (size_t i = 0; i < truth[v].data.size(); ++i) {
      const uint32_t t = truth[v].data[i], p = predicted[v].data[i];
      if (t == 0) continue;
      ++counts[t].truth;
      ++counts[p].predicted;
      if (p == t) ++counts[t].both;
    }
  }
  IdAgreement agreement;
  for (const auto& [id, count] : counts) {
    if (count.truth == 0) continue;
    agreement.iou[id] =
        static_cast<double>(count.both) / static_cast<double>(count.predicted + count.truth - count.both);
    agreement.mean += agreement.iou[id];
  }
  if (!agreement.iou.empty()) agreement.mean /= static_cast<double>(agreement.iou.size());
  return agreement;
}

}  // namespace pliant

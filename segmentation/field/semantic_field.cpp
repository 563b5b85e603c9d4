#include "segmentation/field/semantic_field.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>

#include "gaussians/base/adam.h"
#include "gaussians/base/nearest.h"
#include "gaussians/base/random.h"
#include "segmentation/field/label_filter.h"
#include "segmentation/field/semantic_loss.h"
#include "segmentation/field/training_pixels.h"
#include "segmentation/field/vote.h"
#include "segmentation/labels/spread.h"

namespace pliant {
namespace {

/// Streams of random numbers, one per purpose.
enum Stream : uint64_t { kPixels = 1, kStart, kOrder, kAnchors, kPoints, kCodes };

/// A view that takes part: its chosen pixels, their classes, and W when it fits into memory.
struct TrainingView {
  int camera = -1;
  ChosenPixels chosen;
  CompactView weights;
  bool cached = false;
};

std::vector<std::vector<int>> cameras_of_classes(const MaskSet& masks, const std::vector<uint32_t>& class_id) {
  std::vector<std::vector<int>> cameras(class_id.size());
  for (const MaskSet::View& view : masks.views) {
    std::vector<uint8_t> met(class_id.size(), 0);
    for (int c : classes_of(view.ids, class_id))
      if (c >= 0) met[c] = 1;
    for (size_t c = 0; c < met.size(); ++c)
      if (met[c]) cameras[c].push_back(view.camera);
  }
  return cameras;
}

void start_from_noise(uint64_t seed, SemanticModel<float>& model) {
  parallel_for(
      static_cast<std::ptrdiff_t>(model.attribute.size() / kSemanticChannels),
      [&](std::ptrdiff_t p) {
        Random random(seed, p, kStart);
        for (int k = 0; k < kSemanticChannels; ++k)
          model.attribute[p * kSemanticChannels + k] = 0.3f * static_cast<float>(random.normal());
      },
      1024);
  Random random(seed, ~0ull, kStart);
  for (float& w : model.classifier) w = static_cast<float>(random.uniform(-0.25, 0.25));
}

/// Neighbours [N, k] among at most max_points Gaussians, and the Gaussians that may be anchors.
std::vector<int> grouping_graph(const SemanticOptions& options, const GaussianCloud& cloud, std::vector<int>& members) {
  members.resize(cloud.size());
  std::iota(members.begin(), members.end(), 0);
  if (members.size() > options.max_points) {
    Random random(options.seed, 0, kPoints);
    for (size_t i = 0; i < options.max_points; ++i)
      std::swap(members[i], members[i + random.below(members.size() - i)]);
    members.resize(options.max_points);
    std::sort(members.begin(), members.end());
  }
  std::vector<Vec3f> points(members.size());
  for (size_t i = 0; i < members.size(); ++i) points[i] = cloud.position[members[i]];
  const int k = options.neighbours;
  const std::vector<int> nearest = k_nearest(points, points, k + 1);
  std::vector<int> graph(cloud.size() * k, -1);
  for (size_t i = 0; i < members.size(); ++i) {
    int found = 0;
    for (int j = 0; j <= k && found < k; ++j) {
      const int other = nearest[i * (k + 1) + j];
      if (other >= 0 && other != static_cast<int>(i))
        graph[static_cast<size_t>(members[i]) * k + found++] = members[other];
    }
  }
  return graph;
}

/// Everything that the iterations share.
class Fit {
 public:
  Fit(const SemanticOptions& options, const GaussianCloud& cloud, const std::vector<Camera>& cameras)
      : options_(options), cloud_(cloud), cameras_(cameras) {}

  /// Weights of every view once: votes over all pixels, rows of the chosen pixels into the cache.
  void prepare(const MaskSet& masks, const std::vector<uint32_t>& class_id, ClassVotes& votes, SemanticSummary& summary,
               const SemanticProgress& progress) {
    total_.assign(cloud_.size(), 0.0f);
    double shown = 0, unlabelled = 0;  // opacity over all pixels, and over those without a class
    for (const MaskSet::View& mask : masks.views) {
      if (progress) progress(0, options_.iterations, 0);
      TrainingView view;
      view.camera = mask.camera;
      const BlendWeights weights = blend_weights(cloud_, cameras_[mask.camera], options_.render);
      for (size_t e = 0; e < weights.weight.size(); ++e) total_[weights.gaussian[e]] += weights.weight[e];
      const Camera& camera = cameras_[mask.camera];
      const std::vector<int> cls = classes_of(mask.ids, class_id);
      for (size_t pixel = 0; pixel < cls.size(); ++pixel) {
        const auto row = weights.weight.begin();
        const double opacity = std::accumulate(row + weights.row_start[pixel], row + weights.row_start[pixel + 1], 0.0);
        shown += opacity;
        if (cls[pixel] < 0) unlabelled += opacity;
      }
      const std::vector<int> certain =
          without_silhouettes(cls, depth_of(weights, cloud_, camera), camera, options_.border);
      votes.add(weights, certain);
      view.chosen =
          choose_pixels(options_.start_from_vote ? cls : certain, camera.width, camera.height, options_.pixel_stride,
                        options_.start_from_vote ? options_.edge : 0, Random(options_.seed, mask.camera, kPixels));
      if (view.chosen.pixels.empty()) continue;
      if (options_.iterations > 0 && summary.cached_bytes < options_.memory_bytes) {
        view.weights = compact_view(weights, view.chosen.pixels, cloud_.size());
        view.cached = summary.cached_bytes + view.weights.bytes() <= options_.memory_bytes;
        if (view.cached) {
          summary.cached_bytes += view.weights.bytes();
        } else {
          view.weights = {};
        }
      }
      views_.push_back(std::move(view));
    }
    summary.views = static_cast<int>(views_.size());
    if (shown > 0) summary.unlabelled = unlabelled / shown;
  }

  /// Whether enough of what the views show of Gaussian p, with blend weight `certain` on certain pixels, can be
  /// trusted.
  bool seen(size_t p, float certain) const {
    return certain >= options_.min_weight && certain >= options_.min_certain * total_[p];
  }

  void optimise(SemanticModel<float>& model, SemanticSummary& summary, const SemanticProgress& progress) {
    std::vector<int> members;
    const std::vector<int> graph = grouping_graph(options_, cloud_, members);
    SemanticModel<float> gradient;
    gradient.resize(cloud_.size(), model.classes);
    Adam<float> adam_y(model.attribute.size()), adam_w(model.classifier.size()), adam_b(model.bias.size());
    std::vector<int> order(views_.size()), anchors(std::min<size_t>(options_.anchors, members.size()));
    const int tail = std::max(1, options_.iterations / 10);
    for (int it = 0; it < options_.iterations; ++it) {
      const size_t turn = it % views_.size();
      if (turn == 0) shuffle(order, it);
      for (size_t a = 0; a < anchors.size(); ++a)
        anchors[a] = members[Random(options_.seed, a, (uint64_t(it) << 8) + kAnchors).below(members.size())];
      gradient.set_zero();
      const TrainingView& view = views_[order[turn]];
      const double cross_entropy =
          view.cached
              ? semantic_loss_adjoint(view.weights, std::span<const int>(view.chosen.target), model, gradient)
              : semantic_loss_adjoint(compact_view(blend_weights(cloud_, cameras_[view.camera], options_.render),
                                                   view.chosen.pixels, cloud_.size()),
                                      std::span<const int>(view.chosen.target), model, gradient);
      const double grouping = grouping_loss_adjoint<float>(anchors, graph, options_.neighbours,
                                                           static_cast<float>(options_.kl_weight), model, gradient);
      if (!std::isfinite(cross_entropy + grouping))
        throw numerical_error("segment", "the loss is not finite at iteration " + std::to_string(it),
                              "lower the learning rates");
      // Cosine from the full rate to a tenth of it.
      const double fall = 0.55 + 0.45 * std::cos(3.141592653589793 * it / options_.iterations);
      adam_y.step(model.attribute, gradient.attribute, static_cast<float>(options_.attribute_rate * fall));
      adam_w.step(model.classifier, gradient.classifier, static_cast<float>(options_.classifier_rate * fall));
      adam_b.step(model.bias, gradient.bias, static_cast<float>(options_.classifier_rate * fall));
      if (it >= options_.iterations - tail) {
        summary.cross_entropy += cross_entropy / tail;
        summary.grouping += grouping / tail;
      }
      if (progress) progress(it + 1, options_.iterations, cross_entropy + grouping);
    }
  }

 private:
  void shuffle(std::vector<int>& order, int epoch) const {
    std::iota(order.begin(), order.end(), 0);
    Random random(options_.seed, epoch, kOrder);
    for (size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random.below(i)]);
  }

  const SemanticOptions& options_;
  const GaussianCloud& cloud_;
  const std::vector<Camera>& cameras_;
  std::vector<TrainingView> views_;
  std::vector<float> total_;  ///< [N] blend weight over all pixels of all views
};

/// Silhouette pixels teach how strongly a Gaussian speaks, not what it is: attributes of Gaussians whose vote is sure,
/// or that took their label from neighbours, go back towards their start until they have its label again.
void keep_sure_labels(const SemanticOptions& options, const ClassVotes& votes, const std::vector<uint8_t>& seen,
                      const SemanticModel<float>& start, SemanticModel<float>& model) {
  using Row = Eigen::Map<Eigen::Array<float, kSemanticChannels, 1>>;
  using ConstRow = Eigen::Map<const Eigen::Array<float, kSemanticChannels, 1>>;
  parallel_for(
      static_cast<std::ptrdiff_t>(votes.size()),
      [&](std::ptrdiff_t p) {
        const ConstRow from(start.attribute.data() + p * kSemanticChannels);
        int label = 0;
        float largest = -INFINITY;
        for (int c = 0; c < start.classes; ++c)
          if (const float value = (from * ConstRow(start.classifier.data() + c * kSemanticChannels)).sum();
              value > largest) {
            largest = value;
            label = c;
          }
        if (seen[p]) {
          float most = 0, total = 0;
          for (const auto& vote : votes.of(p)) {
            most = std::max(most, vote.weight);
            total += vote.weight;
          }
          if (most < options.sure_vote * total) return;
        }
        // The lead of the label over every other class is linear along the way back.
        Row y(model.attribute.data() + p * kSemanticChannels);
        const auto lead = [&](const auto& at, int c) {
          return model.bias[label] - model.bias[c] +
                 (at * (ConstRow(model.classifier.data() + label * kSemanticChannels) -
                        ConstRow(model.classifier.data() + c * kSemanticChannels)))
                     .sum();
        };
        constexpr float kLead = 0.2f;
        float back = 0;
        for (int c = 0; c < model.classes; ++c) {
          if (c == label) continue;
          const float now = lead(y, c), before = lead(from, c);
          if (now < kLead && before > now) back = std::max(back, std::min(1.0f, (kLead - now) / (before - now)));
        }
        y += back * (from - y);
      },
      1024);
}

}  // namespace

SemanticResult fit_semantic_field(const SemanticOptions& given, const GaussianCloud& cloud,
                                  const std::vector<Camera>& cameras, const MaskSet& masks,
                                  const SemanticProgress& progress) {
  SemanticResult result;
  Segmentation& segmentation = result.segmentation;
  for (const MaskSet::View& view : masks.views) {
    CHECK(view.camera >= 0 && view.camera < static_cast<int>(cameras.size()));
    const Camera& camera = cameras[view.camera];
    CHECK_MSG(view.ids.width == camera.width && view.ids.height == camera.height, camera.name);
  }
  MaskSet training;
  std::copy_if(masks.views.begin(), masks.views.end(), std::back_inserter(training.views),
               [&](const MaskSet::View& view) {
                 return !std::count(given.held_out.begin(), given.held_out.end(), view.camera);
               });
  std::stable_sort(training.views.begin(), training.views.end(),
                   [](const auto& a, const auto& b) { return a.camera < b.camera; });
  if (training.views.empty() && !given.held_out.empty())
    throw input_error("masks", "", "are all of cameras that --hold-out holds out",
                      "add masks of other photos, or leave --hold-out out");
  SemanticOptions options = given;
  if (given.find_filter && given.iterations > 0)
    options.render.screen_variance = best_label_filter(given, cloud, cameras, training, progress);
  result.summary.screen_variance = segmentation.screen_variance = options.render.screen_variance;
  segmentation.antialiased = options.render.antialiased;
  segmentation.class_id = training.ids();
  for (uint32_t id : segmentation.class_id) segmentation.class_name.push_back(masks.name_of(id));
  const int classes = static_cast<int>(segmentation.class_id.size());
  segmentation.class_cameras = cameras_of_classes(training, segmentation.class_id);

  Fit fit(options, cloud, cameras);
  ClassVotes votes(cloud.size());
  fit.prepare(training, segmentation.class_id, votes, result.summary, progress);
  if (result.summary.views == 0)
    throw input_error("masks", "", "no usable view contains an ID above 0", "label at least one object");

  SemanticModel<float> model;
  if (options.start_from_vote) {
    start_from_votes(votes, classes, options.seed + kCodes, model);
  } else {
    model.resize(cloud.size(), classes);
    start_from_noise(options.seed, model);
  }
  segmentation.seen.resize(cloud.size());
  for (size_t p = 0; p < cloud.size(); ++p) segmentation.seen[p] = fit.seen(p, votes.total(p));
  const std::vector<int> source = nearest_seen(cloud.position, segmentation.seen);
  if (options.start_from_vote) {
    copy_attributes(source, model.attribute);
    const SemanticModel<float> start = model;
    if (options.iterations > 0) fit.optimise(model, result.summary, progress);
    keep_sure_labels(options, votes, segmentation.seen, start, model);
  } else {
    if (options.iterations > 0) fit.optimise(model, result.summary, progress);
    copy_attributes(source, model.attribute);
  }
  result.summary.unseen = static_cast<size_t>(std::count(segmentation.seen.begin(), segmentation.seen.end(), 0));

  segmentation.attribute = std::move(model.attribute);
  segmentation.classifier = std::move(model.classifier);
  segmentation.classifier_bias = std::move(model.bias);
  update_labels(segmentation);
  return result;
}

}  // namespace pliant

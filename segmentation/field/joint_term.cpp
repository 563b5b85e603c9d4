#include "segmentation/field/joint_term.h"

#include <algorithm>
#include <numeric>

#include "gaussians/base/error.h"
#include "gaussians/base/nearest.h"
#include "gaussians/base/random.h"
#include "gaussians/reconstruct/schedule.h"
#include "gaussians/render/blend_weights.h"
#include "segmentation/labels/spread.h"

namespace pliant {
namespace {

enum JointStream : uint64_t { kJointStart = 0x6a6f696e74ull, kJointAnchors, kJointPoints };

/// `count` of 0..n-1 without repetition, ascending.
std::vector<int> draw(size_t n, size_t count, Random random) {
  std::vector<int> members(n);
  std::iota(members.begin(), members.end(), 0);
  if (count >= n) return members;
  for (size_t i = 0; i < count; ++i) std::swap(members[i], members[i + random.below(n - i)]);
  members.resize(count);
  std::sort(members.begin(), members.end());
  return members;
}

}  // namespace

JointTerm::JointTerm(const JointOptions& options, const MaskSet& masks) : options_(options) {
  MaskSet used;
  for (const MaskSet::View& view : masks.views) {
    CHECK(view.camera >= 0);
    if (std::count(options.held_out.begin(), options.held_out.end(), view.camera)) continue;
    used.views.push_back(view);
    if (ids_.size() <= static_cast<size_t>(view.camera)) ids_.resize(view.camera + 1);
    ids_[view.camera] = view.ids;
  }
  class_id_ = used.ids();
  if (class_id_.empty())
    throw input_error("masks", "", "no usable view contains an ID above 0", "label at least one object");
  for (uint32_t id : class_id_) class_name_.push_back(masks.name_of(id));
}

void JointTerm::start(const GaussianCloud& cloud, std::vector<float>& attribute, std::vector<float>& shared) const {
  attribute.resize(cloud.size() * kSemanticChannels);
  for (size_t k = 0; k < attribute.size(); ++k)
    attribute[k] = 0.3f * static_cast<float>(Random(options_.seed, k, kJointStart).normal());
  // Weights of the classifier [C, 16], then its bias [C].
  const size_t classes = class_id_.size();
  shared.assign(classes * (kSemanticChannels + 1), 0.0f);
  Random random(options_.seed, ~0ull, kJointStart);
  for (size_t k = 0; k < classes * kSemanticChannels; ++k) shared[k] = static_cast<float>(random.uniform(-0.25, 0.25));
}

SemanticModel<float> JointTerm::model_of(std::span<const float> shared) const {
  SemanticModel<float> model;
  model.resize(0, static_cast<int>(class_id_.size()));
  CHECK(shared.size() == model.classifier.size() + model.bias.size());
  std::copy_n(shared.begin(), model.classifier.size(), model.classifier.begin());
  std::copy_n(shared.begin() + model.classifier.size(), model.bias.size(), model.bias.begin());
  return model;
}

std::vector<int> JointTerm::targets(int photo, int width, int height) const {
  std::vector<int> cls(static_cast<size_t>(width) * height, -1);
  if (photo >= static_cast<int>(ids_.size()) || ids_[photo].empty()) return cls;
  const IdImage& ids = ids_[photo];
  parallel_for(
      height,
      [&](std::ptrdiff_t y) {
        const int row = static_cast<int>((y + 0.5) * ids.height / height);
        for (int x = 0; x < width; ++x) {
          const uint32_t id = ids(static_cast<int>((x + 0.5) * ids.width / width), row);
          if (id == 0) continue;
          cls[y * width + x] =
              static_cast<int>(std::lower_bound(class_id_.begin(), class_id_.end(), id) - class_id_.begin());
        }
      },
      16);
  return cls;
}

double JointTerm::group(const AttributeView& view, float weight, SemanticModel<float>& model, SemanticModel<float>& adj,
                        AttributeGradient& gradient) const {
  const std::vector<int> members =
      draw(view.cloud.size(), options_.max_points, Random(options_.seed, view.iteration, kJointPoints));
  std::vector<Vec3f> points(members.size());
  for (size_t i = 0; i < members.size(); ++i) points[i] = view.cloud.position[members[i]];
  std::vector<int> anchors(std::min<size_t>(options_.anchors, members.size()));
  std::vector<Vec3f> at(anchors.size());
  for (size_t a = 0; a < anchors.size(); ++a) {
    const size_t member =
        Random(options_.seed, a, (uint64_t(view.iteration) << 8) + kJointAnchors).below(members.size());
    anchors[a] = members[member];
    at[a] = points[member];
  }
  // Rows of the graph are filled for the anchors only.
  const int k = options_.neighbours;
  const std::vector<int> nearest = k_nearest(points, at, k + 1);
  std::vector<int> graph(view.cloud.size() * k, -1);
  for (size_t a = 0; a < anchors.size(); ++a) {
    int found = 0;
    for (int j = 0; j <= k && found < k; ++j) {
      const int other = nearest[a * (k + 1) + j];
      if (other >= 0 && members[other] != anchors[a])
        graph[static_cast<size_t>(anchors[a]) * k + found++] = members[other];
    }
  }
  model.attribute.assign(view.attribute.begin(), view.attribute.end());
  adj.attribute.assign(view.attribute.size(), 0.0f);
  const double loss = grouping_loss_adjoint<float>(anchors, graph, k, options_.kl_weight, model, adj);
  for (size_t i = 0; i < adj.attribute.size(); ++i) gradient.attribute[i] += weight * adj.attribute[i];
  return loss;
}

double JointTerm::adjoint(const AttributeView& view, AttributeGradient gradient) const {
  const float weight = exponential_rate(options_.weight, options_.final_weight, view.progress);
  SemanticModel<float> model = model_of(view.shared), adj = model_of(view.shared);
  adj.set_zero();
  const std::vector<int> cls = targets(view.photo, view.blended.width, view.blended.height);
  std::vector<float> adj_blended(view.blended.data.size(), 0.0f);
  double loss = blended_semantic_loss_adjoint<float>(view.blended.data, cls, model, adj_blended, adj);
  for (size_t k = 0; k < adj_blended.size(); ++k) gradient.blended.data[k] += weight * adj_blended[k];
  if (options_.kl_weight > 0 && view.iteration % options_.grouping_every == 0)
    loss += group(view, weight, model, adj, gradient);
  for (size_t i = 0; i < adj.classifier.size(); ++i) gradient.shared[i] += weight * adj.classifier[i];
  for (size_t c = 0; c < adj.bias.size(); ++c) gradient.shared[adj.classifier.size() + c] += weight * adj.bias[c];
  return weight * loss;
}

JointResult JointTerm::result(const TrainingState& state, const std::vector<Camera>& cameras,
                              const RenderOptions& render) const {
  const SemanticModel<float> model = model_of(state.shared);
  JointResult result;
  Segmentation& out = result.segmentation;
  out.antialiased = render.antialiased;
  out.class_id = class_id_;
  out.class_name = class_name_;
  out.attribute = state.attribute;
  out.classifier = model.classifier;
  out.classifier_bias = model.bias;
  std::vector<float> total(state.cloud.size(), 0.0f);  // blend weight over pixels with an id
  double shown = 0, unlabelled = 0;                    // opacity over all pixels, and over those without one
  for (size_t photo = 0; photo < ids_.size(); ++photo) {
    if (ids_[photo].empty()) continue;
    const BlendWeights weights = blend_weights(state.cloud, cameras[photo], render);
    const std::vector<int> cls = targets(static_cast<int>(photo), weights.width, weights.height);
    for (size_t pixel = 0; pixel < cls.size(); ++pixel) {
      const bool labelled = cls[pixel] >= 0;
      for (uint32_t e = weights.row_start[pixel]; e < weights.row_start[pixel + 1]; ++e) {
        shown += weights.weight[e];
        if (labelled)
          total[weights.gaussian[e]] += weights.weight[e];
        else
          unlabelled += weights.weight[e];
      }
    }
  }
  if (shown > 0) result.unlabelled = unlabelled / shown;
  out.seen.resize(state.cloud.size());
  for (size_t p = 0; p < out.seen.size(); ++p) out.seen[p] = total[p] >= options_.min_weight;
  copy_attributes(nearest_seen(state.cloud.position, out.seen), out.attribute);
  update_labels(out);
  return result;
}

}  // namespace pliant

#pragma once

#include <cstdint>
#include <vector>

#include "gaussians/reconstruct/attribute_term.h"
#include "gaussians/reconstruct/training_state.h"
#include "segmentation/field/semantic_loss.h"
#include "segmentation/labels/mask_set.h"
#include "segmentation/labels/segmentation.h"

namespace pliant {

struct JointOptions {
  float attribute_rate = 0.01f, classifier_rate = 0.005f;  ///< Adam's
  /// Of the whole term beside the photometric loss.  Adam does not see the scale of what attributes and classifier are
  /// told, so this sets only how much labels move the geometry.
  /// It falls exponentially: early on labels tell where objects end, late they would take sharpness away.
  float weight = 0.05f, final_weight = 0.002f;
  float kl_weight = 2.0f;  ///< of the grouping loss
  int grouping_every = 5;  ///< iterations
  int neighbours = 5, anchors = 1000;
  size_t max_points = 50000;  ///< the grouping loss sees at most so many Gaussians, drawn anew each time
  std::vector<int> held_out;  ///< cameras whose masks are never looked at
  float min_weight = 0.05f;   ///< Gaussians with less blend weight over all pixels with an id count as unseen
  uint64_t seed = 0;
};

/// What a joint training found.
struct JointResult {
  Segmentation segmentation;
  double unlabelled = 0;  ///< share of what the views show, by opacity, on pixels without an id
};

/// The semantic attribute that trains together with the scene: cross entropy / ln C of the blended attribute against
/// the masks, and the grouping loss (Sim Anything supplement, eq. 1; Ye et al. 2024, eq. 4 and 5).
class JointTerm final : public AttributeTerm {
 public:
  /// `masks.views[].camera` index the training photos.  Throws Error{kInput} when no mask that may be used holds an id.
  JointTerm(const JointOptions& options, const MaskSet& masks);

  int channels() const override { return kSemanticChannels; }
  float attribute_rate() const override { return options_.attribute_rate; }
  float shared_rate() const override { return options_.classifier_rate; }
  void start(const GaussianCloud& cloud, std::vector<float>& attribute, std::vector<float>& shared) const override;
  double adjoint(const AttributeView& view, AttributeGradient gradient) const override;

  /// What the training found.  Gaussians that no pixel with an id shows take the attribute of their nearest neighbour
  /// that one shows.
  JointResult result(const TrainingState& state, const std::vector<Camera>& cameras, const RenderOptions& render) const;

 private:
  SemanticModel<float> model_of(std::span<const float> shared) const;
  std::vector<int> targets(int photo, int width, int height) const;
  double group(const AttributeView& view, float weight, SemanticModel<float>& model, SemanticModel<float>& adj,
               AttributeGradient& gradient) const;

  JointOptions options_;
  std::vector<IdImage> ids_;        ///< by photo; empty where there is no mask
  std::vector<uint32_t> class_id_;  ///< [C]
  std::vector<std::string> class_name_;
};

}  // namespace pliant

#pragma once

#include <functional>

#include "gaussians/base/camera.h"
#include "gaussians/base/gaussian_cloud.h"
#include "gaussians/render/render.h"
#include "segmentation/labels/mask_set.h"
#include "segmentation/labels/segmentation.h"

namespace pliant {

/// Optimisation of the semantic attribute with frozen geometry.
struct SemanticOptions {
  bool start_from_vote = true;    ///< else y and classifier start from random numbers
  int iterations = 300;           ///< one view each; 0 = vote only
  double attribute_rate = 0.1;    ///< Adam's learning rate of y ...
  double classifier_rate = 0.03;  ///< ... and of the classifier; both fall to a tenth along a cosine
  /// Weight of the grouping term.  Ye et al. 2024 take 2.0, from random attributes; after a vote it only blurs the
  /// silhouettes.
  double kl_weight = 0.2;
  int neighbours = 5, anchors = 1000;
  size_t max_points = 200000;  ///< the grouping term acts on at most so many Gaussians
  int pixel_stride = 3;        ///< one pixel per stride x stride block is used for optimisation; votes use all
  int edge = 1;                ///< ... but all pixels so near to another id are used
  int border = 2;            ///< pixels so near to another id across a silhouette do not vote; they teach how strongly
                             ///< Gaussians speak, but labels of which a vote is sure stay
  float sure_vote = 0.7f;    ///< share of the most frequent class from which on a vote is sure
  float min_weight = 0.05f;  ///< Gaussians with less blend weight over all views [pixels] count as unseen,
  float min_certain = 0.5f;  ///< and those with less than this share of it on certain pixels
  size_t memory_bytes = size_t(2) << 30;  ///< cache for blend weights; views beyond it are recomputed when needed
  std::vector<int> held_out;              ///< cameras whose masks are never looked at
  uint64_t seed = 0;
  bool find_filter = true;  ///< the low-pass filter of labels is found (best_label_filter); else it is that of `render`
  bool trained_on_views = false;  ///< the scene was trained on these views: in others its Gaussians stick out further
  RenderOptions render;
};

struct SemanticSummary {
  int views = 0;
  size_t cached_bytes = 0;                 ///< of blend weights in memory
  size_t unseen = 0;                       ///< Gaussians that took their neighbours' label
  double unlabelled = 0;                   ///< share of what the views show, by opacity, on pixels without an id
  double screen_variance = 0;              ///< of the low-pass filter (px^2)
  double cross_entropy = 0, grouping = 0;  ///< means over the last tenth of the iterations
};

struct SemanticResult {
  Segmentation segmentation;
  SemanticSummary summary;
};

/// Called after an iteration with its loss, and with iteration 0 and loss 0 before each view that is prepared; may
/// throw.
using SemanticProgress = std::function<void(int iteration, int iterations, double loss)>;

/// The semantic attribute of every Gaussian and the shared classifier (Sim Anything supplement, eq. 1, with frozen
/// geometry: S = W y).  Starts from the closed-form vote or from random numbers and minimises cross entropy / ln C +
/// kl_weight / C * KL of neighbouring Gaussians by Adam.  Equal bit for bit for any number of threads.
/// Throws Error{kInput} when the views that are not held out hold no id.
SemanticResult fit_semantic_field(const SemanticOptions& options, const GaussianCloud& cloud,
                                  const std::vector<Camera>& cameras, const MaskSet& masks,
                                  const SemanticProgress& progress = {});

}  // namespace pliant

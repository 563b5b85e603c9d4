#include "segmentation/lift/label_filter.h"

#include <algorithm>
#include <cmath>

namespace pliant {
namespace {

constexpr size_t kViews = 8;
constexpr int kRounds = 10;            // iterations per view; the loss is that of the last round
constexpr int kFinest = 8, kCoarsest = 2;  // steps
constexpr double kGain = 0.99;         // a step must take away so much of the loss, or it is not taken

/// Views of the masks, evenly drawn from those that tell two ids apart.
MaskSet few_views(const MaskSet& masks) {
  std::vector<const MaskSet::View*> useful;
  for (const MaskSet::View& view : masks.views) {
    uint32_t first = 0;
    const bool two = std::any_of(view.ids.data.begin(), view.ids.data.end(), [&](uint32_t id) {
      if (id != 0 && first == 0) first = id;
      return id != 0 && id != first;
    });
    if (two) useful.push_back(&view);
  }
  MaskSet few;
  const size_t count = std::min(kViews, useful.size());
  for (size_t k = 0; k < count; ++k) few.views.push_back(*useful[(2 * k + 1) * useful.size() / (2 * count)]);
  return few;
}

}  // namespace

double best_label_filter(const SemanticOptions& options, const GaussianCloud& cloud, const std::vector<Camera>& cameras,
                         const MaskSet& masks) {
  const double start = options.render.screen_variance;
  const MaskSet few = few_views(masks);
  if (few.views.empty()) return start;
  SemanticOptions quick = options;
  quick.find_filter = false, quick.start_from_vote = true, quick.iterations = kRounds * static_cast<int>(few.views.size());
  const auto variance = [&](int step) { return start * std::pow(0.5, 0.5 * step); };
  const auto loss = [&](int step) {
    quick.render.screen_variance = variance(step);
    return fit_semantic_field(quick, cloud, cameras, few).summary.cross_entropy;
  };
  int best = 0;
  double least = loss(0);
  for (int direction : {1, -1}) {
    if (best != 0) break;
    for (int step = direction; -kCoarsest <= step && step <= kFinest; step += direction) {
      const double here = loss(step);
      if (!(here < kGain * least)) break;
      best = step, least = here;
    }
  }
  return variance(best);
}

}  // namespace pliant

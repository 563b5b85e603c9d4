#include "segmentation/field/label_filter.h"

#include <algorithm>
#include <cmath>

namespace pliant {
namespace {

constexpr size_t kViews = 12;  // every third of them is not learnt from, but tells what the others are worth
constexpr int kRounds = 10;    // iterations per view
constexpr int kFinest = 8, kCoarsest = 2;  // steps
constexpr int kTrained = 1;  // step that is taken where masks of training views do not ask for another one
// A step must leave at most so much of the wrong pixels, or it is not taken; the first one leaves the filter of colour.
constexpr double kFirstGain = 0.85, kGain = 0.97;

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
                         const MaskSet& masks, const SemanticProgress& progress) {
  const double start = options.render.screen_variance;
  MaskSet learnt;
  std::vector<int> others;
  std::vector<IdImage> truth;
  for (const MaskSet::View& view : few_views(masks).views) {
    if ((learnt.views.size() + others.size()) % 3 == 1) {
      others.push_back(view.camera);
      truth.push_back(view.ids);
    } else
      learnt.views.push_back(view);
  }
  if (others.empty()) return start;
  SemanticOptions quick = options;
  quick.find_filter = false;
  quick.start_from_vote = true;
  quick.iterations = kRounds * static_cast<int>(learnt.views.size());
  const auto under_way = [&](int, int, double) {
    if (progress) progress(0, options.iterations, 0);
  };
  const auto variance = [&](int step) { return start * std::pow(0.5, 0.5 * step); };
  const auto wrong_pixels = [&](int step) {
    quick.render.screen_variance = variance(step);
    const Segmentation found = fit_semantic_field(quick, cloud, cameras, learnt, under_way).segmentation;
    size_t wrong = 0;
    for (size_t v = 0; v < others.size(); ++v) {
      const IdImage drawn = render_ids(found, cloud, cameras[others[v]]);
      for (size_t i = 0; i < drawn.data.size(); ++i)
        wrong += truth[v].data[i] != 0 && drawn.data[i] != truth[v].data[i];
    }
    return static_cast<double>(wrong);
  };
  int best = 0;
  double least = wrong_pixels(0);
  for (int direction : {1, -1}) {
    if (best != 0) break;
    for (int step = direction; - kCoarsest <= step && step <= kFinest; step += direction) {
      const double here = wrong_pixels(step);
      if (!(here < (best == 0 ? kFirstGain : kGain) * least)) break;
      best = step;
      least = here;
    }
  }
  return variance(best == 0 && options.trained_on_views ? kTrained : best);
}

}  // namespace pliant

#include "segmentation/sheets/selection_sheet.h"

namespace pliant {
namespace {

/// Kind under which a Gaussian is shown, -1 = as it is.
int kind_of(SelectionRule rule) {
  switch (rule) {
    case SelectionRule::kKept:
      return 0;
    case SelectionRule::kCut:
      return 1;
    case SelectionRule::kPart:
      return 2;
    case SelectionRule::kRefined:
      return 3;
    default:
      return -1;
  }
}

}  // namespace

ImageF selection_sheet(const GestureResult& result, const GaussianCloud& cloud, const std::vector<Camera>& sides,
                       const RenderOptions& options) {
  std::vector<int> kind(cloud.size());
  for (size_t p = 0; p < cloud.size(); ++p) kind[p] = kind_of(result.rule[p]);
  const GestureResult::Summary& s = result.summary;
  const std::string caption =
      std::to_string(s.outside) + " Gaussians outside the boxes' frusta or the shape (darkened), " +
      std::to_string(s.added) + " added by refinement over " + std::to_string(s.refine_views.size()) + " views, " +
      std::to_string(s.seeds) + " fixed by strokes and clicks";
  return sides_sheet(cloud, sides, kind,
                     {{"object", {0.1f, 0.9f, 0.2f}, s.selected},
                      {"removed by the cut", {0.2f, 0.45f, 1.0f}, s.cut},
                      {"separate parts", {1.0f, 0.6f, 0.0f}, s.part},
                      {"removed by refinement", {1.0f, 0.1f, 0.6f}, s.refined}},
                     caption, options);
}

}  // namespace pliant

#include "segmentation/labelling/everything.h"

#include <algorithm>

#include "gaussians/base/error.h"
#include "segmentation/labelling/mask_measures.h"

namespace pliant {
namespace {

/// Middles of the cells of a grid; those of coarser grids first, so that large things are met before their parts.
std::vector<MaskPrompt::Point> grid_points(int side, int width, int height) {
  std::vector<MaskPrompt::Point> points;
  std::vector<uint8_t> used(static_cast<size_t>(side) * side, 0);
  for (int step = std::max(1, side / 2); step >= 1; step /= 2)
    for (int j = step / 2; j < side; j += step)
      for (int i = step / 2; i < side; i += step) {
        if (uint8_t& there = used[static_cast<size_t>(j) * side + i]; there++) continue;
        points.push_back({(i + 0.5f) * width / side, (j + 0.5f) * height / side, true});
      }
  return points;
}

bool covers(const PictureMask& mask, const MaskPrompt::Point& point) {
  const int x = static_cast<int>(point.x) - mask.x0, y = static_cast<int>(point.y) - mask.y0;
  return x >= 0 && y >= 0 && x < mask.width && y < mask.height && mask.inside[static_cast<size_t>(y) * mask.width + x];
}

}  // namespace

EverythingOptions EverythingOptions::weight_free() {
  EverythingOptions options;
  options.points_per_side = 12;
  options.least_iou = 0.6f;
  options.least_stability = 0.75f;
  options.skip_covered = true;
  return options;
}

std::vector<PictureMask> segment_everything(const EverythingOptions& options, const ImageF& picture,
                                            PromptableSegmenter& segmenter) {
  CHECK(options.points_per_side > 0);
  segmenter.encode(picture);
  std::vector<PictureMask> masks;
  for (const MaskPrompt::Point& point : grid_points(options.points_per_side, picture.width, picture.height)) {
    if (options.skip_covered &&
        std::any_of(masks.begin(), masks.end(), [&](const PictureMask& m) { return covers(m, point); }))
      continue;
    for (const SegmentedMask& found : segmenter.segment({std::nullopt, {point}})) {
      if (found.predicted_iou < options.least_iou) continue;
      if (stability(found.logits, options.stability_offset) < options.least_stability) continue;
      PictureMask mask = picture_mask(found.logits, "", found.predicted_iou);
      if (mask.pixels == 0 ||
          static_cast<float>(mask.pixels) > options.most_share * static_cast<float>(picture.pixels()))
        continue;
      masks.push_back(std::move(mask));
    }
  }
  std::vector<MaskPrompt::Box> boxes;
  std::vector<float> scores;
  for (const PictureMask& mask : masks) {
    boxes.push_back(mask.box());
    scores.push_back(mask.score);
  }
  std::vector<PictureMask> kept;
  for (size_t k : suppress_duplicates(boxes, scores, options.box_nms)) kept.push_back(std::move(masks[k]));
  return kept;
}

}  // namespace pliant

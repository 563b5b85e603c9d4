#include "segmentation/models/boxes.h"

#include <algorithm>

namespace pliant {

float box_iou(const Detection& a, const Detection& b) {
  const float width = std::min(a.x1, b.x1) - std::max(a.x0, b.x0), height = std::min(a.y1, b.y1) - std::max(a.y0, b.y0);
  if (width <= 0 || height <= 0) return 0;
  const float both = width * height;
  return both / ((a.x1 - a.x0) * (a.y1 - a.y0) + (b.x1 - b.x0) * (b.y1 - b.y0) - both);
}

std::vector<Detection> suppress_overlaps(std::vector<Detection> boxes, float most) {
  std::stable_sort(boxes.begin(), boxes.end(),
                   [](const Detection& a, const Detection& b) { return a.score > b.score; });
  std::vector<Detection> kept;
  for (Detection& box : boxes) {
    const bool covered = std::any_of(kept.begin(), kept.end(), [&](const Detection& better) {
      return better.label == box.label && box_iou(better, box) > most;
    });
    if (!covered) kept.push_back(std::move(box));
  }
  return kept;
}

bool clip_box(Detection& box, int width, int height) {
  box.x0 = std::clamp(box.x0, 0.f, static_cast<float>(width));
  box.x1 = std::clamp(box.x1, 0.f, static_cast<float>(width));
  box.y0 = std::clamp(box.y0, 0.f, static_cast<float>(height));
  box.y1 = std::clamp(box.y1, 0.f, static_cast<float>(height));
  return box.x1 > box.x0 && box.y1 > box.y0;
}

}  // namespace pliant

#include "segmentation/labelling/id_picture.h"

#include <algorithm>
#include <functional>
#include <numeric>

#include "gaussians/base/error.h"
#include "segmentation/labelling/mask_measures.h"

namespace pliant {
namespace {

/// Pixels that two masks share.
size_t shared_pixels(const PictureMask& a, const PictureMask& b) {
  size_t both = 0;
  const int x0 = std::max(a.x0, b.x0), x1 = std::min(a.x0 + a.width, b.x0 + b.width);
  const int y0 = std::max(a.y0, b.y0), y1 = std::min(a.y0 + a.height, b.y0 + b.height);
  for (int y = y0; y < y1; ++y)
    for (int x = x0; x < x1; ++x)
      both += a.inside[static_cast<size_t>(y - a.y0) * a.width + x - a.x0] &&
              b.inside[static_cast<size_t>(y - b.y0) * b.width + x - b.x0];
  return both;
}

std::vector<size_t> best_first(const std::vector<float>& scores) {
  std::vector<size_t> order(scores.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return scores[a] > scores[b]; });
  return order;
}

/// Masks from the front to the back: best score first, but each after those that lie in front of it.
std::vector<size_t> front_to_back(const PaintOptions& options, const std::vector<PictureMask>& masks) {
  const size_t n = masks.size();
  std::vector<size_t> order;
  std::vector<uint8_t> done(n, 0);
  // Masks in front are smaller by a factor, so that this comes to an end.
  const std::function<void(size_t)> paint = [&](size_t k) {
    if (done[k]++) return;
    for (size_t a = 0; a < n; ++a) {
      const float pixels = static_cast<float>(masks[a].pixels);
      if (done[a] || options.larger * pixels > static_cast<float>(masks[k].pixels)) continue;
      if (static_cast<float>(shared_pixels(masks[a], masks[k])) >= options.nested * pixels) paint(a);
    }
    order.push_back(k);
  };
  for (size_t k = 0; k < n; ++k) paint(k);
  return order;
}

}  // namespace

MaskPrompt::Box PictureMask::box() const {
  return {static_cast<float>(x0), static_cast<float>(y0), static_cast<float>(x0 + width),
          static_cast<float>(y0 + height)};
}

PictureMask picture_mask(const ImageF& logits, std::string name, float score) {
  PictureMask mask;
  mask.name = std::move(name);
  mask.score = score;
  const MaskPrompt::Box box = box_of_mask(logits);
  if (!(box.x1 > box.x0)) return mask;
  mask.x0 = static_cast<int>(box.x0);
  mask.y0 = static_cast<int>(box.y0);
  mask.width = static_cast<int>(box.x1) - mask.x0;
  mask.height = static_cast<int>(box.y1) - mask.y0;
  mask.inside.resize(static_cast<size_t>(mask.width) * mask.height);
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x)
      mask.pixels += mask.inside[static_cast<size_t>(y) * mask.width + x] = logits(mask.x0 + x, mask.y0 + y) > 0;
  return mask;
}

LabelledPhoto paint_masks(const PaintOptions& options, int width, int height, std::vector<PictureMask> masks) {
  std::vector<float> scores;
  for (const PictureMask& mask : masks) scores.push_back(mask.score);
  std::vector<PictureMask> sorted;
  for (size_t k : best_first(scores)) sorted.push_back(std::move(masks[k]));

  LabelledPhoto photo;
  photo.ids = IdImage(width, height, 1);
  std::vector<size_t> left(sorted.size(), 0);
  const auto paint = [&](size_t k, auto&& pixel) {
    const PictureMask& mask = sorted[k];
    CHECK(mask.x0 >= 0 && mask.y0 >= 0 && mask.x0 + mask.width <= width && mask.y0 + mask.height <= height);
    for (int y = 0; y < mask.height; ++y)
      for (int x = 0; x < mask.width; ++x)
        if (mask.inside[static_cast<size_t>(y) * mask.width + x]) pixel(photo.ids(mask.x0 + x, mask.y0 + y));
  };
  for (size_t k : front_to_back(options, sorted)) {
    const uint32_t id = static_cast<uint32_t>(k) + 1;
    paint(k, [&](uint32_t& pixel) {
      if (pixel == 0) {
        pixel = id;
        ++left[k];
      }
    });
    const size_t least =
        std::max(options.least_pixels, static_cast<size_t>(options.least_left * static_cast<float>(sorted[k].pixels)));
    if (left[k] >= least && left[k] > 0) continue;
    paint(k, [&](uint32_t& pixel) {
      if (pixel == id) pixel = 0;
    });
    left[k] = 0;
  }
  std::vector<uint32_t> number(sorted.size() + 1, 0);
  for (size_t k = 0; k < sorted.size(); ++k) {
    if (left[k] == 0) continue;
    number[k + 1] = static_cast<uint32_t>(photo.things.size()) + 1;
    photo.things.push_back({number[k + 1], sorted[k].name, sorted[k].score, sorted[k].box(), left[k]});
  }
  for (uint32_t& id : photo.ids.data) id = number[id];
  return photo;
}

std::vector<size_t> suppress_duplicates(const std::vector<MaskPrompt::Box>& boxes, const std::vector<float>& scores,
                                        float most) {
  CHECK(boxes.size() == scores.size());
  std::vector<size_t> kept;
  for (size_t k : best_first(scores))
    if (std::none_of(kept.begin(), kept.end(), [&](size_t other) { return box_iou(boxes[k], boxes[other]) > most; }))
      kept.push_back(k);
  return kept;
}

}  // namespace pliant

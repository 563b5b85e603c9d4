#include "segmentation/labelling/grab_cut_segmenter.h"

#include <algorithm>
#include <cmath>

#include "gaussians/base/error.h"
#include "gaussians/base/portable.h"
#include "segmentation/labelling/color_histogram.h"
#include "segmentation/labelling/mask_measures.h"

namespace pliant {
namespace {

using PromptBox = MaskPrompt::Box;
using Point = MaskPrompt::Point;

PromptBox grown(const PromptBox& box, float share) {
  const float dx = share * (box.x1 - box.x0), dy = share * (box.y1 - box.y0);
  return {box.x0 - dx, box.y0 - dy, box.x1 + dx, box.y1 + dy};
}

void check_prompt(const MaskPrompt& prompt, int width, int height) {
  const std::string size = std::to_string(width) + "x" + std::to_string(height);
  const auto refuse = [&](const char* what, const char* problem) {
    return usage_error("prompt", what, problem, "give pixels of the image, which is " + size);
  };
  if (!prompt.box &&
      std::none_of(prompt.points.begin(), prompt.points.end(), [](const Point& p) { return p.foreground; }))
    throw refuse("points", "has neither a box nor a foreground point");
  if (prompt.box) {
    const PromptBox& b = *prompt.box;
    if (!(b.x1 > b.x0 && b.y1 > b.y0)) throw refuse("box", "has no area");
    if (!(b.x1 > 0 && b.y1 > 0 && b.x0 < width && b.y0 < height)) throw refuse("box", "is outside the image");
  }
  for (const Point& p : prompt.points)
    if (!(p.x >= 0 && p.y >= 0 && p.x < width && p.y < height)) throw refuse("points", "has one outside the image");
}

/// Share of the border of `box`, where it lies in the picture, that is mask.
float share_on_border(const ImageF& logits, const PromptBox& box) {
  const int x0 = static_cast<int>(std::floor(box.x0)), x1 = static_cast<int>(std::ceil(box.x1)) - 1;
  const int y0 = static_cast<int>(std::floor(box.y0)), y1 = static_cast<int>(std::ceil(box.y1)) - 1;
  size_t inside = 0, mask = 0;
  const auto look = [&](int x, int y) {
    if (x < 0 || y < 0 || x >= logits.width || y >= logits.height) return;
    ++inside;
    mask += logits(x, y) > 0;
  };
  for (int x = x0; x <= x1; ++x) {
    look(x, y0);
    look(x, y1);
  }
  for (int y = y0; y <= y1; ++y) {
    look(x0, y);
    look(x1, y);
  }
  return inside > 0 ? static_cast<float>(mask) / static_cast<float>(inside) : 0;
}

}  // namespace

void GrabCutSegmenter::encode(const ImageF& picture) { lab_ = lab_picture(picture); }

std::vector<SegmentedMask> GrabCutSegmenter::segment(const MaskPrompt& prompt) {
  CHECK_MSG(!lab_.empty(), "segment before encode");
  check_prompt(prompt, lab_.width, lab_.height);
  if (prompt.box) return {cut(*prompt.box, true, prompt.points)};
  // Points say nothing of the size: one candidate for each.
  PromptBox seeds{INFINITY, INFINITY, -INFINITY, -INFINITY};
  for (const Point& p : prompt.points) {
    if (!p.foreground) continue;
    seeds.x0 = std::min(seeds.x0, p.x);
    seeds.x1 = std::max(seeds.x1, p.x);
    seeds.y0 = std::min(seeds.y0, p.y);
    seeds.y1 = std::max(seeds.y1, p.y);
  }
  std::vector<SegmentedMask> candidates(options_.sizes.size());
  parallel_for(static_cast<std::ptrdiff_t>(candidates.size()), [&](std::ptrdiff_t k) {
    const float reach = 0.5f * options_.sizes[k] * static_cast<float>(std::max(lab_.width, lab_.height));
    const PromptBox box{seeds.x0 - reach, seeds.y0 - reach, seeds.x1 + reach, seeds.y1 + reach};
    candidates[k] = cut(box, false, prompt.points);
    // What was found is looked at again at its own size: a thing is found again, a piece of the ground is not.
    const PromptBox around = box_of_mask(candidates[k].logits);
    if (!(around.x1 > around.x0)) return;  // thinner than a pixel
    const ImageF first = std::move(candidates[k].logits);
    const float cut_off = share_on_border(first, box);
    candidates[k] = cut(grown(around, 0.05f), false, prompt.points);
    candidates[k].predicted_iou *= mask_iou(first, candidates[k].logits) * (1 - cut_off);
  });
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const SegmentedMask& a, const SegmentedMask& b) { return a.predicted_iou > b.predicted_iou; });
  return candidates;
}

SegmentedMask GrabCutSegmenter::cut(const PromptBox& box, bool tight, const std::vector<Point>& points) const {
  const int size = tight ? options_.window : options_.point_window;
  const PictureWindow window(lab_.width, lab_.height, grown(box, options_.context), size);
  const ImageF lab = window.read(lab_);
  GrabCutInput input;
  input.width = window.width;
  input.height = window.height;
  const size_t n = lab.pixels();
  input.lab.resize(n);
  input.seed.assign(n, PixelSeed::kUnknown);
  input.prior.assign(n, 0.0f);
  const Vec2f low = window.to_window(box.x0, box.y0), high = window.to_window(box.x1, box.y1);
  const Vec2f centre = 0.5f * (low + high), half = (0.5f * (high - low)).cwiseMax(0.5f);
  const float longest = static_cast<float>(size), dot = std::max(1.0f, options_.dot * longest);
  for (int y = 0; y < input.height; ++y)
    for (int x = 0; x < input.width; ++x) {
      const size_t i = static_cast<size_t>(y) * input.width + x;
      input.lab[i] = Eigen::Map<const Vec3f>(lab.at(x, y));
      const Vec2f pixel(x + 0.5f, y + 0.5f), r = (pixel - centre).cwiseQuotient(half);
      PixelSeed& seed = input.seed[i];
      if (r.cwiseAbs().maxCoeff() > 1) seed = PixelSeed::kBackground;
      if (tight && r.norm() < options_.core) seed = PixelSeed::kForeground;
      input.prior[i] = options_.shape * std::max(-1.0f, 1 - r.squaredNorm());
      for (const Point& point : points) {
        const float d = (pixel - window.to_window(point.x, point.y)).norm(), far = d / (options_.reach * longest);
        if (d <= dot) seed = point.foreground ? PixelSeed::kForeground : PixelSeed::kBackground;
        if (tight) input.prior[i] += (point.foreground ? 1 : -1) * options_.point * std::exp(-0.5f * far * far);
      }
    }
  GrabCutOptions cut = options_.cut;
  cut.levels = options_.levels;
  GrabCutResult result = grab_cut(cut, input);
  ImageF logits(input.width, input.height, 1);
  logits.data = std::move(result.logit);
  std::vector<uint8_t> given(n);
  for (size_t i = 0; i < n; ++i) given[i] = input.seed[i] != PixelSeed::kUnknown;
  tidy_parts(given, options_.least_part, options_.least_hole, logits);
  SegmentedMask mask;
  mask.predicted_iou = stability(logits, options_.levels.front());
  mask.logits = window.write(logits, lab_.width, lab_.height, -options_.levels.back() - 1);
  return mask;
}

}  // namespace pliant

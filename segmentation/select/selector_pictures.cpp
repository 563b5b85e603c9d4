// Pictures of the prepared views: masks of regions, and what they say about Gaussians.

#include <algorithm>
#include <cmath>

#include "segmentation/select/selector_look.h"

namespace pliant {
namespace {

constexpr float kStrokeShare = 0.4f;  // of a region that a stroke covers

}  // namespace

Selector::Look::Look(const RegionView& of, const PictureRect& picture, int window) : view(&of) {
  const Vec2f low = of.window.to_window(picture.x0, picture.y0), high = of.window.to_window(picture.x1, picture.y1);
  scale = static_cast<float>(window) / std::max(high.x() - low.x(), high.y() - low.y());
  std::vector<int> place(of.size(), -1);
  for (size_t r = 0; r < of.size(); ++r) {
    const Vec2f& x = of.middle[r];
    if (!(of.area[r] > 0) || (x.array() < low.array()).any() || (x.array() > high.array()).any()) continue;
    place[r] = static_cast<int>(regions.size());
    regions.push_back(static_cast<int>(r));
    input.lab.push_back(of.lab[r]);
    input.area.push_back(scale * scale * of.area[r]);
  }
  for (const CutEdge& e : of.edges)
    if (place[e.a] >= 0 && place[e.b] >= 0) input.edges.push_back({place[e.a], place[e.b], scale * e.weight});
  input.seed.assign(regions.size(), PixelSeed::kUnknown);
}

void Selector::Look::seed_strokes(const std::vector<StrokePrompt>& strokes) {
  for (const StrokePrompt& stroke : strokes) {
    if (stroke.camera != view->window.source) continue;
    std::vector<float> covered(view->size(), 0.0f);
    const std::vector<uint8_t> under = stroke_pixels(view->window, stroke);
    for (size_t i = 0; i < under.size(); ++i)
      if (under[i]) covered[view->region[i]] += 1;
    for (size_t k = 0; k < regions.size(); ++k)
      if (covered[regions[k]] > kStrokeShare * view->area[regions[k]])
        input.seed[k] = stroke.foreground ? PixelSeed::kForeground : PixelSeed::kBackground;
  }
}

void Selector::Look::lift(const std::vector<uint8_t>& mask, Lift& out) const {
  for (size_t k = 0; k < regions.size(); ++k)
    for (uint32_t e = view->row_start[regions[k]]; e < view->row_start[regions[k] + 1]; ++e) {
      const float weight = scale * scale * view->weight[e];
      out.total[view->gaussian[e]] += weight;
      if (mask[k]) out.inside[view->gaussian[e]] += weight;
    }
}

const RegionView& Selector::view_of(int camera) {
  if (const RegionView* view = scene_.view_of(camera)) return *view;
  for (const auto& view : more_views_)
    if (view->window.source == camera) return *view;
  more_views_.push_back(std::make_unique<RegionView>(
      region_view(scene_.options.view, cloud_, whole_picture(cameras_, camera, scene_.options.view_pixels))));
  return *more_views_.back();
}

void Selector::look_at_boxes() {
  for (const BoxPrompt& box : gesture_.boxes) {
    const PictureRect rect{box.x0, box.y0, box.x1, box.y1};
    const RegionView& view = view_of(box.camera);
    Look look(view, rect.grown(options_.margin), options_.window);
    const Vec2f low = view.window.to_window(box.x0, box.y0), high = view.window.to_window(box.x1, box.y1);
    for (size_t k = 0; k < look.regions.size(); ++k) {
      const Vec2f& x = view.middle[look.regions[k]];
      if ((x.array() < low.array()).any() || (x.array() > high.array()).any())
        look.input.seed[k] = PixelSeed::kBackground;
    }
    look.seed_strokes(gesture_.strokes);
    const GrabCutResult mask = grab_cut(options_.picture, look.input);
    if (mask.pixels == 0)
      summary_.warnings.push_back("the box in '" + cameras_[box.camera].name +
                                  "' contains nothing that differs from its surroundings");
    look.lift(mask.foreground, prompts_);
  }
}

}  // namespace pliant

// From boxes, strokes and clicks to seeds and evidence on Gaussians.

#include <algorithm>
#include <cmath>

#include "gaussians/base/error.h"
#include "gaussians/base/portable.h"
#include "segmentation/select/selector.h"

namespace pliant {
namespace {

constexpr float kStrokeShare = 0.5f;    // of its visible weight that a fixed Gaussian has under the stroke
constexpr float kStrokeWeight = 0.05f;  // px of it at least

}  // namespace

void Selector::find_members(const std::optional<SelectionShape>& shape) {
  member_.assign(cloud_.size(), 1);
  parallel_for(
      static_cast<std::ptrdiff_t>(cloud_.size()),
      [&](std::ptrdiff_t p) {
        if (shape && !shape->contains(cloud_.position[p])) member_[p] = 0;
        for (const BoxPrompt& box : gesture_.boxes) {
          Eigen::Vector2d x;
          if (!project_point(cameras_[box.camera], cloud_.position[p], x) || x.x() < box.x0 || x.x() > box.x1 ||
              x.y() < box.y0 || x.y() > box.y1)
            member_[p] = 0;
        }
      },
      4096);
  for (size_t p = 0; p < cloud_.size(); ++p)
    if (!member_[p]) rule_[p] = SelectionRule::kOutside;
}

void Selector::fix_seeds() {
  fixed_.assign(cloud_.size(), 0);
  for (const StrokePrompt& stroke : gesture_.strokes) {
    PictureRect rect;
    for (const Vec2f& x : stroke.points)
      for (double side : {-1.0, 1.0}) rect.add(x.x() + side * stroke.width, x.y() + side * stroke.width);
    // Pixels as fine as the picture's, so that a thin stroke covers some.
    const double longest = std::max(rect.x1 - rect.x0, rect.y1 - rect.y0);
    const WindowView window(cameras_, stroke.camera, rect, static_cast<int>(std::clamp(longest, 24.0, 1024.0)));
    Lift lift(cloud_.size());
    lift.add(cloud_, window.camera, options_.render, stroke_pixels(window, stroke));
    size_t best = 0, found = 0;
    for (size_t p = 0; p < cloud_.size(); ++p) {
      if (stroke.foreground && !member_[p]) continue;
      if (lift.inside[p] > lift.inside[best]) best = p;
      if (lift.inside[p] < kStrokeWeight || lift.inside[p] < kStrokeShare * lift.total[p]) continue;
      fixed_[p] = stroke.foreground ? 1 : -1;
      ++found;
    }
    if (found == 0 && lift.inside[best] > 0 && (!stroke.foreground || member_[best])) {
      fixed_[best] = stroke.foreground ? 1 : -1;
      ++found;
    }
    if (found == 0)
      summary_.warnings.push_back(std::string(stroke.points.size() == 1 ? "a click" : "a stroke") + " in '" +
                                  cameras_[stroke.camera].name + "' hits no Gaussian that could belong to the object");
    summary_.seeds += found;
  }
}

/// The nearer of the foreground's and the background's strokes, by exp(-(path / reach)^2 / 2).
void Selector::spread_seeds() {
  if (options_.stroke_reach <= 0 || gesture_.strokes.empty()) return;
  spread_.assign(graph_.nodes.size(), 0.0f);
  for (int8_t sign : {1, -1}) {
    std::vector<int> sources;
    for (size_t i = 0; i < graph_.nodes.size(); ++i)
      if (fixed_[graph_.nodes[i]] == sign) sources.push_back(static_cast<int>(i));
    std::vector<float> path;
    order_from(graph_, sources, &path);
    for (size_t i = 0; i < path.size(); ++i) {
      const float far = path[i] / options_.stroke_reach, weight = std::exp(-0.5f * far * far);
      if (weight > std::abs(spread_[i])) spread_[i] = sign * weight;
    }
  }
}

GrabCutInput Selector::input_of(const WindowView& window, const RenderResult& picture) const {
  GrabCutInput input;
  input.width = window.camera.width;
  input.height = window.camera.height;
  const size_t n = picture.color.pixels();
  input.lab.resize(n);
  input.seed.assign(n, PixelSeed::kUnknown);
  for (size_t i = 0; i < n; ++i) {
    const float* rgb = picture.color.data.data() + 3 * i;
    input.lab[i] = lab_of_rgb(Vec3f(rgb[0], rgb[1], rgb[2]));
  }
  return input;
}

void Selector::seed_strokes(const WindowView& window, GrabCutInput& input) const {
  for (const StrokePrompt& stroke : gesture_.strokes) {
    if (stroke.camera != window.source) continue;
    const std::vector<uint8_t> under = stroke_pixels(window, stroke);
    for (size_t i = 0; i < under.size(); ++i)
      if (under[i]) input.seed[i] = stroke.foreground ? PixelSeed::kForeground : PixelSeed::kBackground;
  }
}

void Selector::look_at_boxes() {
  for (const BoxPrompt& box : gesture_.boxes) {
    const PictureRect rect{box.x0, box.y0, box.x1, box.y1};
    const WindowView window(cameras_, box.camera, rect.grown(options_.margin), options_.window);
    GrabCutInput input = input_of(window, render(cloud_, window.camera, options_.render));
    const Vec2f low = window.to_window(box.x0, box.y0), high = window.to_window(box.x1, box.y1);
    for (int y = 0; y < input.height; ++y)
      for (int x = 0; x < input.width; ++x) {
        PixelSeed& seed = input.seed[static_cast<size_t>(y) * input.width + x];
        const bool inside = x + 0.5f >= low.x() && x + 0.5f <= high.x() && y + 0.5f >= low.y() && y + 0.5f <= high.y();
        if (!inside && seed == PixelSeed::kUnknown) seed = PixelSeed::kBackground;
      }
    seed_strokes(window, input);
    const GrabCutResult mask = grab_cut(options_.picture, input);
    if (mask.pixels == 0)
      summary_.warnings.push_back("the box in '" + cameras_[box.camera].name +
                                  "' contains nothing that differs from its surroundings");
    prompts_.add(cloud_, window.camera, options_.render, mask.foreground);
  }
}

std::vector<float> Selector::evidence_of(const Lift& lift) const {
  std::vector<float> evidence(graph_.nodes.size());
  for (size_t i = 0; i < evidence.size(); ++i) {
    const int p = graph_.nodes[i];
    if (lift.total[p] > 0)
      evidence[i] = options_.evidence * std::min(1.0f, lift.total[p] / options_.confident) *
                    (2 * lift.inside[p] / lift.total[p] - 1);
    if (!support_.empty()) evidence[i] += support_[i];
    if (!spread_.empty()) evidence[i] = (1 - std::abs(spread_[i])) * evidence[i] + options_.evidence * spread_[i];
    if (fixed_[p]) evidence[i] = fixed_[p] * kFixed;
  }
  return evidence;
}

}  // namespace pliant

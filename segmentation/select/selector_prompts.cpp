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
constexpr double kSurfaceShare = 0.25;  // of what a click covers that the surface it means makes
constexpr double kBehind = 1.2;         // depth / depth of what lies before it from which on it is another surface

struct Hit {
  size_t gaussian = 0;
  float weight = 0;  ///< px
  double depth = 0;  ///< along the optical axis (scene units)
};

/// A click between leaves or on a stem covers what lies behind them, too: the nearest surface counts that is more than
/// a speck before the others.
std::vector<Hit> one_surface(std::vector<Hit> hits) {
  std::sort(hits.begin(), hits.end(), [](const Hit& a, const Hit& b) { return a.depth < b.depth; });
  double all = 0;
  for (const Hit& hit : hits) all += hit.weight;
  for (auto first = hits.begin(), next = first; first != hits.end(); first = next) {
    double weight = 0;
    do weight += next++->weight;
    while (next != hits.end() && next->depth <= kBehind * (next - 1)->depth);
    if (weight >= kSurfaceShare * all) return {first, next};
  }
  return hits;
}

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
  // A shape may cut through the object, a box does not.
  held_.assign(cloud_.size(), 0.0f);
  coarse_weight_.assign(scene_.parts.edges.size(), 0.0f);
  for (size_t e = 0; e < graph_.edges.size(); ++e) {
    const auto& [a, b, weight] = graph_.edges[e];
    if (member_[a] && member_[b]) {
      if (const int k = scene_.parts.edge_of[e]; k >= 0) coarse_weight_[k] += weight;
    } else if (!shape) {
      if (member_[a]) held_[a] += weight;
      if (member_[b]) held_[b] += weight;
    }
  }
}

void Selector::fix_seeds() {
  fixed_.assign(cloud_.size(), 0);
  std::vector<int> marked_by(cloud_.size(), -1);
  std::vector<std::vector<size_t>> clicked(gesture_.strokes.size());  // by clicks on the object
  const auto mark = [&](size_t p, size_t stroke) {
    fixed_[p] = gesture_.strokes[stroke].foreground ? 1 : -1;
    marked_by[p] = static_cast<int>(stroke);
  };
  for (size_t s = 0; s < gesture_.strokes.size(); ++s) {
    const StrokePrompt& stroke = gesture_.strokes[s];
    PictureRect rect;
    for (const Vec2f& x : stroke.points)
      for (double side : {-1.0, 1.0}) rect.add(x.x() + side * stroke.width, x.y() + side * stroke.width);
    // Pixels as fine as the picture's, so that a thin stroke covers some.
    const double longest = std::max(rect.x1 - rect.x0, rect.y1 - rect.y0);
    const WindowView window(cameras_, stroke.camera, rect, static_cast<int>(std::clamp(longest, 24.0, 1024.0)));
    Lift lift(cloud_.size());
    lift.add(cloud_, window.camera, options_.render.within(window.frame), stroke_pixels(window, stroke));
    std::vector<Hit> hits;
    std::optional<size_t> best;  // under the stroke, where nothing is mostly
    size_t found = 0;
    for (size_t p = 0; p < cloud_.size(); ++p) {
      if (stroke.foreground && !member_[p]) continue;
      if (lift.inside[p] > (best ? lift.inside[*best] : 0.0f)) best = p;
      if (lift.inside[p] < kStrokeWeight || lift.inside[p] < kStrokeShare * lift.total[p]) continue;
      hits.push_back({p, lift.inside[p], (window.camera.cam_from_world * cloud_.position[p].cast<double>()).z()});
    }
    if (stroke.points.size() == 1) hits = one_surface(std::move(hits));
    for (const Hit& hit : hits) mark(hit.gaussian, s);
    found = hits.size();
    if (found == 0 && best) {
      mark(*best, s);
      hits.push_back({*best});
      ++found;
    }
    if (stroke.foreground && stroke.points.size() == 1)
      for (const Hit& hit : hits) clicked[s].push_back(hit.gaussian);
    if (found == 0)
      summary_.warnings.push_back(std::string(stroke.points.size() == 1 ? "a click" : "a stroke") + " in '" +
                                  cameras_[stroke.camera].name + "' hits no Gaussian that could belong to the object");
    summary_.seeds += found;
  }
  for (size_t s = 0; s < clicked.size(); ++s)
    if (!clicked[s].empty() &&
        std::all_of(clicked[s].begin(), clicked[s].end(), [&](size_t p) { return fixed_[p] < 0; }))
      summary_.warnings.push_back("a click in '" + cameras_[gesture_.strokes[s].camera].name +
                                  "' has no effect: strokes that count after it mark all that it hits as background; "
                                  "give it as --stroke fg,V,x,y behind them");
  std::vector<std::vector<int>> marks(gesture_.strokes.size());
  for (size_t p = 0; p < cloud_.size(); ++p)
    if (fixed_[p] > 0) marks[marked_by[p]].push_back(static_cast<int>(p));
  marks_.clear();
  for (std::vector<int>& of_stroke : marks)
    if (!of_stroke.empty()) marks_.push_back(std::move(of_stroke));
}

/// The nearer of the foreground's and the background's strokes, by exp(-(path / reach)^2 / 2).
void Selector::spread_seeds() {
  if (options_.stroke_reach <= 0 || gesture_.strokes.empty()) return;
  constexpr float kFar = 5;  // reaches
  spread_.assign(cloud_.size(), 0.0f);
  for (int8_t sign : {1, -1}) {
    std::vector<int> sources;
    for (size_t p = 0; p < cloud_.size(); ++p)
      if (fixed_[p] == sign) sources.push_back(static_cast<int>(p));
    std::vector<float> path;
    for (const int p : order_from(scene_.adjacency, graph_.edges, sources, &path, kFar * options_.stroke_reach)) {
      const float far = path[p] / options_.stroke_reach, weight = std::exp(-0.5f * far * far);
      if (weight > std::abs(spread_[p])) spread_[p] = sign * weight;
    }
  }
}

std::vector<float> Selector::evidence_of(const Lift& lift) const {
  std::vector<float> evidence(cloud_.size());
  for (size_t p = 0; p < evidence.size(); ++p) {
    if (lift.total[p] > 0)
      evidence[p] = options_.evidence * std::min(1.0f, lift.total[p] / options_.confident) *
                    (2 * lift.inside[p] / lift.total[p] - 1);
    if (!support_.empty()) evidence[p] += support_[p];
    if (!spread_.empty()) evidence[p] = (1 - std::abs(spread_[p])) * evidence[p] + options_.evidence * spread_[p];
    if (fixed_[p]) evidence[p] = fixed_[p] * kFixed;
  }
  return evidence;
}

}  // namespace pliant

// Masks of more of the scene's views, started from what is selected so far.

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <optional>

#include "gaussians/base/portable.h"
#include "segmentation/select/selector_look.h"

namespace pliant {

/// Windows around the selection in views whose directions differ most, those with prompts first.
std::vector<Selector::Look> Selector::looks_at_selection() {
  constexpr size_t kPoints = 2000;  // that tell where the selection lies in a view
  std::vector<Vec3f> selected;
  for (size_t p = 0; p < label_.size(); ++p)
    if (label_[p]) selected.push_back(cloud_.position[p]);
  const size_t step = std::max<size_t>(1, selected.size() / kPoints);
  struct Candidate {
    int camera;
    PictureRect rect;
    Vec3d direction;
    double distance = INFINITY;  // least squared distance of directions to the views taken
  };
  Vec3d centre = Vec3d::Zero();
  for (const Vec3f& x : selected) centre += x.cast<double>() / static_cast<double>(selected.size());
  // Prepared views, and those with prompts.
  std::vector<int> sources;
  for (const RegionView& view : scene_.views) sources.push_back(view.window.source);
  std::vector<int> first;  // where something was marked that the evidence does not hold yet
  for (const StrokePrompt& stroke : gesture_.strokes) first.push_back(stroke.camera);
  if (!proposed_.empty())
    for (const BoxPrompt& box : gesture_.boxes) first.push_back(box.camera);
  sources.insert(sources.end(), first.begin(), first.end());
  std::sort(sources.begin(), sources.end());
  sources.erase(std::unique(sources.begin(), sources.end()), sources.end());
  std::vector<std::optional<Candidate>> found(sources.size());
  parallel_for(static_cast<std::ptrdiff_t>(sources.size()), [&](std::ptrdiff_t s) {
    const int c = sources[s];
    std::vector<float> us, vs;
    size_t looked = 0, inside = 0;
    for (size_t k = 0; k < selected.size(); k += step, ++looked) {
      Eigen::Vector2d x;
      if (!project_point(cameras_[c], selected[k], x)) continue;
      us.push_back(static_cast<float>(x.x()));
      vs.push_back(static_cast<float>(x.y()));
      inside += x.x() >= 0 && x.y() >= 0 && x.x() <= cameras_[c].width && x.y() <= cameras_[c].height;
    }
    if (inside * 2 < looked || looked == 0) return;
    std::sort(us.begin(), us.end());
    std::sort(vs.begin(), vs.end());
    const auto at = [](const std::vector<float>& v, double share) {
      return v[static_cast<size_t>(share * static_cast<double>(v.size() - 1))];
    };
    PictureRect rect{at(us, 0.002), at(vs, 0.002), at(us, 0.998), at(vs, 0.998)};
    if (rect.x1 - rect.x0 < 2 || rect.y1 - rect.y0 < 2) return;
    found[s] = Candidate{c, rect.grown(0.25), (cameras_[c].centre() - centre).normalized()};
  });
  std::vector<Candidate> candidates;
  for (const auto& candidate : found)
    if (candidate) candidates.push_back(*candidate);
  std::vector<Look> looks;
  auto take = [&](size_t k) {
    Candidate& chosen = candidates[k];
    for (const StrokePrompt& stroke : gesture_.strokes)
      if (stroke.camera == chosen.camera)
        for (const Vec2f& x : stroke.points) chosen.rect.add(x.x(), x.y());
    looks.emplace_back(view_of(chosen.camera), chosen.rect, options_.refine_window);
    for (Candidate& other : candidates)
      other.distance = std::min(other.distance, (other.direction - chosen.direction).squaredNorm());
    chosen.distance = -1;
  };
  for (const int camera : first)
    for (size_t k = 0; k < candidates.size(); ++k)
      if (candidates[k].camera == camera && candidates[k].distance >= 0) take(k);
  while (static_cast<int>(looks.size()) < options_.refine_views) {
    size_t best = candidates.size();
    for (size_t k = 0; k < candidates.size(); ++k)
      if (candidates[k].distance > (best < candidates.size() ? candidates[best].distance : 1e-6)) best = k;
    if (best == candidates.size()) break;
    take(best);
  }
  return looks;
}

void Selector::refine() {
  const std::vector<Look> looks = looks_at_selection();
  // How much of what the selection so far says rests on the given views.
  std::vector<float> sure(cloud_.size());
  for (size_t p = 0; p < cloud_.size(); ++p) {
    const float seen = !proposed_.empty() ? 1.0f : std::min(1.0f, prompts_.total[p] / options_.confident);
    const float weight = member_[p] ? options_.unseen_prior + (1 - options_.unseen_prior) * seen : 1.0f;
    sure[p] = label_[p] ? weight : -weight;
  }
  std::vector<Lift> lifts(looks.size(), Lift(0));
  std::vector<size_t> order(looks.size());  // the largest first, so that threads end together
  std::iota(order.begin(), order.end(), size_t{0});
  std::ranges::stable_sort(order, std::greater(), [&](size_t v) { return looks[v].regions.size(); });
  parallel_for(static_cast<std::ptrdiff_t>(looks.size()), [&](std::ptrdiff_t turn) {
    const size_t v = order[turn];
    Look look = looks[v];
    const RegionView& view = *look.view;
    GrabCutInput& input = look.input;
    const size_t count = look.regions.size();
    input.prior.resize(count);
    input.start.resize(count);
    for (size_t k = 0; k < count; ++k) {
      const int r = look.regions[k];
      float inside = 0, belief = 0;
      for (uint32_t e = view.row_start[r]; e < view.row_start[r + 1]; ++e) {
        if (label_[view.gaussian[e]]) inside += view.weight[e];
        belief += view.weight[e] * sure[view.gaussian[e]];
      }
      input.start[k] = inside > 0.5f * view.area[r];
      input.prior[k] = options_.refine_prior * belief / view.area[r];
    }
    // Regions farther than the band from the selection are background.
    std::vector<uint8_t> near = input.start, next;
    const float side = look.scale * std::sqrt(scene_.options.view.area);
    for (int hop = 0; hop < std::max(1.0f, std::round(static_cast<float>(options_.refine_band) / side)); ++hop) {
      next = near;
      for (const CutEdge& e : input.edges) {
        next[e.a] |= near[e.b];
        next[e.b] |= near[e.a];
      }
      near.swap(next);
    }
    for (size_t k = 0; k < count; ++k)
      if (!near[k]) input.seed[k] = PixelSeed::kBackground;
    look.seed_strokes(gesture_.strokes);
    lifts[v] = Lift(cloud_.size());
    look.lift(grab_cut(options_.refine_picture, input).foreground, lifts[v]);
  });
  Lift all = prompts_;
  for (const Lift& lift : lifts) all.add(lift);
  evidence_ = evidence_of(all);
  const std::vector<uint8_t> before = label_;
  cut(options_.refine_cut);
  keep_main_part();
  for (size_t p = 0; p < label_.size(); ++p)
    if (before[p] && !label_[p] && rule_[p] != SelectionRule::kPart) rule_[p] = SelectionRule::kRefined;
  summary_.refine_views.clear();
  for (const Look& look : looks) summary_.refine_views.push_back(look.view->window.source);
}

}  // namespace pliant

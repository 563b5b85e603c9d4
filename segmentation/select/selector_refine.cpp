// Masks of more of the scene's views, started from what is selected so far.

#include <algorithm>
#include <cmath>

#include "gaussians/base/portable.h"
#include "segmentation/select/selector.h"

namespace pliant {

/// Windows around the selection in views whose directions differ most, those with prompts first.
std::vector<WindowView> Selector::views_of_selection() const {
  std::vector<Vec3f> selected;
  for (size_t i = 0; i < graph_.nodes.size(); ++i)
    if (label_[i]) selected.push_back(cloud_.position[graph_.nodes[i]]);
  const size_t step = std::max<size_t>(1, selected.size() / 5000);
  struct Candidate {
    int camera;
    PictureRect rect;
    Vec3d direction;
    double distance = INFINITY;  // least squared distance of directions to the views taken
  };
  Vec3d centre = Vec3d::Zero();
  for (const Vec3f& x : selected) centre += x.cast<double>() / static_cast<double>(selected.size());
  std::vector<Candidate> candidates;
  for (size_t c = 0; c < cameras_.size(); ++c) {
    std::vector<float> us, vs;
    size_t looked = 0, inside = 0;
    for (size_t k = 0; k < selected.size(); k += step, ++looked) {
      Eigen::Vector2d x;
      if (!project_point(cameras_[c], selected[k], x)) continue;
      us.push_back(static_cast<float>(x.x()));
      vs.push_back(static_cast<float>(x.y()));
      inside += x.x() >= 0 && x.y() >= 0 && x.x() <= cameras_[c].width && x.y() <= cameras_[c].height;
    }
    if (inside * 2 < looked || looked == 0) continue;
    std::sort(us.begin(), us.end());
    std::sort(vs.begin(), vs.end());
    const auto at = [](const std::vector<float>& v, double share) {
      return v[static_cast<size_t>(share * static_cast<double>(v.size() - 1))];
    };
    PictureRect rect{at(us, 0.002), at(vs, 0.002), at(us, 0.998), at(vs, 0.998)};
    if (rect.x1 - rect.x0 < 2 || rect.y1 - rect.y0 < 2) continue;
    candidates.push_back({static_cast<int>(c), rect.grown(0.25), (cameras_[c].centre() - centre).normalized()});
  }
  std::vector<WindowView> views;
  auto take = [&](size_t k) {
    Candidate& chosen = candidates[k];
    for (const StrokePrompt& stroke : gesture_.strokes)
      if (stroke.camera == chosen.camera)
        for (const Vec2f& x : stroke.points) chosen.rect.add(x.x(), x.y());
    views.emplace_back(cameras_, chosen.camera, chosen.rect, options_.refine_window);
    for (Candidate& other : candidates)
      other.distance = std::min(other.distance, (other.direction - chosen.direction).squaredNorm());
    chosen.distance = -1;
  };
  for (const StrokePrompt& stroke : gesture_.strokes)
    for (size_t k = 0; k < candidates.size(); ++k)
      if (candidates[k].camera == stroke.camera && candidates[k].distance >= 0) take(k);
  while (static_cast<int>(views.size()) < options_.refine_views) {
    size_t best = candidates.size();
    for (size_t k = 0; k < candidates.size(); ++k)
      if (candidates[k].distance > (best < candidates.size() ? candidates[best].distance : 1e-6)) best = k;
    if (best == candidates.size()) break;
    take(best);
  }
  return views;
}

void Selector::refine() {
  const std::vector<WindowView> views = views_of_selection();
  // What the selection so far says, and how much of it rests on the given views: two channels.
  std::vector<float> membership(2 * cloud_.size(), 0.0f);
  for (size_t p = 0; p < cloud_.size(); ++p) membership[2 * p + 1] = -1;
  for (size_t i = 0; i < graph_.nodes.size(); ++i) {
    const int p = graph_.nodes[i];
    const float seen = gesture_.boxes.empty() ? 1.0f : std::min(1.0f, prompts_.total[p] / options_.confident);
    membership[2 * p] = label_[i];
    membership[2 * p + 1] = (label_[i] ? 1.0f : -1.0f) * (options_.unseen_prior + (1 - options_.unseen_prior) * seen);
  }
  std::vector<Lift> lifts(views.size(), Lift(0));
  parallel_for(static_cast<std::ptrdiff_t>(views.size()), [&](std::ptrdiff_t v) {
    const WindowView& window = views[v];
    const RenderResult picture = render(cloud_, window.camera, options_.render, membership, 2);
    GrabCutInput input = input_of(window, picture);
    std::vector<float> P(picture.color.pixels()), sure(P.size());
    for (size_t i = 0; i < P.size(); ++i) {
      P[i] = picture.features.data[2 * i];
      sure[i] = picture.features.data[2 * i + 1];
    }
    // Pixels farther than the band from the selection are background.
    const int band = options_.refine_band;
    std::vector<uint8_t> near(P.size(), 0);
    for (int y = 0; y < input.height; ++y)
      for (int x = 0; x < input.width; ++x) {
        if (P[static_cast<size_t>(y) * input.width + x] <= 0.5f) continue;
        for (int j = std::max(0, y - band); j <= std::min(input.height - 1, y + band); ++j)
          for (int i = std::max(0, x - band); i <= std::min(input.width - 1, x + band); ++i)
            if ((i - x) * (i - x) + (j - y) * (j - y) <= band * band)
              near[static_cast<size_t>(j) * input.width + i] = 1;
      }
    input.prior.resize(P.size());
    input.start.resize(P.size());
    for (size_t i = 0; i < P.size(); ++i) {
      if (!near[i] && input.seed[i] == PixelSeed::kUnknown) input.seed[i] = PixelSeed::kBackground;
      input.prior[i] = options_.refine_prior * (options_.unseen_prior < 1 ? sure[i] : 2 * P[i] - 1);
      input.start[i] = P[i] > 0.5f;
    }
    seed_strokes(window, input);
    GrabCutOptions picture_options = options_.picture;
    picture_options.iterations = options_.refine_iterations;
    const GrabCutResult mask = grab_cut(picture_options, input);
    lifts[v] = Lift(cloud_.size());
    lifts[v].add(cloud_, window.camera, options_.render, mask.foreground);
  });
  Lift all = prompts_;
  for (const Lift& lift : lifts) all.add(lift);
  const std::vector<uint8_t> before = label_;
  cut(options_.refine_cut, all);
  keep_main_part();
  for (size_t i = 0; i < label_.size(); ++i) {
    SelectionRule& rule = rule_[graph_.nodes[i]];
    if (before[i] && !label_[i] && rule != SelectionRule::kPart) rule = SelectionRule::kRefined;
  }
  summary_.refine_views.clear();
  for (const WindowView& view : views) summary_.refine_views.push_back(view.source);
}

}  // namespace pliant

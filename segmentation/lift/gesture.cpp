#include "segmentation/lift/gesture.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>

#include "gaussians/base/error.h"
#include "gaussians/base/portable.h"
#include "segmentation/lift/contact.h"

namespace pliant {
namespace {

constexpr float kFixed = 1e4f;       // evidence on Gaussians that a stroke covers
constexpr float kStrokeShare = 0.5f; // of its visible weight that a fixed Gaussian has under the stroke
constexpr float kStrokeWeight = 0.05f;  // px of it at least

class Selector {
 public:
  Selector(const GestureOptions& options, const Gesture& gesture, const GaussianCloud& cloud, const std::vector<Camera>& cameras)
      : options_(options), gesture_(gesture), cloud_(cloud), cameras_(cameras), prompts_(cloud.size()), rule_(cloud.size()) {}

  GestureResult run(const std::optional<SelectionShape>& shape);

 private:
  void find_members(const std::optional<SelectionShape>& shape);
  void fix_seeds();
  void spread_seeds();
  void look_at_boxes();
  void propose_around_seeds();
  void cut(const GraphCutOptions& cut_options, const Lift& lift);
  void keep_main_part();
  void find_support();
  void give_back_enclosed();
  std::vector<WindowView> views_of_selection() const;
  void refine();

  GrabCutInput input_of(const WindowView& window, const RenderResult& picture) const;
  void seed_strokes(const WindowView& window, GrabCutInput& input) const;
  std::vector<float> evidence_of(const Lift& lift) const;
  std::vector<float> memberships() const;

  const GestureOptions& options_;
  const Gesture& gesture_;
  const GaussianCloud& cloud_;
  const std::vector<Camera>& cameras_;

  std::vector<uint8_t> member_;        // [N] may belong to the object
  std::vector<int8_t> fixed_;          // [N] +1 / -1 under strokes
  GaussianGraph graph_;                // of the members
  std::vector<uint8_t> label_;         // [nodes]
  std::vector<float> evidence_;        // [nodes] of the last cut
  std::vector<float> support_;         // [nodes] evidence from the plane that the object stands on
  std::vector<float> spread_;          // [nodes] -1..1, how strokes reach along the graph
  Lift prompts_;                       // of the boxes' masks
  std::vector<SelectionRule> rule_;    // [N]
  GestureResult::Summary summary_;
};

void Selector::find_members(const std::optional<SelectionShape>& shape) {
  member_.assign(cloud_.size(), 1);
  parallel_for(static_cast<std::ptrdiff_t>(cloud_.size()), [&](std::ptrdiff_t p) {
    if (shape && !shape->contains(cloud_.position[p])) member_[p] = 0;
    for (const BoxPrompt& box : gesture_.boxes) {
      Eigen::Vector2d x;
      if (!project_point(cameras_[box.camera], cloud_.position[p], x) || x.x() < box.x0 || x.x() > box.x1 || x.y() < box.y0 || x.y() > box.y1)
        member_[p] = 0;
    }
  }, 4096);
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
      fixed_[p] = stroke.foreground ? 1 : -1, ++found;
    }
    if (found == 0 && lift.inside[best] > 0 && (!stroke.foreground || member_[best])) fixed_[best] = stroke.foreground ? 1 : -1, ++found;
    if (found == 0)
      summary_.warnings.push_back(std::string(stroke.points.size() == 1 ? "a click" : "a stroke") + " in '" + cameras_[stroke.camera].name +
                                  "' meets nothing that may belong to the object");
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
  input.width = window.camera.width, input.height = window.camera.height;
  const size_t n = picture.color.pixels();
  input.lab.resize(n), input.seed.assign(n, PixelSeed::kUnknown);
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
      summary_.warnings.push_back("the box in '" + cameras_[box.camera].name + "' shows nothing that differs from what is around it");
    prompts_.add(cloud_, window.camera, options_.render, mask.foreground);
  }
}

std::vector<float> Selector::evidence_of(const Lift& lift) const {
  std::vector<float> evidence(graph_.nodes.size());
  for (size_t i = 0; i < evidence.size(); ++i) {
    const int p = graph_.nodes[i];
    if (lift.total[p] > 0)
      evidence[i] = options_.evidence * std::min(1.0f, lift.total[p] / options_.confident) * (2 * lift.inside[p] / lift.total[p] - 1);
    if (!support_.empty()) evidence[i] += support_[i];
    if (!spread_.empty()) evidence[i] = (1 - std::abs(spread_[i])) * evidence[i] + options_.evidence * spread_[i];
    if (fixed_[p]) evidence[i] = fixed_[p] * kFixed;
  }
  return evidence;
}

void Selector::cut(const GraphCutOptions& cut_options, const Lift& lift) {
  evidence_ = evidence_of(lift);
  GraphCutOptions with_seed = cut_options;
  with_seed.model.seed = options_.seed;
  cut_graph(with_seed, graph_, evidence_, label_);
}

/// The largest part, and parts that were marked as the object's.
void Selector::keep_main_part() {
  const std::vector<int> part = connected_parts(graph_, label_, options_.link);
  std::vector<uint8_t> wanted(label_.size() + 1, 0);
  wanted[0] = 1;
  for (size_t i = 0; i < label_.size(); ++i)
    if (label_[i] && fixed_[graph_.nodes[i]] > 0) wanted[part[i]] = 1;
  for (size_t i = 0; i < label_.size(); ++i) {
    if (!label_[i] || wanted[part[i]]) continue;
    label_[i] = 0, rule_[graph_.nodes[i]] = SelectionRule::kPart;
  }
}

/// Evidence against what lies in the plane under the selection, or below it.
void Selector::find_support() {
  if (options_.support <= 0 || options_.up.isZero()) return;
  const std::vector<float> membership = memberships();
  std::vector<int> object, rest;
  for (size_t p = 0; p < cloud_.size(); ++p)
    if (cloud_.opacity_logit[p] > 0) (membership[p] > 0 ? object : rest).push_back(static_cast<int>(p));
  const ContactRegion contact = contact_region(cloud_.select(object), cloud_.select(rest), options_.up);
  if (!contact.found) return;
  support_.resize(graph_.nodes.size());
  const float reach = 1.5f * std::max(contact.thickness, 1e-9f);
  for (size_t i = 0; i < support_.size(); ++i) {
    const float h = std::max(0.0f, contact.height(cloud_.position[graph_.nodes[i]])) / reach;
    support_[i] = -options_.support * std::exp(-0.5f * h * h);
  }
}

/// Colours may carve a face out of a head: what is in the boxes and touches neither their border nor the plane of what
/// lies outside them returns.
void Selector::give_back_enclosed() {
  constexpr float kTouch = 0.02f, kThick = 3;
  std::vector<int> object, rest;
  for (size_t i = 0; i < label_.size(); ++i)
    if (label_[i]) object.push_back(graph_.nodes[i]);
  for (size_t p = 0; p < cloud_.size(); ++p)
    if (!member_[p] && cloud_.opacity_logit[p] > 0) rest.push_back(static_cast<int>(p));
  ContactRegion ground;
  if (!options_.up.isZero() && !rest.empty())
    ground = contact_region(cloud_.select(object), cloud_.select(rest), options_.up);
  std::vector<uint8_t> outside(label_.size(), 0);
  for (size_t i = 0; i < label_.size(); ++i) {
    const int p = graph_.nodes[i];
    outside[i] = fixed_[p] < 0 || (ground.found && ground.height(cloud_.position[p]) < kThick * ground.thickness);
  }
  for (const int i : enclosed_nodes(graph_, label_, outside, options_.link, options_.enclosed, kTouch))
    label_[i] = 1, ++summary_.enclosed;
}

void Selector::propose_around_seeds() {
  std::vector<int> sources;
  for (size_t i = 0; i < graph_.nodes.size(); ++i)
    if (fixed_[graph_.nodes[i]] > 0) sources.push_back(static_cast<int>(i));
  const std::vector<int> order = order_from(graph_, sources);
  const size_t count = best_sweep(graph_, order, std::max<size_t>(20, 2 * sources.size()));
  label_.assign(graph_.nodes.size(), 0);
  evidence_.assign(graph_.nodes.size(), -options_.evidence);
  for (size_t k = 0; k < count; ++k) label_[order[k]] = 1, evidence_[order[k]] = options_.evidence;
  for (size_t i = 0; i < graph_.nodes.size(); ++i)
    if (fixed_[graph_.nodes[i]]) evidence_[i] = fixed_[graph_.nodes[i]] * kFixed;
  cut_graph(options_.cut, graph_, evidence_, label_);
}

std::vector<float> Selector::memberships() const {
  std::vector<float> membership(cloud_.size(), 0.0f);
  for (size_t i = 0; i < graph_.nodes.size(); ++i) membership[graph_.nodes[i]] = label_[i];
  return membership;
}

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
      us.push_back(static_cast<float>(x.x())), vs.push_back(static_cast<float>(x.y()));
      inside += x.x() >= 0 && x.y() >= 0 && x.x() <= cameras_[c].width && x.y() <= cameras_[c].height;
    }
    if (inside * 2 < looked || looked == 0) continue;
    std::sort(us.begin(), us.end()), std::sort(vs.begin(), vs.end());
    const auto at = [](const std::vector<float>& v, double share) { return v[static_cast<size_t>(share * static_cast<double>(v.size() - 1))]; };
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
    for (Candidate& other : candidates) other.distance = std::min(other.distance, (other.direction - chosen.direction).squaredNorm());
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
    for (size_t i = 0; i < P.size(); ++i) P[i] = picture.features.data[2 * i], sure[i] = picture.features.data[2 * i + 1];
    // Pixels farther than the band from the selection are background.
    const int band = options_.refine_band;
    std::vector<uint8_t> near(P.size(), 0);
    for (int y = 0; y < input.height; ++y)
      for (int x = 0; x < input.width; ++x) {
        if (P[static_cast<size_t>(y) * input.width + x] <= 0.5f) continue;
        for (int j = std::max(0, y - band); j <= std::min(input.height - 1, y + band); ++j)
          for (int i = std::max(0, x - band); i <= std::min(input.width - 1, x + band); ++i)
            if ((i - x) * (i - x) + (j - y) * (j - y) <= band * band) near[static_cast<size_t>(j) * input.width + i] = 1;
      }
    input.prior.resize(P.size()), input.start.resize(P.size());
    for (size_t i = 0; i < P.size(); ++i) {
      if (!near[i] && input.seed[i] == PixelSeed::kUnknown) input.seed[i] = PixelSeed::kBackground;
      input.prior[i] = options_.refine_prior * (options_.unseen_prior < 1 ? sure[i] : 2 * P[i] - 1), input.start[i] = P[i] > 0.5f;
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

GestureResult Selector::run(const std::optional<SelectionShape>& shape) {
  const auto start = std::chrono::steady_clock::now();
  find_members(shape);
  fix_seeds();
  graph_ = gaussian_graph(cloud_, member_, options_.neighbours);
  if (graph_.nodes.empty())
    throw usage_error(gesture_.boxes.empty() ? "--click" : "--box", "", "leaves no Gaussian that could be selected",
                      "choose boxes that show the same object");
  if (shape) graph_.border.clear();  // a shape may cut through the object, a box does not
  spread_seeds();
  if (!gesture_.boxes.empty()) {
    look_at_boxes();
    const std::vector<float> evidence = evidence_of(prompts_);
    label_.resize(evidence.size());
    for (size_t i = 0; i < evidence.size(); ++i) label_[i] = evidence[i] > 0;
    cut(options_.cut, prompts_);
  } else {
    if (std::none_of(fixed_.begin(), fixed_.end(), [](int8_t f) { return f > 0; }))
      throw usage_error("--click", "", "marks nothing of the object", "click on the object, draw a stroke fg over it, or give a --box");
    propose_around_seeds();
  }
  for (size_t i = 0; i < label_.size(); ++i)
    if (!label_[i]) rule_[graph_.nodes[i]] = SelectionRule::kCut;
  keep_main_part();
  find_support();
  const std::vector<uint8_t> first = label_;
  for (int round = 0; round < options_.refine_rounds; ++round) {
    if (std::none_of(label_.begin(), label_.end(), [](uint8_t l) { return l; })) break;
    refine();
    if (round + 1 < options_.refine_rounds) find_support();
  }

  for (size_t i = 0; i < label_.size(); ++i) summary_.added += label_[i] && !first[i];
  if (!gesture_.boxes.empty() && !shape) give_back_enclosed();

  GestureResult result;
  result.probability.assign(cloud_.size(), 0.0f);
  for (size_t i = 0; i < label_.size(); ++i) {
    const int p = graph_.nodes[i];
    // Evidence alone decides how sure the label is, the cut which side it is on.
    const float sure = sigmoid(std::clamp(evidence_[i], -6.0f, 6.0f));
    result.probability[p] = label_[i] ? std::max(sure, 0.55f) : std::min(sure, 0.45f);
    if (label_[i]) rule_[p] = SelectionRule::kKept, summary_.selected += 1;
  }
  if (summary_.selected == 0)
    throw usage_error(gesture_.boxes.empty() ? "--click" : "--box", "", "selects nothing",
                      "draw the box a little wider, or add --stroke fg,... over the object");
  for (SelectionRule rule : rule_) {
    summary_.outside += rule == SelectionRule::kOutside, summary_.cut += rule == SelectionRule::kCut;
    summary_.part += rule == SelectionRule::kPart, summary_.refined += rule == SelectionRule::kRefined;
  }
  summary_.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  result.rule = std::move(rule_);
  result.summary = std::move(summary_);
  return result;
}

}  // namespace

GestureOptions GestureOptions::prototype() {
  GestureOptions options;
  options.support = 0, options.stroke_reach = 0, options.unseen_prior = 1;
  options.enclosed = 1, options.refine_rounds = 1, options.cut.outside = options.refine_cut.outside = 0;
  return options;
}

std::string GestureResult::Summary::describe() const {
  char text[400];
  std::snprintf(text, sizeof(text),
                "%zu Gaussians selected; outside the frusta %zu, removed by the cut %zu, as separate parts %zu, by the refinement over %zu views %zu "
                "(which added %zu); %zu enclosed by the object came back; %zu fixed by strokes and clicks",
                selected, outside, cut, part, refine_views.size(), refined, added, enclosed, seeds);
  return text;
}

GestureResult select_by_gesture(const GestureOptions& options, const Gesture& gesture, const std::optional<SelectionShape>& shape,
                                const GaussianCloud& cloud, const std::vector<Camera>& cameras) {
  CHECK(!gesture.empty());
  return Selector(options, gesture, cloud, cameras).run(shape);
}

}  // namespace pliant

#include "segmentation/select/gesture.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>

#include "gaussians/base/error.h"
#include "segmentation/graph/contact.h"
#include "segmentation/select/selector.h"

namespace pliant {
namespace {

/// Least share of what lies around an object's foot that makes a plane a support (a rough lawn: a quarter; a wall
/// that the object hangs on, cut by any plane: up to a fifth).
constexpr float kPlaneShare = 0.22f;

void count_rules(const std::vector<SelectionRule>& rules, GestureResult::Summary& summary) {
  summary.selected = summary.outside = summary.cut = summary.part = summary.refined = 0;
  for (SelectionRule rule : rules) {
    summary.selected += rule == SelectionRule::kKept;
    summary.outside += rule == SelectionRule::kOutside;
    summary.cut += rule == SelectionRule::kCut;
    summary.part += rule == SelectionRule::kPart;
    summary.refined += rule == SelectionRule::kRefined;
  }
}

}  // namespace

void Selector::cut(const GraphCutOptions& cut_options, const Lift& lift) {
  evidence_ = evidence_of(lift);
  GraphCutOptions with_seed = cut_options;
  with_seed.model.seed = options_.seed;
  cut_graph(with_seed, graph_, evidence_, label_);
}

/// The largest part, parts that were marked as the object's, and those that lie against them.
void Selector::keep_main_part() {
  const std::vector<int> part = connected_parts(graph_, label_, options_.link, !planes_.empty());
  std::vector<uint8_t> wanted(label_.size() + 1, 0);
  wanted[0] = 1;
  for (size_t i = 0; i < label_.size(); ++i)
    if (label_[i] && fixed_[graph_.nodes[i]] > 0) wanted[part[i]] = 1;
  if (options_.attach) wanted = attached_parts(graph_, part, std::move(wanted));
  for (size_t i = 0; i < label_.size(); ++i) {
    if (!label_[i] || wanted[part[i]]) continue;
    label_[i] = 0;
    rule_[graph_.nodes[i]] = SelectionRule::kPart;
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
  if (!contact.found || contact.plane_share < kPlaneShare) return;
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
    outside[i] = fixed_[p] < 0 || (ground.found && ground.plane_share >= kPlaneShare &&
                                   ground.height(cloud_.position[p]) < kThick * ground.thickness);
  }
  for (const int i : enclosed_nodes(graph_, label_, outside, options_.link, options_.enclosed, kTouch)) {
    label_[i] = 1;
    ++summary_.enclosed;
  }
}

std::vector<float> Selector::memberships() const {
  std::vector<float> membership(cloud_.size(), 0.0f);
  for (size_t i = 0; i < graph_.nodes.size(); ++i) membership[graph_.nodes[i]] = label_[i];
  return membership;
}

GestureResult Selector::run(const std::optional<SelectionShape>& shape) {
  const auto start = std::chrono::steady_clock::now();
  find_members(shape);
  fix_seeds();
  graph_ = gaussian_graph(cloud_, member_, options_.neighbours);
  if (graph_.nodes.empty())
    throw usage_error(gesture_.boxes.empty() ? "--click" : "--box", "", "leaves no Gaussians that could be selected",
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
      throw usage_error("--click", "", "marks no part of the object",
                        "click on the object, draw a stroke fg over it, or give a --box");
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
    if (label_[i]) {
      rule_[p] = SelectionRule::kKept;
      summary_.selected += 1;
    }
  }
  if (summary_.selected == 0)
    throw usage_error(gesture_.boxes.empty() ? "--click" : "--box", "", "selects nothing",
                      "draw the box a little wider, or add --stroke fg,... over the object");
  count_rules(rule_, summary_);
  summary_.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  result.rule = std::move(rule_);
  result.summary = std::move(summary_);
  return result;
}

GestureOptions GestureOptions::prototype() {
  GestureOptions options;
  options.attach = false;
  options.support = 0;
  options.stroke_reach = 0;
  options.unseen_prior = 1;
  options.apart_from_planes = false;
  options.enclosed = 1;
  options.one_by_one = false;
  options.refine_rounds = 1;
  options.cut.outside = options.refine_cut.outside = 0;
  return options;
}

std::string GestureResult::Summary::describe() const {
  char text[400];
  std::snprintf(text, sizeof(text),
                "%zu Gaussians selected; outside the frusta %zu, removed by the cut %zu, as separate parts %zu, by the "
                "refinement over %zu views %zu (which added %zu); %zu enclosed by the object were restored; %zu fixed "
                "by strokes and clicks",
                selected, outside, cut, part, refine_views.size(), refined, added, enclosed, seeds);
  return text;
}

namespace {

/// A stroke over the background only takes away, one over the object only adds, whatever the new cut would do
/// elsewhere.
GestureResult joined(const GestureResult& before, GestureResult after, bool adds) {
  for (size_t p = 0; p < after.rule.size(); ++p) {
    if (after.selected(p) == before.selected(p) || after.selected(p) == adds) continue;
    after.probability[p] = before.probability[p];
    after.rule[p] = before.rule[p];
  }
  count_rules(after.rule, after.summary);
  after.summary.seconds += before.summary.seconds;
  return after;
}

}  // namespace

GestureResult select_by_gesture(const GestureOptions& options, const Gesture& gesture,
                                const std::optional<SelectionShape>& shape, const GaussianCloud& cloud,
                                const std::vector<Camera>& cameras) {
  CHECK(!gesture.empty());
  // Strokes count one after the other where boxes already say what is meant.
  if (gesture.boxes.empty() || !options.one_by_one) return Selector(options, gesture, cloud, cameras).run(shape);
  Gesture so_far;
  so_far.boxes = gesture.boxes;
  std::optional<GestureResult> result;
  for (size_t k = 0; k <= gesture.strokes.size(); ++k) {
    if (k > 0) so_far.strokes.push_back(gesture.strokes[k - 1]);
    GestureResult next = Selector(options, so_far, cloud, cameras).run(shape);
    result = result ? joined(*result, std::move(next), so_far.strokes.back().foreground) : std::move(next);
  }
  return *std::move(result);
}

}  // namespace pliant

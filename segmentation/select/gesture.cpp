#include "segmentation/select/gesture.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <iterator>

#include "gaussians/base/error.h"
#include "gaussians/base/quantile.h"
#include "segmentation/graph/contact.h"
#include "segmentation/select/selector.h"

namespace pliant {
namespace {

/// Least share of what lies around an object's foot that makes a plane a support (a rough lawn: a quarter; a wall
/// that the object hangs on, cut by any plane: up to a fifth).
constexpr float kPlaneShare = 0.22f;
constexpr float kTaken = 0.55f, kLeft = 0.45f;  // probability on either side of 1/2 that a label stands for
constexpr float kFar = 6;                       // standard deviations at which nothing is left of a normal distribution

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

/// The largest part, parts that were marked as the object's, and those that lie against them.  Where there is a
/// proposal the largest counts only as that, because colours may find something else that looks alike, and failing
/// marks the part that holds most of it.
void Selector::keep_main_part() {
  const std::vector<int> part = connected_parts(graph_, label_, options_.link, !planes_.empty());
  std::vector<uint8_t> wanted(label_.size() + 1, 0);
  bool marked = false;
  for (size_t p = 0; p < label_.size(); ++p)
    if (label_[p] && fixed_[p] > 0) {
      wanted[part[p]] = 1;
      marked = true;
    }
  if (proposed_.empty()) {
    wanted[0] = 1;
  } else {
    std::vector<size_t> size(label_.size() + 1, 0), proposed = size;
    for (size_t p = 0; p < label_.size(); ++p) {
      if (!label_[p]) continue;
      ++size[part[p]];
      proposed[part[p]] += proposed_[p];
    }
    if (2 * proposed[0] > size[0])
      wanted[0] = 1;
    else if (!marked)
      wanted[std::max_element(proposed.begin(), proposed.end()) - proposed.begin()] = 1;
  }
  if (options_.attach) wanted = attached_parts(graph_, part, std::move(wanted));
  for (size_t p = 0; p < label_.size(); ++p) {
    if (!label_[p] || wanted[part[p]]) continue;
    label_[p] = 0;
    rule_[p] = SelectionRule::kPart;
  }
}

/// Evidence against what lies in the plane under the selection, or below it.
void Selector::find_support() {
  if (options_.support <= 0 || options_.up.isZero()) return;
  std::vector<Vec3f> object, rest;
  for (size_t p = 0; p < cloud_.size(); ++p)
    if (cloud_.opacity_logit[p] > 0) (label_[p] ? object : rest).push_back(cloud_.position[p]);
  const ContactRegion contact = contact_region(object, rest, options_.up);
  if (!contact.found || contact.plane_share < kPlaneShare) return;
  support_.resize(cloud_.size());
  const float reach = 1.5f * std::max(contact.thickness, 1e-9f);
  for (size_t p = 0; p < support_.size(); ++p) {
    const float h = std::max(0.0f, contact.height(cloud_.position[p])) / reach;
    support_[p] = h > kFar ? 0.0f : -options_.support * std::exp(-0.5f * h * h);
  }
}

/// Colours may carve a face out of a head: what is in the boxes and touches neither their border nor the plane of what
/// lies outside them returns, but not what a stroke marks as background.
void Selector::give_back_enclosed() {
  constexpr float kTouch = 0.02f, kThick = 3;
  std::vector<Vec3f> object, rest;
  for (size_t p = 0; p < label_.size(); ++p) {
    if (label_[p]) object.push_back(cloud_.position[p]);
    if (!member_[p] && cloud_.opacity_logit[p] > 0) rest.push_back(cloud_.position[p]);
  }
  ContactRegion ground;
  if (!options_.up.isZero() && !rest.empty()) ground = contact_region(object, rest, options_.up);
  std::vector<float> outside(label_.size(), 0);
  for (size_t p = 0; p < label_.size(); ++p) {
    outside[p] = !member_[p] || (ground.found && ground.plane_share >= kPlaneShare &&
                                 ground.height(cloud_.position[p]) < kThick * ground.thickness);
    if (fixed_[p] < 0) outside[p] = INFINITY;
  }
  for (const int p : enclosed_nodes(graph_, label_, outside, options_.link, options_.enclosed, kTouch)) {
    if (!member_[p]) continue;
    label_[p] = 1;
    ++summary_.enclosed;
  }
}

void Selector::grow(const std::optional<SelectionShape>& shape, GestureResult& result) {
  constexpr float kReach = 2;  // median lengths of the selection's edges that one round bridges
  const auto start = std::chrono::steady_clock::now();
  find_members(shape);
  fix_seeds();
  const bool adds = gesture_.grow > 0;
  std::vector<float> length(graph_.edges.size());
  std::vector<float> inner;
  for (size_t e = 0; e < length.size(); ++e) {
    const auto& [a, b, weight] = graph_.edges[e];
    length[e] = (cloud_.position[a] - cloud_.position[b]).norm();
    if (result.selected(a) && result.selected(b)) inner.push_back(length[e]);
  }
  const float reach = kReach * quantile(std::move(inner), 0.5);
  for (int round = 0; round < std::abs(gesture_.grow); ++round) {
    std::vector<size_t> moved;
    for (size_t e = 0; e < length.size(); ++e) {
      if (graph_.edge_nearness[e] < options_.link || length[e] > reach) continue;
      const auto& [a, b, weight] = graph_.edges[e];
      for (const auto& [p, q] : {std::pair(a, b), std::pair(b, a)})
        if (result.selected(p) != adds && result.selected(q) == adds && member_[p] && fixed_[p] != (adds ? -1 : 1))
          moved.push_back(p);
    }
    for (const size_t p : moved) {
      result.probability[p] = adds ? kTaken : kLeft;
      result.rule[p] = adds ? SelectionRule::kKept : SelectionRule::kCut;
    }
  }
  count_rules(result.rule, result.summary);
  if (result.summary.selected == 0)
    throw usage_error("--grow", std::to_string(gesture_.grow), "leaves nothing selected", "shrink by less");
  result.summary.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

GestureResult Selector::run(const std::optional<SelectionShape>& shape, const std::vector<int>* part) {
  const auto start = std::chrono::steady_clock::now();
  find_members(shape);
  fix_seeds();
  if (std::none_of(member_.begin(), member_.end(), [](uint8_t m) { return m; }))
    throw usage_error(gesture_.boxes.empty() ? "--click" : "--box", "", "leaves no Gaussians that could be selected",
                      "choose boxes that show the same object");
  spread_seeds();
  label_.assign(cloud_.size(), 0);
  if (!gesture_.boxes.empty()) {
    look_at_boxes();
    evidence_ = evidence_of(prompts_);
    for (size_t p = 0; p < evidence_.size(); ++p) label_[p] = member_[p] && evidence_[p] > 0;
    cut(options_.cut);
  } else {
    if (std::none_of(fixed_.begin(), fixed_.end(), [](int8_t f) { return f > 0; }))
      throw usage_error("--click", "", "marks no part of the object",
                        "click on the object, draw a stroke fg over it, or give a --box");
    propose_around_seeds();
    cut(options_.cut);
  }
  keep_main_part();
  if (part && !part->empty())
    propose_whole(part_ = *part);
  else if (!part && !gesture_.boxes.empty() && !shape)
    find_what_fills_boxes();
  if (!part_.empty()) take_proposal_for_boxes();
  find_support();
  const std::vector<uint8_t> first = label_;
  for (int round = 0; round < options_.refine_rounds; ++round) {
    if (std::none_of(label_.begin(), label_.end(), [](uint8_t l) { return l; })) break;
    refine();
    if (round + 1 < options_.refine_rounds) find_support();
  }

  for (size_t p = 0; p < label_.size(); ++p) summary_.added += label_[p] && !first[p];
  if (!gesture_.boxes.empty() && !shape) give_back_enclosed();

  GestureResult result;
  result.probability.assign(cloud_.size(), 0.0f);
  for (size_t p = 0; p < label_.size(); ++p) {
    if (!member_[p]) continue;
    // Evidence alone decides how sure the label is, the cut which side it is on.
    const float sure = sigmoid(std::clamp(evidence_[p], -6.0f, 6.0f));
    result.probability[p] = label_[p] ? std::max(sure, kTaken) : std::min(sure, kLeft);
    if (label_[p])
      rule_[p] = SelectionRule::kKept;
    else if (rule_[p] == SelectionRule::kKept)
      rule_[p] = SelectionRule::kCut;
  }
  count_rules(rule_, summary_);
  if (summary_.selected == 0)
    throw usage_error(gesture_.boxes.empty() ? "--click" : "--box", "", "selects nothing",
                      "draw the box a little wider, or add --stroke fg,... over the object");
  summary_.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  result.rule = std::move(rule_);
  result.summary = std::move(summary_);
  return result;
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

/// Leaves of `known` what holds for the first strokes of `gesture`, or for it and strokes that were taken back.
void keep_common(const Gesture& gesture, GestureSteps& known) {
  const auto& before = known.gesture.strokes;
  const auto& now = gesture.strokes;
  if (known.gesture.boxes != gesture.boxes) {
    known.steps.clear();
  } else {
    const size_t common = std::mismatch(before.begin(), before.end(), now.begin(), now.end()).first - before.begin();
    if (common == now.size()) return;
    known.steps.erase(known.steps.upper_bound(common), known.steps.end());
  }
  known.gesture = gesture;
}

/// Adds the step of so many strokes; where there are too many, those go that the next question needs least.
void add_step(size_t strokes, GestureSteps::Step step, GestureSteps& known) {
  known.steps.insert_or_assign(strokes, std::move(step));
  while (known.steps.size() > std::max<size_t>(known.most, 1))
    known.steps.erase(known.steps.rbegin()->first > strokes ? std::prev(known.steps.end()) : known.steps.begin());
}

}  // namespace

GestureResult select_by_gesture(const GestureOptions& options, const Gesture& gesture,
                                const std::optional<SelectionShape>& shape, const GaussianCloud& cloud,
                                const std::vector<Camera>& cameras, const PreparedScene& scene, GestureSteps* steps) {
  CHECK(!gesture.empty());
  GestureSteps none{.most = 1};
  GestureSteps& known = steps ? *steps : none;
  keep_common(gesture, known);
  // Strokes count one after the other where boxes already say what is meant.
  const bool one_by_one = !gesture.boxes.empty() && options.one_by_one;
  const size_t count = gesture.strokes.size();
  const auto behind = known.steps.upper_bound(count);
  size_t next = !one_by_one ? count : behind == known.steps.begin() ? 0 : std::prev(behind)->first + 1;
  for (; next <= count && !known.steps.contains(count); ++next) {
    Gesture so_far;
    so_far.boxes = gesture.boxes;
    so_far.strokes.assign(gesture.strokes.begin(), gesture.strokes.begin() + static_cast<std::ptrdiff_t>(next));
    const GestureSteps::Step* const before = one_by_one && next > 0 ? &known.steps.at(next - 1) : nullptr;
    Selector selector(options, so_far, cloud, cameras, scene);
    GestureResult result = selector.run(shape, before ? &before->part : nullptr);
    if (before) result = joined(before->result, std::move(result), so_far.strokes.back().foreground);
    add_step(next, {std::move(result), selector.part()}, known);
  }
  GestureResult result = known.steps.at(count).result;
  if (gesture.grow != 0) Selector(options, gesture, cloud, cameras, scene).grow(shape, result);
  return result;
}

std::vector<uint8_t> guess_by_click(const GestureOptions& options, const StrokePrompt& click,
                                    const GaussianCloud& cloud, const std::vector<Camera>& cameras,
                                    const PreparedScene& scene) {
  Gesture gesture;
  gesture.strokes.push_back(click);
  return Selector(options, gesture, cloud, cameras, scene).guess();
}

}  // namespace pliant

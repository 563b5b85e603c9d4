// What a click means where no box says how large it is, and a box where colours find less than a thing.

#include <algorithm>
#include <cmath>
#include <iterator>

#include "gaussians/base/portable.h"
#include "gaussians/base/quantile.h"
#include "segmentation/select/selector.h"

namespace pliant {
namespace {

constexpr float kNearer = 0.6f;  // share of the path from the object's marks
constexpr double kMostMore = 1;  // of what a further mark proposes / what is there
// What stands on a plane that is narrower than the scene
constexpr float kTied = 2.1f;    // is tied to the rest by at most so much of what holds it / its Gaussians' root: half
                                 // a ball is by 1.9, half of that by 2.4 and more,
constexpr float kBeyond = 0.8f;  // and the plane goes on beyond it in so many directions, at least.
constexpr int kOfMark = 2, kOfPart = 1;  // superpoints of a proposal / of a mark, of a part of the thing, at least
constexpr float kRough = 1.5f;           // times as thick a rough plane may be as it was found
// IoU of a box with the rectangle around what is selected
constexpr float kFits = 0.7f;         // that of what a person means, and
constexpr float kFitsBetter = 0.15f;  // what another thing must have more.

}  // namespace

bool Selector::on_plane(int p) const {
  return std::any_of(planes_.begin(), planes_.end(),
                     [&](const Support& plane) { return plane.height(cloud_.position[p]) <= plane.tolerance; });
}

/// Without those on the planes, unless all are: a click near the foot covers some of the plane, too.
std::vector<int> Selector::before_planes(const std::vector<int>& sources) const {
  std::vector<int> before;
  std::copy_if(sources.begin(), sources.end(), std::back_inserter(before), [&](int p) { return !on_plane(p); });
  return before.empty() ? sources : before;
}

/// Takes a plane that is narrower than the scene if what was marked stands on it, as thick as it was found or, where it
/// is rough, thicker.
void Selector::try_plane(Support plane, const std::vector<int>& sources, int least) {
  const std::vector<uint8_t> label = label_;
  for (const float thickness : {1.0f, kRough}) {
    plane.tolerance *= thickness;
    planes_.push_back(plane);
    propose(sources, least);
    const bool goes_on = share_beyond(plane, cloud_.position, label_) >= kBeyond;
    const auto count = static_cast<float>(std::count(label_.begin(), label_.end(), 1));
    if (goes_on && tied_share(graph_, label_) * std::sqrt(count) <= kTied) return;
    planes_.pop_back();
    label_ = label;
    if (!goes_on) return;
  }
}

/// The planes that what was marked at these Gaussians stands on or hangs at, and the proposal apart from them.
void Selector::propose_apart_from_planes(const std::vector<int>& sources, int least) {
  Vec3f middle = Vec3f::Zero();
  for (const int p : sources) middle += cloud_.position[p] / static_cast<float>(sources.size());
  SupportOptions options;
  options.seed = options_.seed;
  std::vector<Support> nearby;
  if (options_.apart_from_planes) {
    const std::vector<Vec3f> samples = draw_points(cloud_.position, scene_.shown, options_.seed);
    planes_ = planes_behind(options, samples, middle, scene_.diagonal, graph_.spacing);
    const std::vector<float> apart = distance_to_neighbours();
    nearby = planes_nearby(options, {cloud_.position, scene_.shown, apart}, middle, scene_.diagonal, planes_);
    // Floaters may lie behind a plane of the scene, too.
    if (planes_.empty()) {
      options.beyond = INFINITY;
      std::ranges::copy(planes_behind(options, samples, middle, scene_.diagonal, graph_.spacing),
                        std::back_inserter(nearby));
    }
  }
  propose(sources, least);
  for (const Support& plane : nearby) try_plane(plane, sources, least);
}

void Selector::propose_around_seeds() {
  if (marks_.empty()) return;
  const std::vector<int>& sources = marks_[0];
  propose_apart_from_planes(sources, kOfMark);
  for (size_t k = 1; k < marks_.size(); ++k) add_proposal(marks_[k]);
  const std::vector<int> before = before_planes(sources);
  if (before.size() < sources.size()) {
    for (const int p : sources) fixed_[p] = 0;
    for (const int p : before) fixed_[p] = 1;
  }
  believe_proposal();
}

void Selector::believe_proposal() {
  proposed_ = label_;
  evidence_.assign(cloud_.size(), -options_.evidence);
  for (size_t p = 0; p < cloud_.size(); ++p) {
    if (label_[p]) evidence_[p] = options_.evidence;
    if (fixed_[p]) evidence_[p] = fixed_[p] * kFixed;
  }
}

/// Least IoU of a box with the rectangle around what is selected.
float Selector::box_fit() const {
  constexpr double kStray = 0.005;  // share of what is selected that may lie beyond either side
  float least = 1;
  for (const BoxPrompt& box : gesture_.boxes) {
    std::vector<float> us, vs;
    for (size_t p = 0; p < label_.size(); ++p) {
      Eigen::Vector2d x;
      if (!label_[p] || cloud_.opacity_logit[p] < 0 || !project_point(cameras_[box.camera], cloud_.position[p], x))
        continue;
      us.push_back(static_cast<float>(x.x()));
      vs.push_back(static_cast<float>(x.y()));
    }
    if (us.empty()) return 1;  // nothing to judge by
    const float x0 = quantile(us, kStray), x1 = quantile(us, 1 - kStray);
    const float y0 = quantile(vs, kStray), y1 = quantile(vs, 1 - kStray);
    const float both = std::max(0.0f, std::min(x1, box.x1) - std::max(x0, box.x0)) *
                       std::max(0.0f, std::min(y1, box.y1) - std::max(y0, box.y0));
    const float either = (x1 - x0) * (y1 - y0) + (box.x1 - box.x0) * (box.y1 - box.y0) - both;
    least = std::min(least, both / either);
  }
  return least;
}

/// What hangs together with a part of a thing, whatever leaves the boxes.
void Selector::propose_whole(const std::vector<int>& part) {
  const std::vector<uint8_t> member = member_;
  member_.assign(member.size(), 1);
  propose_apart_from_planes(part, kOfPart);
  member_ = member;
}

/// People draw boxes that a thing fills (Lempitsky et al. 2009), colours may take one part of it.  What hangs together
/// with that part counts instead where it fits the boxes better, judged with what leaves them.
void Selector::find_what_fills_boxes() {
  const float fit = box_fit();
  if (fit >= kFits) return;
  const std::vector<uint8_t> label = label_;
  std::vector<int> part;
  for (size_t p = 0; p < label.size(); ++p)
    if (label[p]) part.push_back(static_cast<int>(p));
  propose_whole(part);
  if (box_fit() >= fit + kFitsBetter) {
    part_ = std::move(part);
  } else {
    label_ = label;
    planes_.clear();
  }
}

/// The pictures in the boxes do not count beside a proposal, as their colours found the part alone.
void Selector::take_proposal_for_boxes() {
  for (size_t p = 0; p < label_.size(); ++p) label_[p] &= member_[p];
  prompts_ = Lift(cloud_.size());
  believe_proposal();
  cut(options_.cut);
  keep_main_part();
}

/// What hangs together with a further mark is the object's, too, unless that is more than the object so far: then what
/// was marked is a part of something larger, and the mark adds what lies around it.
void Selector::add_proposal(const std::vector<int>& sources) {
  const std::vector<uint8_t> label = label_;
  propose(sources, kOfMark);
  size_t there = 0, added = 0;
  for (size_t p = 0; p < label.size(); ++p) {
    there += label[p];
    added += label_[p] && !label[p];
  }
  if (static_cast<double>(added) > kMostMore * static_cast<double>(there))
    label_ = label;
  else
    for (size_t p = 0; p < label.size(); ++p) label_[p] |= label[p];
}

/// Mean length of the edges at every Gaussian.
std::vector<float> Selector::distance_to_neighbours() const {
  std::vector<float> apart(cloud_.size(), 0.0f);
  for (size_t p = 0; p < cloud_.size(); ++p) {
    const int first = scene_.adjacency.start[p], last = scene_.adjacency.start[p + 1];
    for (int e = first; e < last; ++e)
      apart[p] +=
          (cloud_.position[scene_.adjacency.to[e]] - cloud_.position[p]).norm() / static_cast<float>(last - first);
  }
  return apart;
}

/// What hangs together with the marked Gaussians apart from the planes, as `label_`: at least so many times as many
/// superpoints as are marked.
void Selector::propose(const std::vector<int>& sources, int least) {
  std::vector<uint8_t> behind(cloud_.size());
  for (size_t p = 0; p < cloud_.size(); ++p) behind[p] = on_plane(static_cast<int>(p));
  // The graph of the superpoints without what ties things to the planes behind them; what is left hangs together
  // whatever its colours.  A superpoint has two nodes: of its Gaussians before the planes, and of those on them.
  const Superpoints& parts = scene_.parts;
  const int count = static_cast<int>(parts.size());
  const auto node = [&](int p) { return parts.part[p] + (behind[p] ? count : 0); };
  std::vector<double> inner(2 * parts.size(), 0);
  std::vector<CutEdge> sums, strongest;
  for (const int side : {0, count})
    for (const CutEdge& e : parts.edges) sums.push_back({e.a + side, e.b + side, 0.0f});
  strongest = sums;
  std::vector<float> tie(graph_.edges.size());
  parallel_for(
      static_cast<std::ptrdiff_t>(tie.size()),
      [&](std::ptrdiff_t e) {
        const auto& [a, b, alike] = graph_.edges[e];
        if (!member_[a] || !member_[b] || behind[a] != behind[b]) return;
        const float near = graph_.edge_nearness[e];
        tie[e] = planes_.empty() ? alike : near > options_.link ? near : 0.0f;
      },
      4096);
  for (size_t e = 0; e < tie.size(); ++e) {
    if (tie[e] == 0) continue;
    const int a = graph_.edges[e].a;
    if (const int k = parts.edge_of[e]; k >= 0) {
      const size_t at = static_cast<size_t>(k) + (behind[a] ? parts.edges.size() : 0);
      sums[at].weight += tie[e];
      strongest[at].weight = std::max(strongest[at].weight, tie[e]);
    } else {
      inner[node(a)] += tie[e];
    }
  }
  const auto nodes_of = [&](const std::vector<int>& gaussians) {
    std::vector<int> nodes;
    for (const int p : gaussians) nodes.push_back(node(p));
    std::sort(nodes.begin(), nodes.end());
    nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
    return nodes;
  };
  const std::vector<int> marked = nodes_of(before_planes(sources));
  const Adjacency adjacency(inner.size(), sums);
  std::vector<int> background;
  for (size_t p = 0; p < cloud_.size(); ++p)
    if (fixed_[p] < 0) background.push_back(static_cast<int>(p));
  // What lies clearly nearer to a stroke over the background is the background's.
  const std::vector<int> order = order_apart(adjacency, strongest, marked, nodes_of(background), kNearer);
  const size_t first = best_sweep(adjacency, sums, inner, order, least * marked.size());
  std::vector<uint8_t> taken(inner.size(), 0);
  for (size_t k = 0; k < first; ++k) taken[order[k]] = 1;
  for (size_t p = 0; p < cloud_.size(); ++p) label_[p] = member_[p] && taken[node(static_cast<int>(p))];
}

std::vector<uint8_t> Selector::guess() {
  find_members({});
  fix_seeds();
  label_.assign(cloud_.size(), 0);
  if (std::any_of(fixed_.begin(), fixed_.end(), [](int8_t f) { return f > 0; })) propose_around_seeds();
  return std::move(label_);
}

}  // namespace pliant

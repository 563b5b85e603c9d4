#include "segmentation/discover/automatic_split.h"

#include <algorithm>
#include <map>
#include <queue>

#include "gaussians/base/disjoint_sets.h"

namespace pliant {
namespace {

constexpr float kTouching = 0.05f;  // nearness below which Gaussians do not lie against each other
constexpr float kSeed = 4.0f;       // spacings; side of the cells of seeds
constexpr int kFewestFeet = 5;

struct Tie {
  double strength;
  int a, b;
  bool operator<(const Tie& o) const {
    return strength != o.strength ? strength < o.strength : a != o.a ? a > o.a : b > o.b;
  }
};

}  // namespace

void GroupSums::add(const GroupSums& other) {
  share += other.share;
  volume += other.volume;
  weight += other.weight;
  lab += other.lab;
  feet += other.feet;
}

GroupSums sums_of(const SolidScene& scene, int i) {
  GroupSums sums;
  sums.share = scene.mass[i];
  sums.weight = scene.graph.opacity[i];
  sums.lab = sums.weight * scene.graph.lab[i].cast<double>();
  return sums;
}

bool distinct(const SeparateTouchingOptions& options, const GroupSums& a, const GroupSums& b,
              const GroupBorder& border) {
  Vec3d shift = a.mean_lab() - b.mean_lab();
  shift.x() *= options.lightness;
  return std::min(a.share, b.share) >= options.least_share && border.agreement < options.agreement * border.nearness &&
         shift.norm() >= options.color;
}

std::vector<int> split_things(const SeparateTouchingOptions& options, const SolidScene& scene,
                              const std::vector<int>& nodes, const std::vector<uint8_t>& foot) {
  const int n = static_cast<int>(nodes.size());
  std::vector<int> place(scene.size(), -1);
  DisjointSets sets(n);
  for (int k = 0; k < n; ++k) place[nodes[k]] = k;
  // Seeds stay inside a cell, so that no single gap in a border lets two things run together.
  const float side = kSeed * std::max(scene.graph.spacing, 1e-12f);
  std::vector<Eigen::Vector3i> cell(n);
  for (int k = 0; k < n; ++k)
    cell[k] = (scene.cloud.position[nodes[k]] / side).array().floor().max(-1e9f).min(1e9f).cast<int>();
  std::vector<size_t> inner;
  for (size_t e = 0; e < scene.graph.edges.size(); ++e) {
    const CutEdge& edge = scene.graph.edges[e];
    if (place[edge.a] < 0 || place[edge.b] < 0 || scene.graph.edge_nearness[e] < kTouching) continue;
    inner.push_back(e);
    if (scene.agreement[e] >= options.seed && cell[place[edge.a]] == cell[place[edge.b]])
      sets.join_into(place[edge.b], place[edge.a]);
  }

  // Sums of the segments and the ties between them.
  std::vector<GroupSums> sums(n);
  std::vector<std::map<int, GroupBorder>> ties(n);
  for (int k = 0; k < n; ++k) {
    GroupSums own = sums_of(scene, nodes[k]);
    own.feet = foot[nodes[k]] != 0;
    sums[sets.find(k)].add(own);
  }
  for (size_t e : inner) {
    const int a = sets.find(place[scene.graph.edges[e].a]), b = sets.find(place[scene.graph.edges[e].b]);
    const double near = scene.graph.edge_nearness[e], agreed = near * scene.agreement[e];
    sums[a].volume += agreed;
    sums[b].volume += agreed;
    if (a == b) continue;
    for (auto [from, to] : {std::pair{a, b}, std::pair{b, a}}) {
      ties[from][to].nearness += near;
      ties[from][to].agreement += agreed;
    }
  }

  // Groups that grow make ties weaker, so an old entry may promise too much and is then weighed anew.
  std::priority_queue<Tie> open;
  const auto strength = [&](int a, int b) {
    return ties[a].at(b).agreement / std::max(1e-12, std::min(sums[a].volume, sums[b].volume));
  };
  const auto offer = [&](int a, int b) { open.push({strength(a, b), std::min(a, b), std::max(a, b)}); };
  for (int a = 0; a < n; ++a)
    for (const auto& [b, border] : ties[a])
      if (a < b) offer(a, b);
  while (!open.empty()) {
    const Tie tie = open.top();
    open.pop();
    int a = tie.a, b = tie.b;
    if (sets.find(a) != a || sets.find(b) != b) continue;
    if (strength(a, b) < tie.strength) {
      offer(a, b);
      continue;
    }
    const bool both_stand = sums[a].feet >= kFewestFeet && sums[b].feet >= kFewestFeet;
    if (both_stand && distinct(options, sums[a], sums[b], ties[a].at(b))) continue;
    if (ties[a].size() < ties[b].size()) std::swap(a, b);
    sets.join_into(a, b);
    sums[a].add(sums[b]);
    ties[a].erase(b);
    for (const auto& [c, border] : ties[b]) {
      if (c == a) continue;
      ties[c].erase(b);
      for (GroupBorder* sum : {&ties[a][c], &ties[c][a]}) {
        sum->nearness += border.nearness;
        sum->agreement += border.agreement;
      }
      offer(a, c);
    }
    ties[b].clear();
  }

  std::vector<int> group(n), number(n, -1);
  int count = 0;
  for (int k = 0; k < n; ++k) {
    int& id = number[sets.find(k)];
    if (id < 0) id = count++;
    group[k] = id;
  }
  return group;
}

}  // namespace pliant

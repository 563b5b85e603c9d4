#include "segmentation/associate/mask_graph.h"

#include <algorithm>
#include <cstdint>
#include <map>
#include <tuple>

#include "gaussians/base/disjoint_sets.h"
#include "gaussians/base/random.h"

namespace pliant {
namespace {

using Pair = std::pair<int, int>;

bool stands_on_several(const MaskGraphOptions& options, const MaskRelations& relations, int mask) {
  int divided = 0, seen = 0;
  for (int v = 0; v < relations.views(); ++v) {
    const int container = relations.container_of(mask, v);
    if (container == mask || container == MaskRelations::kUnseen) continue;
    ++seen;
    divided += container == MaskRelations::kDivided;
  }
  return divided > options.divided * seen;
}

/// Where the masks of a group lie: what a view says for joining two groups is the number of pairs of their masks that
/// lie in one mask of it, and against it the number of pairs that lie in two.
struct Places {
  std::vector<Pair> in;   ///< container and how many masks of the group it holds, ascending
  std::vector<int> seen;  ///< [views] masks of the group that some container of the view holds

  void add(const Places& other) {
    std::map<int, int> sum(in.begin(), in.end());
    for (const auto& [container, count] : other.in) sum[container] += count;
    in.assign(sum.begin(), sum.end());
    for (size_t v = 0; v < seen.size(); ++v) seen[v] += other.seen[v];
  }
};

struct Evidence {
  int64_t support = 0, against = 0;
};

Evidence evidence(const Places& a, const Places& b) {
  Evidence sum;
  for (auto i = a.in.begin(), j = b.in.begin(); i != a.in.end() && j != b.in.end();) {
    if (i->first == j->first) sum.support += int64_t(i->second) * j->second;
    const bool next_i = i->first <= j->first, next_j = j->first <= i->first;
    i += next_i;
    j += next_j;
  }
  for (size_t v = 0; v < a.seen.size(); ++v) sum.against += int64_t(a.seen[v]) * b.seen[v];
  sum.against -= sum.support;
  return sum;
}

std::vector<Places> places_of_masks(const MaskRelations& relations, const std::vector<uint8_t>& several) {
  std::vector<Places> places(relations.masks());
  parallel_for(
      relations.masks(),
      [&](std::ptrdiff_t m) {
        places[m].seen.assign(relations.views(), 0);
        for (int v = 0; v < relations.views() && !several[m]; ++v) {
          const int container = relations.container_of(static_cast<int>(m), v);
          if (container < 0 || several[container]) continue;
          places[m].in.emplace_back(container, 1);
          places[m].seen[v] = 1;
        }
        std::sort(places[m].in.begin(), places[m].in.end());
      },
      64);
  return places;
}

/// Pairs of masks that lie in one mask somewhere.
std::vector<Pair> candidates(const std::vector<Places>& places) {
  std::vector<std::vector<int>> held(places.size());
  for (size_t m = 0; m < places.size(); ++m)
    for (const auto& [container, count] : places[m].in) held[container].push_back(static_cast<int>(m));
  std::vector<Pair> pairs;
  for (size_t a = 0; a < places.size(); ++a) {
    const size_t begin = pairs.size();
    for (const auto& [container, count] : places[a].in)
      for (int b : held[container])
        if (b > static_cast<int>(a)) pairs.emplace_back(static_cast<int>(a), b);
    std::sort(pairs.begin() + begin, pairs.end());
    pairs.erase(std::unique(pairs.begin() + begin, pairs.end()), pairs.end());
  }
  return pairs;
}

}  // namespace

std::vector<int> group_masks(const MaskGraphOptions& options, const MaskRelations& relations) {
  const int M = relations.masks();
  std::vector<uint8_t> several(M);
  parallel_for(
      M, [&](std::ptrdiff_t m) { several[m] = stands_on_several(options, relations, static_cast<int>(m)); }, 64);
  std::vector<Places> places = places_of_masks(relations, several);
  std::vector<Pair> pairs = candidates(places);
  DisjointSets sets(M);
  while (true) {
    // How far support leads, 0 where the views do not agree well enough; equal leads are told apart by a number.
    struct Lead {
      int64_t lead;
      uint64_t number;
      bool operator<(const Lead& other) const { return std::tie(lead, number) < std::tie(other.lead, other.number); }
    };
    std::vector<Lead> leads(pairs.size());
    parallel_for(
        static_cast<std::ptrdiff_t>(pairs.size()),
        [&](std::ptrdiff_t i) {
          const auto [a, b] = pairs[i];
          const Evidence said = evidence(places[a], places[b]);
          const bool agreed = said.support >= options.consensus * (said.support + said.against);
          leads[i] = {agreed ? said.support - said.against : 0, Random(a, b).bits()};
        },
        256);
    std::vector<Lead> best(M, {0, 0});
    int64_t strongest = 0;
    for (size_t i = 0; i < pairs.size(); ++i) {
      strongest = std::max(strongest, leads[i].lead);
      for (int m : {pairs[i].first, pairs[i].second}) best[m] = std::max(best[m], leads[i]);
    }
    if (strongest < 1) break;
    std::vector<int> joined;
    for (size_t i = 0; i < pairs.size(); ++i) {
      const auto [a, b] = pairs[i];
      if (leads[i].lead < (strongest + 1) / 2 || leads[i] < best[a] || leads[i] < best[b]) continue;
      sets.join_into(a, b);
      joined.push_back(b);
    }
    std::sort(joined.begin(), joined.end());
    for (int m : joined) {
      places[sets.find(m)].add(places[m]);
      places[m] = {};
    }
    for (Pair& pair : pairs) pair = std::minmax({sets.find(pair.first), sets.find(pair.second)});
    std::erase_if(pairs, [](const Pair& pair) { return pair.first == pair.second; });
    std::sort(pairs.begin(), pairs.end());
    pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  }
  std::vector<int> group(M, -1), number(M, -1);
  int groups = 0;
  for (int m = 0; m < M; ++m) {
    if (several[m]) continue;
    int& own = number[sets.find(m)];
    if (own < 0) own = groups++;
    group[m] = own;
  }
  return group;
}

}  // namespace pliant

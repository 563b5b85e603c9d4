#include "segmentation/lift/mask_graph.h"

#include <algorithm>
#include <map>
#include <numeric>

namespace pliant {
namespace {

/// Views that speak for and against joining two masks or groups.
struct Evidence {
  int support = 0, against = 0;
};
using Pairs = std::map<std::pair<int, int>, Evidence>;

bool stands_on_several(const MaskGraphOptions& options, const MaskRelations& relations, int mask) {
  int divided = 0, seen = 0;
  for (int v = 0; v < relations.views(); ++v) {
    const int container = relations.container_of(mask, v);
    if (container == mask || container == MaskRelations::kUnseen) continue;
    ++seen, divided += container == MaskRelations::kDivided;
  }
  return divided > options.divided * seen;
}

Evidence evidence(const MaskRelations& relations, const std::vector<uint8_t>& several, int a, int b) {
  Evidence sum;
  for (int v = 0; v < relations.views(); ++v) {
    const int in_a = relations.container_of(a, v), in_b = relations.container_of(b, v);
    if (in_a < 0 || in_b < 0 || several[in_a] || several[in_b]) continue;
    ++(in_a == in_b ? sum.support : sum.against);
  }
  return sum;
}

/// Evidence of all pairs that lie in one mask somewhere.
Pairs candidates(const MaskRelations& relations, const std::vector<uint8_t>& several) {
  std::vector<std::vector<int>> held(relations.masks());
  for (int m = 0; m < relations.masks(); ++m)
    for (int v = 0; v < relations.views(); ++v)
      if (const int container = relations.container_of(m, v); !several[m] && container >= 0 && !several[container])
        held[container].push_back(m);
  std::vector<std::pair<int, int>> pairs;
  for (int a = 0; a < relations.masks(); ++a) {
    std::vector<int> partners;
    if (several[a]) continue;
    for (int v = 0; v < relations.views(); ++v)
      if (const int container = relations.container_of(a, v); container >= 0)
        for (int b : held[container])
          if (b > a) partners.push_back(b);
    std::sort(partners.begin(), partners.end());
    partners.erase(std::unique(partners.begin(), partners.end()), partners.end());
    for (int b : partners) pairs.emplace_back(a, b);
  }
  std::vector<Evidence> found(pairs.size());
  parallel_for(static_cast<std::ptrdiff_t>(pairs.size()), [&](std::ptrdiff_t i) {
    found[i] = evidence(relations, several, pairs[i].first, pairs[i].second);
  }, 256);
  Pairs out;
  for (size_t i = 0; i < pairs.size(); ++i) out.emplace_hint(out.end(), pairs[i], found[i]);
  return out;
}

int root_of(std::vector<int>& parent, int m) {
  while (parent[m] != m) m = parent[m] = parent[parent[m]];
  return m;
}

}  // namespace

std::vector<int> group_masks(const MaskGraphOptions& options, const MaskRelations& relations) {
  const int M = relations.masks();
  std::vector<uint8_t> several(M);
  parallel_for(M, [&](std::ptrdiff_t m) { several[m] = stands_on_several(options, relations, static_cast<int>(m)); }, 64);
  Pairs pairs = candidates(relations, several);
  std::vector<int> parent(M);
  std::iota(parent.begin(), parent.end(), 0);
  int strongest = 0;
  for (const auto& [pair, said] : pairs) strongest = std::max(strongest, said.support - said.against);
  for (int level = strongest; level >= 1;) {
    bool joined = false;
    for (const auto& [pair, said] : pairs) {
      if (said.support - said.against < level || said.support < options.consensus * (said.support + said.against)) continue;
      const int a = root_of(parent, pair.first), b = root_of(parent, pair.second);
      parent[std::max(a, b)] = std::min(a, b), joined = true;
    }
    if (!joined) {
      level = level > 1 ? (level + 1) / 2 : 0;
      continue;
    }
    Pairs next;
    for (const auto& [pair, said] : pairs) {
      const int a = root_of(parent, pair.first), b = root_of(parent, pair.second);
      if (a == b) continue;
      Evidence& sum = next[std::minmax(a, b)];
      sum.support += said.support, sum.against += said.against;
    }
    pairs = std::move(next);
  }
  std::vector<int> group(M, -1), number(M, -1);
  int groups = 0;
  for (int m = 0; m < M; ++m) {
    if (several[m]) continue;
    int& own = number[root_of(parent, m)];
    if (own < 0) own = groups++;
    group[m] = own;
  }
  return group;
}

}  // namespace pliant

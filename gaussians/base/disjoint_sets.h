#pragma once

#include <algorithm>
#include <numeric>
#include <vector>

namespace pliant {

/// Sets of the numbers below n that grow together; each is known by its smallest member.
class DisjointSets {
 public:
  explicit DisjointSets(size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), 0); }

  int find(int i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  /// Whether they were apart.
  bool join(int i, int k) {
    const int a = find(i), b = find(k);
    parent_[std::max(a, b)] = std::min(a, b);
    return a != b;
  }

 private:
  std::vector<int> parent_;
};

}  // namespace pliant

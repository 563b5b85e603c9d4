#pragma once

#include <algorithm>
#include <numeric>
#include <vector>

namespace pliant {

/// Sets of the numbers below n that grow together; each is known by its smallest member.
class DisjointSets {
 public:
  explicit DisjointSets(size_t n = 0) : parent_(n) { std::iota(parent_.begin(), parent_.end(), 0); }

  /// The next number, a set of its own.
  int add() {
    parent_.push_back(static_cast<int>(parent_.size()));
    return parent_.back();
  }
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

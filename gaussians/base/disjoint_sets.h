#pragma once

#include <algorithm>
#include <numeric>
#include <vector>

namespace pliant {

/// Sets of the numbers below n that grow together; each is known by one member.
class DisjointSets {
 public:
  explicit DisjointSets(size_t n = 0) : parent_(n) { std::iota(parent_.begin(), parent_.end(), 0); }

  /// The next number, a set of its own.
  int add() {
    parent_.push_back(static_cast<int>(parent_.size()));
    return parent_.back();
  }
  /// The member by which the set of i is known.
  int find(int i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  /// The union is known by the smaller of both, so by its smallest member where every union is made here.  Returns
  /// whether they were apart.
  bool join(int i, int k) {
    const int a = find(i), b = find(k);
    parent_[std::max(a, b)] = std::min(a, b);
    return a != b;
  }
  /// The union is known by what the set of i was known by.  Returns whether they were apart.
  bool join_into(int i, int k) {
    const int a = find(i), b = find(k);
    parent_[b] = a;
    return a != b;
  }

 private:
  std::vector<int> parent_;
};

}  // namespace pliant

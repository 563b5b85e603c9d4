#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

namespace pliant {

/// How many pixels of each id lie in each group of masks.
class IdTally {
 public:
  explicit IdTally(size_t groups) : by_id_(groups), whole_(groups, 0) {}

  /// Pixels of a mask with `id`; group -1 = in no group, or in several.
  void add(int group, uint32_t id, double pixels);
  double whole(int group) const { return whole_[group]; }
  /// Of every group, the id that carries most of it and lies mostly in it; 0 = none.  No two groups have the same.
  std::vector<uint32_t> kept() const;

 private:
  std::vector<std::map<uint32_t, double>> by_id_;  ///< [groups]
  std::vector<double> whole_;                      ///< [groups]
  std::map<uint32_t, double> all_;                 ///< of an id
};

}  // namespace pliant

#pragma once

#include <cstdint>
#include <vector>

namespace pliant {

/// Numbers of blocks by key; a hash table with open addressing (Knuth 1973, vol. 3, section 6.4).
class BlockTable {
 public:
  void clear(size_t expected) {
    size_t slots = 16;
    while (slots < 4 * expected) slots *= 2;
    key_.assign(slots, kFree);
    value_.resize(slots);
    count_ = 0;
  }
  /// The number stored under `key`, or -1.
  int find(uint64_t key) const {
    if (key_.empty()) return -1;
    const size_t slot = slot_of(key);
    return key_[slot] == kFree ? -1 : value_[slot];
  }
  /// The number stored under `key`, after storing `value` if there was none.
  int insert(uint64_t key, int value) {
    if (2 * (count_ + 1) > key_.size()) grow();
    const size_t slot = slot_of(key);
    if (key_[slot] == kFree) {
      key_[slot] = key;
      value_[slot] = value;
      ++count_;
    }
    return value_[slot];
  }

 private:
  static constexpr uint64_t kFree = ~uint64_t{0};

  size_t slot_of(uint64_t key) const {
    const size_t mask = key_.size() - 1;
    size_t slot = (key * 0x9E3779B97F4A7C15u >> 20) & mask;
    while (key_[slot] != kFree && key_[slot] != key) slot = (slot + 1) & mask;
    return slot;
  }
  void grow() {
    const std::vector<uint64_t> key = std::move(key_);
    const std::vector<int> value = std::move(value_);
    clear(key.size());
    for (size_t i = 0; i < key.size(); ++i)
      if (key[i] != kFree) insert(key[i], value[i]);
  }

  std::vector<uint64_t> key_;
  std::vector<int> value_;
  size_t count_ = 0;
};

}  // namespace pliant

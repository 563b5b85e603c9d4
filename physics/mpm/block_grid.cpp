#include "physics/mpm/block_grid.h"

#include <algorithm>
#include <numeric>

#include "gaussians/base/error.h"

namespace pliant {
namespace {

constexpr int kBias = 1 << 15;
constexpr uint64_t kPlace = (uint64_t{1} << 48) - 1;  // the part of a key that is not the object

uint64_t key_of(const BlockGrid::Coordinates& c) {
  const auto biased = [](int k) { return static_cast<uint64_t>(k + kBias); };
  return static_cast<uint64_t>(c.object) << 48 | biased(c.x) << 32 | biased(c.y) << 16 | biased(c.z);
}

BlockGrid::Coordinates coordinates_of(uint64_t key) {
  const auto part = [&](int shift) { return static_cast<int>(key >> shift & 0xffff); };
  return {part(32) - kBias, part(16) - kBias, part(0) - kBias, part(48)};
}

}  // namespace

void BlockGrid::build(std::span<const Coordinates> block_of_particle) {
  // Blocks are numbered as they appear, then in ascending order of their keys.
  ++version_;
  const size_t n = block_of_particle.size();
  std::vector<uint64_t> keys;
  std::vector<int> number(n), count;
  block_table_.clear(n / 256);
  uint64_t last_key = ~uint64_t{0};
  int last = -1;
  for (size_t i = 0; i < n; ++i) {
    const Coordinates& c = block_of_particle[i];
    CHECK(std::max({std::abs(c.x), std::abs(c.y), std::abs(c.z)}) <= kReach && c.object >= 0 && c.object < kBias);
    const uint64_t key = key_of(c);
    if (key != last_key) {
      last = block_table_.insert(key, static_cast<int>(keys.size()));
      if (last == static_cast<int>(keys.size())) {
        keys.push_back(key);
        count.push_back(0);
      }
      last_key = key;
    }
    number[i] = last;
    ++count[last];
  }
  std::vector<int> sorted(keys.size());
  std::iota(sorted.begin(), sorted.end(), 0);
  std::sort(sorted.begin(), sorted.end(), [&](int a, int b) { return keys[a] < keys[b]; });

  std::vector<uint64_t> sorted_keys(keys.size());
  std::vector<int> cursor(keys.size());
  begin_.assign(1, 0);
  for (size_t b = 0; b < keys.size(); ++b) {
    sorted_keys[b] = keys[sorted[b]];
    cursor[sorted[b]] = begin_.back();
    begin_.push_back(begin_.back() + count[sorted[b]]);
  }
  order_.resize(n);
  for (size_t i = 0; i < n; ++i) order_[cursor[number[i]]++] = static_cast<int>(i);
  previous_.assign(keys.size(), -1);
  link(sorted_keys);
}

void BlockGrid::move(std::span<const Move> moves) {
  if (moves.empty()) return;
  ++version_;
  // Sizes after the moves; blocks that appear get numbers beyond the present ones.
  const int old_blocks = particle_blocks();
  std::vector<int> size(old_blocks), target(moves.size());
  for (int b = 0; b < old_blocks; ++b) size[b] = begin_[b + 1] - begin_[b];
  std::vector<uint64_t> appearing;
  int b = 0;
  for (size_t m = 0; m < moves.size(); ++m) {
    while (moves[m].place >= begin_[b + 1]) ++b;
    --size[b];
    const uint64_t key = key_of(moves[m].to);
    target[m] = block_table_.insert(key, static_cast<int>(size.size()));
    if (target[m] == static_cast<int>(size.size())) {
      appearing.push_back(key);
      size.push_back(0);
    }
    ++size[target[m]];
  }

  std::vector<int> next(size.size());  // where the next particle of a block goes, by its number before
  std::vector<int> begin(1, 0);
  const bool same = appearing.empty() && std::find(size.begin(), size.end(), 0) == size.end();
  if (same) {
    for (int k = 0; k < old_blocks; ++k) {
      next[k] = begin.back();
      begin.push_back(begin.back() + size[k]);
    }
  } else {
    std::vector<std::pair<uint64_t, int>> kept;
    for (size_t k = 0; k < size.size(); ++k)
      if (size[k] > 0)
        kept.emplace_back(static_cast<int>(k) < old_blocks ? key_of(block_[k]) : appearing[k - old_blocks],
                          static_cast<int>(k));
    std::sort(kept.begin(), kept.end());
    std::vector<uint64_t> sorted_keys;
    previous_.clear();
    for (const auto& [key, k] : kept) {
      sorted_keys.push_back(key);
      previous_.push_back(k < old_blocks ? k : -1);
      next[k] = begin.back();
      begin.push_back(begin.back() + size[k]);
    }
    link(sorted_keys);
  }

  // Those that stay keep their order; stretches between two that leave are copied at once.
  spare_order_.resize(order_.size());
  size_t m = 0;
  for (int k = 0; k < old_blocks; ++k) {
    int from = begin_[k];
    const auto copy_up_to = [&](int end) {
      std::copy(order_.begin() + from, order_.begin() + end, spare_order_.begin() + next[k]);
      next[k] += end - from;
    };
    for (; m < moves.size() && moves[m].place < begin_[k + 1]; ++m) {
      copy_up_to(moves[m].place);
      from = moves[m].place + 1;
    }
    copy_up_to(begin_[k + 1]);
  }
  for (size_t k = 0; k < moves.size(); ++k) spare_order_[next[target[k]]++] = order_[moves[k].place];
  order_.swap(spare_order_);
  begin_ = std::move(begin);
}

int BlockGrid::find(const Coordinates& c) const { return block_table_.find(key_of(c)); }

void BlockGrid::link(const std::vector<uint64_t>& sorted_keys) {
  ++link_version_;
  const size_t blocks = sorted_keys.size();
  block_.clear();
  node_block_.clear();
  node_links_.clear();
  further_links_.clear();
  further_begin_.clear();
  particle_links_.resize(blocks);
  block_table_.clear(blocks);
  node_table_.clear(2 * blocks);
  for (size_t b = 0; b < blocks; ++b) {
    block_table_.insert(sorted_keys[b], static_cast<int>(b));
    block_.push_back(coordinates_of(sorted_keys[b]));
    for (int o = 0; o < 8; ++o) {
      Coordinates c = block_[b];
      c.x += o >> 2;
      c.y += o >> 1 & 1;
      c.z += o & 1;
      const int fresh = static_cast<int>(node_block_.size()), n = node_table_.insert(key_of(c), fresh);
      if (n == fresh) {
        node_block_.push_back(c);
        node_links_.push_back({-1, -1, -1, -1, -1, -1, -1, -1});
      }
      particle_links_[b][o] = n;
      node_links_[n][o] = static_cast<int>(b);
    }
  }

  // Blocks are sorted by object first, so there is one object if the first and the last are of the same.
  sibling_.resize(node_block_.size());
  std::iota(sibling_.begin(), sibling_.end(), 0);
  has_siblings_ = false;
  if (blocks == 0 || block_.front().object == block_.back().object) return;
  BlockTable first;
  first.clear(node_block_.size());
  for (int n = 0; n < node_blocks(); ++n) {
    const int head = first.insert(key_of(node_block_[n]) & kPlace, n);
    if (head == n) continue;
    has_siblings_ = true;
    std::swap(sibling_[n], sibling_[head]);
  }
}

int BlockGrid::find_node_block(const Coordinates& at) const {
  const bool inside = std::abs(at.x) < kReach && std::abs(at.y) < kReach && std::abs(at.z) < kReach;
  return inside ? node_table_.find(key_of(at)) : -1;
}

}  // namespace pliant

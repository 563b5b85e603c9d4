#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "gaussians/base/portable.h"

namespace pliant {

/// Order in which `keys` (unsigned integers) ascend; equal keys keep their order.  Least significant digit first; each
/// pass counts and scatters fixed blocks in parallel, so the result does not depend on the number of threads.
template <class Key>
std::vector<uint32_t> sorted_order(std::span<const Key> keys) {
  constexpr int kBits = 11, kDigits = 1 << kBits;
  constexpr std::ptrdiff_t kSmallestBlock = 8192, kMostBlocks = 16;
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(keys.size());
  const std::ptrdiff_t block = std::max(kSmallestBlock, (n + kMostBlocks - 1) / kMostBlocks);
  const std::ptrdiff_t blocks = (n + block - 1) / block;
  std::vector<uint32_t> order(n), next(n);
  std::vector<Key> key(keys.begin(), keys.end()), next_key(n);
  for (std::ptrdiff_t i = 0; i < n; ++i) order[i] = static_cast<uint32_t>(i);
  std::vector<std::array<uint32_t, kDigits>> count(blocks);
  for (int shift = 0; shift < static_cast<int>(8 * sizeof(Key)); shift += kBits) {
    const auto digit = [&](std::ptrdiff_t i) { return static_cast<uint32_t>(key[i] >> shift) & (kDigits - 1); };
    parallel_for(blocks, [&](std::ptrdiff_t b) {
      count[b].fill(0);
      for (std::ptrdiff_t i = b * block; i < std::min(n, (b + 1) * block); ++i) ++count[b][digit(i)];
    });
    uint32_t start = 0;
    bool trivial = false;
    for (int d = 0; d < kDigits; ++d) {
      const uint32_t before = start;
      for (auto& of_block : count) {
        const uint32_t here = of_block[d];
        of_block[d] = start;
        start += here;
      }
      trivial |= start - before == static_cast<uint32_t>(n);
    }
    if (trivial) continue;
    parallel_for(blocks, [&](std::ptrdiff_t b) {
      for (std::ptrdiff_t i = b * block; i < std::min(n, (b + 1) * block); ++i) {
        const uint32_t to = count[b][digit(i)]++;
        next[to] = order[i];
        next_key[to] = key[i];
      }
    });
    order.swap(next);
    key.swap(next_key);
  }
  return order;
}

}  // namespace pliant

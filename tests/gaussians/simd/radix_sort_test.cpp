// The radix sort against the standard library's stable sort.

#include "gaussians/simd/radix_sort.h"

#include <gtest/gtest.h>

#include <numeric>

#include "gaussians/base/random.h"

namespace pliant {
namespace {

template <class Key>
void expect_stable_order(int n, uint64_t bound) {
  std::vector<Key> keys(n);
  Random random(n);
  for (Key& key : keys) key = static_cast<Key>(bound ? random.below(bound) : random.bits());
  std::vector<uint32_t> expected(n);
  std::iota(expected.begin(), expected.end(), 0u);
  std::stable_sort(expected.begin(), expected.end(), [&](uint32_t a, uint32_t b) { return keys[a] < keys[b]; });
  EXPECT_EQ(sorted_order<Key>(keys), expected);
}

TEST(RadixSort, OrdersLikeAStableSort) {
  for (int n : {0, 1, 2, 1000, 100000}) {
    expect_stable_order<uint32_t>(n, 0);
    expect_stable_order<uint64_t>(n, 0);
    expect_stable_order<uint32_t>(n, 50);
  }
}

}  // namespace
}  // namespace pliant

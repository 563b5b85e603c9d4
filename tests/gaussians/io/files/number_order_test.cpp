// The order of numbered names: runs of digits count as numbers, zeros before them do not.

#include "gaussians/io/files/number_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace pliant {
namespace {

TEST(NumberOrder, RunsOfDigitsAreNumbers) {
  const std::vector<std::string> ordered = {"cam2/9.png", "cam2/010.png", "cam2/11.png", "cam10/1.png", "cam10/x"};
  std::vector<std::string> shuffled = ordered;
  do {
    std::vector<std::string> sorted = shuffled;
    std::sort(sorted.begin(), sorted.end(), number_order);
    ASSERT_EQ(sorted, ordered);
  } while (std::next_permutation(shuffled.begin(), shuffled.end()));
}

TEST(NumberOrder, IsStrictAlsoForEqualNumbers) {
  EXPECT_FALSE(number_order("a1", "a1"));
  EXPECT_NE(number_order("a1", "a01"), number_order("a01", "a1"));
  EXPECT_TRUE(number_order("a", "a1"));
}

}  // namespace
}  // namespace pliant

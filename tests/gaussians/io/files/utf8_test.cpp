#include "gaussians/io/files/utf8.h"

#include <gtest/gtest.h>

namespace pliant {
namespace {

TEST(Utf8, CharactersAreCountedAndNeverCut) {
  const std::string text = "a\u00e9\u690d\U0001f331";  // of 1, 2, 3 and 4 bytes
  EXPECT_EQ(character_count(text), 4u);
  EXPECT_EQ(character_count(""), 0u);
  const size_t ends[] = {0, 1, 1, 3, 3, 3, 6, 6, 6, 6, 10, 10};
  for (size_t most = 0; most < std::size(ends); ++most) EXPECT_EQ(beginning_of(text, most), text.substr(0, ends[most]));
}

}  // namespace
}  // namespace pliant

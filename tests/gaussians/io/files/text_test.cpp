// Pieces of text: split and joined again is the same text, and what is trimmed or in lower case stays so.

#include "gaussians/io/files/text.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

namespace pliant {
namespace {

TEST(Text, SplitKeepsEveryPieceSoThatJoiningThemGivesTheText) {
  using Pieces = std::vector<std::string>;
  EXPECT_EQ(split("a,b c,d", ','), (Pieces{"a", "b c", "d"}));
  EXPECT_EQ(split("", ','), Pieces{""});
  for (const std::string text : {"a", ",", "a,", ",a", "a,,b", ",,", " a , b "}) {
    const Pieces pieces = split(text, ',');
    std::string joined = pieces[0];
    for (size_t k = 1; k < pieces.size(); ++k) joined += "," + pieces[k];
    EXPECT_EQ(joined, text);
    EXPECT_EQ(pieces.size(), 1u + std::count(text.begin(), text.end(), ','));
  }
  EXPECT_EQ(split("1;2", ';'), (Pieces{"1", "2"}));
}

TEST(Text, TrimmedLosesSpaceAtEitherEndOnly) {
  EXPECT_EQ(trimmed(" \t a b\r\n"), "a b");
  EXPECT_EQ(trimmed(" \t\r\n"), "");
  EXPECT_EQ(trimmed(""), "");
  EXPECT_EQ(trimmed("\" x\" ", " \""), "x");
}

TEST(Text, LowerCaseChangesTheLettersOfAsciiAlone) {
  EXPECT_EQ(lower_case("AZaz09_ @["), "azaz09_ @[");
  EXPECT_EQ(lower_case("\xc3\x84"), "\xc3\x84");
  EXPECT_EQ(lower_extension("photos/A.b/C.JpG"), ".jpg");
  EXPECT_EQ(lower_extension("A.B/C"), "");
}

}  // namespace
}  // namespace pliant

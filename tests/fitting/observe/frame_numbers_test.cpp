// Numbers in the names of pictures tell which frames they are, and which are missing.

#include "fitting/observe/frame_numbers.h"

#include <gtest/gtest.h>

namespace pliant {
namespace {

FrameNumbers numbered(const std::vector<std::string>& names) {
  return frame_numbers(std::vector<std::filesystem::path>(names.begin(), names.end()));
}

using Frames = std::vector<long long>;

TEST(FrameNumbers, StepsOfOneSizeAreFrames) {
  for (const auto& names :
       {std::vector<std::string>{"f_8.png", "f_9.png", "f_10.png", "f_11.png"},
        {"f_0010.png", "f_0020.png", "f_0030.png", "f_0040.png"},
        {"take2_f001_left.jpg", "take2_f002_left.jpg", "take2_f003_left.jpg", "take2_f004_left.jpg"}}) {
    const FrameNumbers some = numbered(names);
    EXPECT_EQ(some.frame, (Frames{0, 1, 2, 3})) << names[0];
    EXPECT_EQ(some.doubt, "") << names[0];
  }
}

TEST(FrameNumbers, MissingOnesKeepTheirPlaceAndAreNamed) {
  const FrameNumbers one = numbered({"f_1.png", "f_2.png", "f_4.png", "f_5.png", "f_8.png"});
  EXPECT_EQ(one.frame, (Frames{0, 1, 3, 4, 7}));
  EXPECT_EQ(one.missing, "3, 6 to 7");
  EXPECT_NE(one.doubt.find("numbered 3, 6 to 7:"), std::string::npos) << one.doubt;
  const FrameNumbers tens = numbered({"f_0.png", "f_10.png", "f_20.png", "f_40.png"});
  EXPECT_EQ(tens.frame, (Frames{0, 1, 2, 4}));
  EXPECT_NE(tens.doubt.find("numbered 30:"), std::string::npos) << tens.doubt;
  const FrameNumbers many = numbered({"1.png", "3.png", "4.png", "6.png", "7.png", "9.png", "10.png", "12.png"});
  EXPECT_NE(many.doubt.find("2, 5, 8 and 1 more gaps"), std::string::npos) << many.doubt;
}

TEST(FrameNumbers, OthersAreConsecutive) {
  for (const auto& names : {std::vector<std::string>{"a.png", "b.png", "d.png"},
                            {"2024_01_30.png", "2024_02_28.png", "2024_02_30.png"},
                            {"f_1.png", "f_3.png", "g_4.png"},
                            {"f_01.png", "f_1.png", "f_3.png"},
                            {"f_1.png", "f_3.png", "f_99999999999999999999999.png"}}) {
    const FrameNumbers some = numbered(names);
    EXPECT_EQ(some.frame, (Frames{0, 1, 2})) << names[0];
    EXPECT_EQ(some.doubt, "") << names[0];
  }
  // Instants in nanoseconds, and two recordings in one folder.
  for (const auto& names : {std::vector<std::string>{"1699000033.png", "1699000066.png", "1699000100.png"},
                            {"f_1.png", "f_2.png", "f_500.png"}}) {
    const FrameNumbers some = numbered(names);
    EXPECT_EQ(some.frame, (Frames{0, 1, 2})) << names[0];
    EXPECT_NE(some.doubt.find("consecutive"), std::string::npos) << some.doubt;
    EXPECT_EQ(some.missing, "");
  }
  EXPECT_TRUE(numbered({}).frame.empty());
}

}  // namespace
}  // namespace pliant

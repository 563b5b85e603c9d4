#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace pliant {

/// Which frames of a video some pictures are.
struct FrameNumbers {
  std::vector<long long> frame;  ///< [N] growing from 0
  std::string missing;           ///< between the first and the last, as "3, 6 to 7"; empty = none are, or none count
  std::string doubt;             ///< says which numbers are missing, or why they do not count; empty = none are
};

/// Of pictures in their order, by the one number that differs in their names; the smallest step between two is one
/// frame.  Where names have no such number, its steps are no multiples of the smallest, or more frames would be missing
/// than there are, the pictures are consecutive frames.
FrameNumbers frame_numbers(const std::vector<std::filesystem::path>& pictures);

}  // namespace pliant

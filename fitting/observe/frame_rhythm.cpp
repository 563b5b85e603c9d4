#include "fitting/observe/frame_rhythm.h"

#include <algorithm>
#include <cstdint>
#include <vector>

namespace pliant {
namespace {

constexpr int kLongest = 12, kBlocks = 3;  // frames of a period; periods in each half
constexpr double kMovingShare = 0.2;       // of the largest change: below it the object rests
constexpr double kStill = 0.1;             // of the largest step: a frame shown again
constexpr double kStep =
    0.35;  // of the largest step: one of the motion, since speed changes from place to place of the pattern
constexpr double kDouble = 1.5;  // times the next largest step: a frame is missing
constexpr double kEven = 0.6;    // of the next largest step: the rest of such a pattern

/// What the frames at each place of a pattern are.
struct Places {
  std::vector<uint8_t> still, doubled;
  bool operator==(const Places&) const = default;
};

Places places_of(std::span<const float> change, size_t begin, size_t end, int period) {
  std::vector<double> mean(period, 0), count(period, 0);
  for (size_t t = begin; t < end; ++t) {
    mean[t % period] += change[t];
    count[t % period] += 1;
  }
  for (int q = 0; q < period; ++q) mean[q] /= count[q];
  std::vector<double> sorted = mean;
  std::sort(sorted.rbegin(), sorted.rend());
  Places out{std::vector<uint8_t>(period, 0), std::vector<uint8_t>(period, 0)};
  const bool one_double =
      sorted[0] > kDouble * sorted[1] && sorted.back() > std::max(kEven * sorted[1], kStill * sorted[0]);
  for (int q = 0; q < period; ++q) {
    out.doubled[q] = one_double && mean[q] == sorted[0];
    out.still[q] = mean[q] < kStill * sorted[0];
    // A step that is neither belongs to no pattern.
    if (!out.still[q] && mean[q] < kStep * sorted[0]) return {};
  }
  return out;
}

}  // namespace

FrameRhythm find_rhythm(std::span<const float> change) {
  if (change.size() < 2) return {};
  const float moving = static_cast<float>(kMovingShare) * *std::max_element(change.begin() + 1, change.end());
  size_t begin = 1, end = change.size();
  while (begin < end && !(change[begin] > moving)) ++begin;
  while (end > begin && !(change[end - 1] > moving)) --end;
  const size_t middle = (begin + end) / 2;
  for (int period = 2; period <= kLongest && end - begin >= 2 * static_cast<size_t>(kBlocks * period); ++period) {
    const Places first = places_of(change, begin, middle, period);
    if (first.still.empty() || first != places_of(change, middle, end, period)) continue;
    FrameRhythm rhythm{period, static_cast<int>(std::count(first.still.begin(), first.still.end(), 1)),
                       static_cast<int>(std::count(first.doubled.begin(), first.doubled.end(), 1))};
    if (rhythm.repeated > 0 || rhythm.missing > 0) return rhythm;
  }
  return {};
}

}  // namespace pliant

#include "segmentation/models/feature_memory.h"

#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <cmath>

#include "gaussians/base/random.h"

using namespace pliant;

namespace {

constexpr size_t kChannels = 3, kPixels = 20, kValues = 2;

std::vector<float> numbers(size_t count, uint64_t seed, double low = -1) {
  std::vector<float> values;
  for (size_t i = 0; i < count; ++i) values.push_back(static_cast<float>(Random(seed, i).uniform(low, 1)));
  return values;
}

FeatureMemory::Frame frame(uint64_t seed, const std::vector<uint32_t>& things) {
  FeatureMemory::Frame made{numbers(kChannels * kPixels, seed), numbers(kPixels, seed + 1, 0.5), {}};
  for (const uint32_t thing : things) made.value[thing] = numbers(kValues * kPixels, seed + 10 * thing);
  return made;
}

/// The definition, in double and with a full sort.
double expected(const std::vector<FeatureMemory::Frame>& frames, uint32_t thing, const std::vector<float>& query,
                const std::vector<float>& selection, size_t queries, size_t q, size_t v, size_t top) {
  std::vector<std::pair<double, double>> pixels;  // similarity, value
  for (const FeatureMemory::Frame& known : frames) {
    if (!known.value.count(thing)) continue;
    for (size_t i = 0; i < kPixels; ++i) {
      double distance = 0;
      for (size_t c = 0; c < kChannels; ++c)
        distance += selection[c * queries + q] * std::pow(known.key[c * kPixels + i] - query[c * queries + q], 2);
      pixels.emplace_back(-known.shrinkage[i] * distance / std::sqrt(3.0), known.value.at(thing)[v * kPixels + i]);
    }
  }
  std::sort(pixels.rbegin(), pixels.rend());
  double sum = 0, total = 0;
  for (size_t k = 0; k < std::min(top, pixels.size()); ++k) {
    sum += std::exp(pixels[k].first) * pixels[k].second;
    total += std::exp(pixels[k].first);
  }
  return sum / total;
}

}  // namespace

TEST(FeatureMemory, ReadsTheSoftmaxOverTheNearestPixelsOfTheFramesThatKnowTheThing) {
  const std::vector<FeatureMemory::Frame> frames = {frame(1, {7}), frame(2, {7, 9}), frame(3, {7, 9})};
  FeatureMemory memory;
  for (const auto& one : frames) memory.add(one, 10);
  const size_t queries = 70;
  const std::vector<float> query = numbers(kChannels * queries, 50), selection = numbers(kChannels * queries, 60, 0);
  const auto read = memory.read(query, selection, kChannels, {7, 9}, 5);
  ASSERT_EQ(read.size(), 2u);
  for (size_t q = 0; q < queries; ++q)
    for (size_t v = 0; v < kValues; ++v) {
      EXPECT_NEAR(read[0][v * queries + q], expected(frames, 7, query, selection, queries, q, v, 5), 1e-5);
      EXPECT_NEAR(read[1][v * queries + q], expected(frames, 9, query, selection, queries, q, v, 5), 1e-5);
    }
}

TEST(FeatureMemory, ReadingIsTheSameForAnyNumberOfThreads) {
  FeatureMemory memory;
  memory.add(frame(1, {7}), 10);
  const std::vector<float> query = numbers(kChannels * 300, 5), selection = numbers(kChannels * 300, 6, 0);
  const int threads = omp_get_max_threads();
  omp_set_num_threads(1);
  const auto one = memory.read(query, selection, kChannels, {7}, 8);
  omp_set_num_threads(3);
  EXPECT_EQ(memory.read(query, selection, kChannels, {7}, 8), one);
  omp_set_num_threads(threads);
}

TEST(FeatureMemory, TheFirstFrameOfEveryThingIsNeverForgotten) {
  FeatureMemory memory;
  memory.add(frame(1, {7}), 3);
  for (uint64_t t = 2; t < 5; ++t) memory.add(frame(t, {7}), 3);
  memory.add(frame(5, {7, 9}), 3);
  for (uint64_t t = 6; t < 12; ++t) memory.add(frame(t, {7, 9}), 3);
  EXPECT_EQ(memory.frames(), 3u);
  const auto first = frame(1, {7}), entry = frame(5, {7, 9});
  std::vector<float> query, all(kChannels, 1e4f);  // so sharp that one pixel is read
  for (size_t c = 0; c < kChannels; ++c) query.push_back(first.key[c * kPixels + 4]);
  EXPECT_NEAR(memory.read(query, all, kChannels, {7}, 30)[0][0], first.value.at(7)[4], 1e-3);
  for (size_t c = 0; c < kChannels; ++c) query[c] = entry.key[c * kPixels + 4];
  EXPECT_NEAR(memory.read(query, all, kChannels, {9}, 30)[0][0], entry.value.at(9)[4], 1e-3);
}

// The flow of one motion, filmed at other rates and times.

#include "app/evaluate/flow_comparison.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <tuple>

#include "gaussians/base/random.h"

using nlohmann::json;

namespace pliant {
namespace {

/// A smooth texture that never repeats.
float wall(double x, double y) {
  double sum = 0;
  for (int k = 0; k < 6; ++k) {
    Random random(20, k);
    const double angle = 2 * M_PI * random.uniform(), length = 9 + 18 * random.uniform();
    sum += std::sin(2 * M_PI * (x * std::cos(angle) + y * std::sin(angle)) / length + k);
  }
  return static_cast<float>(0.5 + 0.08 * sum);
}

TEST(CompareFlow, FramesAtOtherTimesOfTheSameMotionHaveTheSameFlow) {
  // A wall that moves evenly: whole frames, and parts of them, are what lies between.
  const auto film = [](double fps, int frames, double start) {
    ReferenceVideo video;
    video.fps = fps;
    video.start = start;
    for (int f = 0; f < frames; ++f) {
      video.frames.emplace_back(64, 48, 3);
      for (int y = 0; y < 48; ++y)
        for (int x = 0; x < 64; ++x)
          for (int c = 0; c < 3; ++c) video.frames[f](x, y, c) = wall(x - 45 * (start + f / fps), y);
    }
    return video;
  };
  const ReferenceVideo truth = film(30, 7, 0);
  EXPECT_EQ(compare_flow(truth, truth)["flow_error_px"], 0);
  for (const auto& [fps, frames, start] : {std::tuple{60.0, 13, 0.0}, {24.0, 6, 0.0}, {30.0, 7, 0.5 / 30}}) {
    const json found = compare_flow(film(fps, frames, start), truth);
    EXPECT_NEAR(found["flow_in_truth_px"].get<double>(), 1.5, 0.1) << fps;
    EXPECT_LT(found["flow_error"].get<double>(), 0.08) << fps;
  }
}

}  // namespace
}  // namespace pliant

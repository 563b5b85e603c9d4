// Tracked pixels against textures whose motion is known.

#include "fitting/observe/track_pixels.h"

#include <gtest/gtest.h>

#include "gaussians/vision/optical_flow.h"
#include "tests/fitting/made_video.h"

namespace pliant {
namespace {

struct TrackError {
  double rms = 0, worst = 0, weight = 0, lost = 0;
};

/// Errors of the tracks that count (weight > 0.5) from frame `first` on, and their mean weight.
TrackError error_of(const MadeVideo& made, const PixelTracks& tracks, const std::vector<Eigen::Vector2d>& points) {
  TrackError e;
  double square = 0, sum = 0;
  size_t counted = 0, all = 0;
  for (size_t t = 0; t < tracks.pixel.size(); ++t)
    for (size_t i = 0; i < points.size(); ++i) {
      ++all;
      sum += tracks.weight[t][i];
      if (tracks.weight[t][i] <= 0.5) continue;
      const double d = (tracks.pixel[t][i] - made.moved(points[i], static_cast<int>(t))).norm();
      square += d * d;
      e.worst = std::max(e.worst, d);
      ++counted;
    }
  e.rms = std::sqrt(square / std::max<size_t>(1, counted));
  e.weight = sum / all;
  e.lost = 1 - static_cast<double>(counted) / all;
  testing::Test::RecordProperty("rms_millipixels", static_cast<int>(1e3 * e.rms));
  testing::Test::RecordProperty("lost_per_mille", static_cast<int>(1e3 * e.lost));
  return e;
}

TEST(TrackPixels, FollowsATurningTextureWithinAFewHundredthsOfAPixel) {
  MadeVideo made;
  made.frames = 20;
  const auto points = made.points();
  const PixelTracks tracks = track_pixels({}, made.video(), points, made.mask());
  const TrackError e = error_of(made, tracks, points);
  EXPECT_LT(e.rms, 0.03);
  EXPECT_LT(e.worst, 0.2);
  EXPECT_LT(e.lost, 0.02);
}

TEST(TrackPixels, NoiseCostsLittleAndIsForetold) {
  MadeVideo made;
  made.noise = 0.02;
  made.frames = 10;
  made.travel = 10;
  made.turn = 0.3;
  const auto points = made.points();
  const PixelTracks tracks = track_pixels({}, made.video(), points, made.mask());
  const TrackError e = error_of(made, tracks, points);
  EXPECT_LT(e.rms, 0.08);
  EXPECT_LT(e.lost, 0.05);
  // The expected error is that of one coordinate; the distance has two.
  double square = 0, n = 0;
  for (size_t t = 1; t < tracks.sigma.size(); ++t)
    for (size_t i = 0; i < points.size(); ++i)
      if (tracks.weight[t][i] > 0.5) {
        square += 2 * tracks.sigma[t][i] * tracks.sigma[t][i];
        ++n;
      }
  EXPECT_GT(std::sqrt(square / n), 0.4 * e.rms);
  EXPECT_LT(std::sqrt(square / n), 2.5 * e.rms);
}

TEST(TrackPixels, EdgesOfTheObjectAreFollowedBecauseTheWallDoesNotCount) {
  MadeVideo made;
  made.frames = 20;
  std::vector<Eigen::Vector2d> points;
  for (int k = 0; k < 16; ++k)
    points.push_back(made.rest() + 32 * Eigen::Vector2d(std::cos(k * M_PI / 8), std::sin(k * M_PI / 8)));
  const TrackError e = error_of(made, track_pixels({}, made.video(), points, made.mask()), points);
  EXPECT_LT(e.rms, 0.2);
  EXPECT_LT(e.lost, 0.2);
}

TEST(TrackPixels, HiddenPointsCountNothingAndAreFoundAgain) {
  MadeVideo made;
  made.travel = 6;
  made.turn = 0.15;
  made.frames = 14;
  ReferenceVideo video = made.video();
  // A bar of another texture stands before the left half during some frames.
  for (int t = 4; t < 9; ++t)
    for (int y = 0; y < made.height; ++y)
      for (int x = 0; x < 74; ++x)
        for (int c = 0; c < 3; ++c)
          video.frames[t](x, y, c) = static_cast<float>(MadeVideo::texture(1.3 * x, 0.9 * y, 2 - c, 3));
  const auto points = made.points();
  const PixelTracks tracks = track_pixels({}, video, points, made.mask());
  double hidden = 0, again = 0;
  int hidden_count = 0, again_count = 0;
  for (size_t i = 0; i < points.size(); ++i) {
    const auto place = [&](int t) { return made.moved(points[i], t); };
    bool covered = true;
    for (int t = 4; t < 9; ++t) covered = covered && place(t).x() < 68;
    if (!covered) continue;
    for (int t = 4; t < 9; ++t) {
      hidden += tracks.weight[t][i];
      ++hidden_count;
    }
    for (int t = 10; t < 14; ++t)
      if (tracks.weight[t][i] > 0.5) {
        again += 1;
        EXPECT_LT((tracks.pixel[t][i] - place(t)).norm(), 0.3) << i << ' ' << t;
      }
    again_count += 4;
  }
  ASSERT_GT(hidden_count, 20);
  EXPECT_LT(hidden / hidden_count, 0.05);
  EXPECT_GT(again / again_count, 0.8);
}

TEST(TrackPixels, APointWithoutTextureCountsNothing) {
  ReferenceVideo video;
  video.camera.width = 80;
  video.camera.height = 60;
  video.frames.assign(3, ImageF(80, 60, 3, 0.5f));
  const PixelTracks tracks = track_pixels({}, video, std::vector<Eigen::Vector2d>{{40, 30}, {-5, 10}});
  for (int t = 0; t < 3; ++t)
    for (int i = 0; i < 2; ++i) EXPECT_LT(tracks.weight[t][i], 1e-6);
}

}  // namespace
}  // namespace pliant

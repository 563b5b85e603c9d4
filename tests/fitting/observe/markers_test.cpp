#include "fitting/observe/markers.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "gaussians/base/error.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

class Markers : public ::testing::Test {
 protected:
  MarkerTracks read(const std::string& text) {
    std::ofstream(file()) << text;
    return read_markers(file());
  }
  /// "field: problem" of the error that reading `text` gives.
  std::string complaint(const std::string& text) {
    try {
      read(text);
    } catch (const Error& error) {
      EXPECT_EQ(error.failure, Failure::kInput);
      EXPECT_EQ(error.where, file());
      return error.field + ": " + error.problem;
    }
    return "";
  }
  std::string file() const { return folder_.path() / "markers.csv"; }

 private:
  TemporaryFolder folder_;
};

TEST_F(Markers, NamedColumnsComeInAnyOrderAndUnit) {
  const auto m =
      read("m1_x_m,time_ms,m0_z_mm,m0_x_mm,m1_z_m,m1_y_m,m0_y_mm\n1,500,30,10,3,2,20\n1.5,1500,30,11,3,2,20\n");
  EXPECT_EQ(m.name, (std::vector<std::string>{"m1", "m0"}));
  EXPECT_EQ(m.time, (std::vector<double>{0.5, 1.5}));
  EXPECT_EQ(m.position[0][0], Vec3d(1, 2, 3));
  EXPECT_LT((m.position[0][1] - Vec3d(0.01, 0.02, 0.03)).norm(), 1e-15);
  EXPECT_EQ(m.position[1][0], Vec3d(1.5, 2, 3));
}

TEST_F(Markers, AGivenUnitIsThatOfColumnsWhoseNamesStateNone) {
  const auto m = read("time,a_x_mm,a_y_m,a_z\n0,10,2,3\n1,11,2,3\n"), in_halves = read_markers(file(), 0.5);
  EXPECT_EQ(m.position[0][0], Vec3d(0.01, 2, 3));
  EXPECT_EQ(in_halves.position[0][0], Vec3d(0.01, 2, 1.5));
  EXPECT_EQ(in_halves.time, m.time);
}

TEST_F(Markers, SemicolonsNamelessColumnsCommentsAndWindowsLinesAreRead) {
  const auto m = read(
      "\xef\xbb\xbf# camera 3\r\ntime; x; y; z; x; y; z\r\n0; 1; 2; 3; -4; +5; 6e-1\r\n\r\n1; 1; 2; 3; 4; 5; 6\r\n");
  EXPECT_EQ(m.markers(), 2u);
  EXPECT_EQ(m.samples(), 2u);
  EXPECT_EQ(m.position[0][1], Vec3d(-4, 5, 0.6));
}

TEST_F(Markers, GapsHaveNoWeight) {
  const auto m = read("time,a_x,a_y,a_z,b_x,b_y,b_z\n0,1,,3,1,2,3\n1,1,2,3,NaN,nan,NA\n");
  EXPECT_EQ(m.weight[0], (std::vector<double>{0, 1}));
  EXPECT_EQ(m.weight[1], (std::vector<double>{1, 0}));
  EXPECT_EQ(m.position[0][0], Vec3d::Zero());
}

TEST_F(Markers, ComplaintsNameLineAndColumn) {
  const std::string head = "time,a_x,a_y,a_z\n";
  EXPECT_EQ(complaint(head + "0,1,2,3\n1,1,two,3\n"), "line 3, column 3 (a_y): 'two' is not a number");
  EXPECT_EQ(complaint(head + "0,1,2,3\n1,1,2,3e\n"), "line 3, column 4 (a_z): '3e' is not a number");
  EXPECT_EQ(complaint(head + "0,1,2,3\n1,1,2\n"), "line 3: 3 columns where the first line has 4");
  EXPECT_EQ(complaint(head + "0,1,2,3\n0,1,2,3\n"), "line 3, column 1: time 0 does not come after the line before");
  EXPECT_EQ(complaint(head + "0,1,2,3\n,1,2,3\n"), "line 3, column 1: no time");
  EXPECT_EQ(complaint("time,a_x,a_y\n0,1,2\n1,1,2\n"), "line 1: marker 'a' has no z column");
  EXPECT_EQ(complaint("time,a_x,a_y,a_z,a_x\n"), "line 1, column 5: a second column 'a_x'");
  EXPECT_EQ(complaint("time,a_x,a_y,a_z,speed\n"), "line 1, column 5: 'speed' is neither a time nor a coordinate");
  EXPECT_EQ(complaint("# none\na_x,a_y,a_z\n"), "line 2, column 1: no column of times");
  EXPECT_EQ(complaint(head + "0,1,2,3\n"), ": fewer than two lines of measurements");
  EXPECT_EQ(complaint(""), ": fewer than two lines of measurements");
  EXPECT_THROW(read_markers("/nowhere.csv"), Error);
}

TEST_F(Markers, ResamplingIsLinearAndDoesNotBridgeGaps) {
  const auto m = read("t,a_x,a_y,a_z,b_x,b_y,b_z\n0,0,0,0,1,1,1\n1,2,4,6,,,\n2,4,8,12,3,3,3\n");
  const auto r = resampled(m, std::vector<double>{-0.1, 0, 0.25, 1, 1.5, 2, 2.1});
  EXPECT_EQ(r.position[2][0], Vec3d(0.5, 1, 1.5));
  EXPECT_EQ(r.position[4][0], Vec3d(3, 6, 9));
  const double seen[7][2] = {{0, 0}, {1, 1}, {1, 0}, {1, 0}, {1, 0}, {1, 1}, {0, 0}};
  for (int t = 0; t < 7; ++t)
    for (int k = 0; k < 2; ++k) EXPECT_EQ(r.weight[t][k], seen[t][k]) << t << " " << k;
}

TEST_F(Markers, RestIsAMeanAndTheOnsetIsTheLastStillInstant) {
  const auto m =
      read("t,a_x,a_y,a_z,b_x,b_y,b_z\n0,1,0,0,,,\n1,3,0,0,,,\n2,2,0,0.1,,,\n3,2,0,5,,,\n4,2,0,10,,,\n5,2,0,10,,,\n");
  const auto rest = mean_position(m, 0, 2);
  EXPECT_LT((rest[0] - Vec3d(2, 0, 0.1 / 3)).norm(), 1e-15);
  EXPECT_TRUE(std::isnan(rest[1].x()));
  EXPECT_EQ(onset_of_motion(m, std::vector<Vec3d>{{2, 0, 0}, rest[1]}, 0.11), 2);
}

/// One marker at 1 Hz, away from its place at rest by these distances.
MarkerTracks moved_by(const std::vector<double>& distances) {
  MarkerTracks tracks;
  tracks.name = {"a"};
  for (const double d : distances) {
    tracks.time.push_back(static_cast<double>(tracks.time.size()));
    tracks.position.push_back({Vec3d(1, 2 + d, 3)});
    tracks.weight.push_back({1});
  }
  return tracks;
}

TEST_F(Markers, ASpikeIsNoOnsetAndHidesNone) {
  const std::vector<Vec3d> rest = {{1, 2, 3}};
  EXPECT_EQ(onset_of_motion(moved_by({0, 0, 0, 0, 0, 0, 1, 3, 6, 8, 9, 9}), rest), 5);
  EXPECT_EQ(onset_of_motion(moved_by({0, 0, 7, 0, 0, 0, 1, 3, 6, 8, 9, 9}), rest), 5) << "at rest";
  EXPECT_EQ(onset_of_motion(moved_by({0, 0, 0, 0, 0, 0, 1, 3, 6, 900, 9, 9}), rest), 5) << "in motion";
  EXPECT_EQ(onset_of_motion(moved_by({0, 0, 0, 0, 0, 0, 1, 3, 6, 8, 9, 900}), rest), 5) << "at the end";
}

TEST_F(Markers, SamplesThatJumpAwayAndBackHaveNoWeightAndMotionKeepsIts) {
  const auto left_out = [](const MarkerTracks& tracks, double begin = -INFINITY) {
    std::vector<size_t> out;
    const MarkerTracks kept = without_spikes(tracks, begin);
    for (size_t t = 0; t < kept.samples(); ++t)
      if (kept.weight[t][0] == 0) out.push_back(t);
    return out;
  };
  using Samples = std::vector<size_t>;
  const MarkerTracks spikes = moved_by({0, 0, 1.5, 0, 0, 0, 1, 3, 6, 8, 9, 9, 40, 8, 7, 6});
  EXPECT_EQ(left_out(spikes), (Samples{2, 12}));
  EXPECT_EQ(left_out(spikes, 3), Samples{12}) << "what came before does not count";
  MarkerTracks gap = spikes;
  gap.weight[13][0] = 0;
  EXPECT_EQ(left_out(gap), (Samples{2, 12, 13})) << "beside a gap";
  // Few samples in a period, about the place of rest and to one side of it; a kick; nothing.
  EXPECT_EQ(left_out(moved_by({0, 0, 0, 5, 0, -4, 0, 3, 0, -2, 0, 1.5, 0, -1})), Samples{});
  EXPECT_EQ(left_out(moved_by({0, 0, 0, 5, 9, 4.5, 0.5, 4, 8, 4.2, 1, 4})), Samples{});
  EXPECT_EQ(left_out(moved_by({0, 0, 0, 0, 6, 12, 11, 9, 8, 6})), Samples{});
  EXPECT_EQ(left_out(moved_by({0, 0, 0, 0, 0})), Samples{});
}

}  // namespace
}  // namespace pliant

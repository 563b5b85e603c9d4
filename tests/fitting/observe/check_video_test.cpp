// What is wrong with a reference video is found and said with its value; a good one passes.

#include "fitting/observe/check_video.h"

#include <functional>

#include "tests/fitting/made_video.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

struct CheckVideo : testing::Test {
  MadeVideo made;
  CheckVideo() {
    made.travel = 8;
    made.turn = 0.15;
    made.radius = 26;
    made.noise = 0.01;
    made.frames = 12;
  }
  VideoChecks check(const ReferenceVideo& video, const std::vector<ImageU8>& compared = {}) const {
    MadeVideo clean = made;
    clean.noise = 0;
    return check_video({}, video, clean.frame(0), made.mask(), compared);
  }
};

/// The finding, which must be there, refuse or not, and say its value.
void expect_finding(const VideoChecks& checks, VideoProblem problem, bool refuse, const std::string& words) {
  const VideoFinding* finding = checks.find(problem);
  ASSERT_NE(finding, nullptr);
  EXPECT_EQ(finding->refuse, refuse) << finding->sentence;
  EXPECT_EQ(checks.usable(), !refuse);
  EXPECT_NE(finding->sentence.find(words), std::string::npos) << finding->sentence;
}

/// Someone walks from the left before it all, `width` px wide; returns where that is not.
std::vector<ImageU8> walk_before(ReferenceVideo& video, int width, int step) {
  std::vector<ImageU8> seen;
  for (size_t t = 0; t < video.frames.size(); ++t) {
    ImageF& frame = video.frames[t];
    ImageU8& compared = seen.emplace_back(frame.width, frame.height, 1);
    compared.data.assign(compared.data.size(), 255);
    const int left = step * static_cast<int>(t);
    for (int y = 0; y < frame.height; ++y)
      for (int x = left; x < std::min(frame.width, left + width); ++x) {
        compared(x, y) = 0;
        for (int c = 0; c < 3; ++c) frame(x, y, c) = static_cast<float>(MadeVideo::texture(x - left, y, c, 3));
      }
  }
  return seen;
}

TEST_F(CheckVideo, WhatMasksHideDoesNotCount) {
  const VideoChecks clean = check(made.video());
  ReferenceVideo video = made.video();
  const std::vector<ImageU8> seen = walk_before(video, 70, 8);
  EXPECT_FALSE(check(video).usable());
  const VideoChecks checks = check(video, seen);
  for (const VideoFinding& finding : checks.findings) EXPECT_FALSE(finding.refuse) << finding.sentence;
  EXPECT_NEAR(checks.motion, clean.motion, 2);
  EXPECT_LT(checks.displaced, 0.5);
  EXPECT_GT(checks.match.score, 0.9);
  EXPECT_LT(checks.drift, 0.15);
}

TEST_F(CheckVideo, MasksThatCutTheObjectOutHideNothing) {
  made.wall_shift = 0.25;
  const ReferenceVideo video = made.video();
  const VideoChecks cut_out = check(video, std::vector<ImageU8>{made.mask()}), without = check(video);
  EXPECT_EQ(cut_out.drift, without.drift);
  expect_finding(cut_out, VideoProblem::kCameraMoves, true, "frame 11");
}

TEST_F(CheckVideo, AGoodVideoPassesAndItsMotionIsMeasured) {
  const VideoChecks checks = check(made.video());
  for (const VideoFinding& finding : checks.findings) ADD_FAILURE() << finding.sentence;
  EXPECT_TRUE(checks.usable());
  EXPECT_GT(checks.match.score, 0.9);
  EXPECT_NEAR(checks.motion, 8.2 + 0.15 * 26, 3);
  EXPECT_LT(checks.drift, 0.15);
}

TEST_F(CheckVideo, AnotherViewAndAnotherSceneAreRefused) {
  ReferenceVideo shifted = made.video();
  for (int t = 0; t < made.frames; ++t)
    for (int y = 0; y < made.height; ++y)
      for (int x = 0; x + 6 < made.width; ++x)
        for (int c = 0; c < 3; ++c) shifted.frames[t](x, y, c) = shifted.frames[t](x + 6, y, c);
  expect_finding(check(shifted), VideoProblem::kOtherView, true, "made");
  ReferenceVideo other = made.video();
  for (ImageF& frame : other.frames) std::reverse(frame.data.begin(), frame.data.end());
  expect_finding(check(other), VideoProblem::kOtherView, true, "Give the camera");
  // A pixel beside it is within what refinement mends.
  ReferenceVideo near = made.video();
  for (ImageF& frame : near.frames)
    for (int y = 0; y < made.height; ++y)
      for (int x = 0; x + 1 < made.width; ++x)
        for (int c = 0; c < 3; ++c) frame(x, y, c) = frame(x + 1, y, c);
  expect_finding(check(near), VideoProblem::kViewOff, false, "1.0 px");
}

TEST_F(CheckVideo, ACutIsFoundAtItsFrame) {
  ReferenceVideo video = made.video();
  for (int t = 7; t < made.frames; ++t) std::reverse(video.frames[t].data.begin(), video.frames[t].data.end());
  const VideoChecks checks = check(video);
  expect_finding(checks, VideoProblem::kCut, true, "frame 7");
  EXPECT_EQ(checks.find(VideoProblem::kCut)->frame, 7);
  EXPECT_EQ(checks.find(VideoProblem::kCameraMoves), nullptr);
}

TEST_F(CheckVideo, FramesMissingBeforeAStillBackgroundAreSaid) {
  made.frames = 20;
  ReferenceVideo video = made.video();
  video.frames.erase(video.frames.begin() + 7, video.frames.begin() + 14);
  const VideoChecks checks = check(video);
  expect_finding(checks, VideoProblem::kLeap, false, "frame 7");
}

TEST_F(CheckVideo, AStillObjectIsRefusedAlsoUnderNoise) {
  made.travel = 0.1;
  made.turn = 0;
  for (const double noise : {0.0, 0.02}) {
    made.noise = noise;
    expect_finding(check(made.video()), VideoProblem::kStatic, true, "does not move");
  }
}

TEST_F(CheckVideo, AFirstFrameThatDoesNotShowTheObjectAtRestIsSaidWhateverItsLight) {
  made.frames = 20;
  const ReferenceVideo whole = made.video();
  for (const float gain : {1.0f, 0.7f}) {
    ReferenceVideo video = whole;
    for (ImageF& frame : video.frames)
      for (float& value : frame.data) value *= gain;
    const VideoChecks from_rest = check(video);
    EXPECT_EQ(from_rest.find(VideoProblem::kNotAtRest), nullptr);
    EXPECT_LT(from_rest.displaced, 0.5);
    video.frames.erase(video.frames.begin(), video.frames.begin() + 5);  // begins where it turns back
    const VideoChecks later = check(video);
    expect_finding(later, VideoProblem::kNotAtRest, false, "not at rest in the first frame");
    EXPECT_NEAR(later.displaced, 8.2 + 0.15 * 26, 3);
  }
}

TEST_F(CheckVideo, AMovingCameraIsRefusedSlowOrFast) {
  made.wall_shift = 0.25;
  const VideoChecks slow = check(made.video());
  expect_finding(slow, VideoProblem::kCameraMoves, true, "frame 11");
  EXPECT_NEAR(slow.drift, 0.25 * 11, 0.4);
  made.wall_shift = 9;
  const VideoChecks fast = check(made.video());
  expect_finding(fast, VideoProblem::kCameraMoves, true, "tripod");
  EXPECT_EQ(fast.find(VideoProblem::kCut), nullptr);
}

TEST_F(CheckVideo, ARateThatTheFileContradictsIsRefusedUnlessItIsMeant) {
  ReferenceVideo video = made.video();
  video.file_fps = 30;
  video.declared_fps = 24;
  expect_finding(check(video), VideoProblem::kRate, true, "30");
  video.declared_rate_holds = true;
  EXPECT_EQ(check(video).find(VideoProblem::kRate), nullptr);
}

TEST_F(CheckVideo, ChangesOfLightAreSaidAndAHiddenObjectIsRefused) {
  ReferenceVideo video = made.video();
  for (float& value : video.frames[5].data) value *= 0.8f;
  expect_finding(check(video), VideoProblem::kLight, false, "20 %");
  const VideoChecks hidden = check_video({}, video, made.frame(0), ImageU8(made.width, made.height, 1));
  EXPECT_NE(hidden.find(VideoProblem::kHidden), nullptr);
  expect_error(Failure::kInput, {"clip.mp4", "0 pixels"}, [&] { require_usable(hidden, "clip.mp4"); });
}

TEST_F(CheckVideo, RepeatedFramesAreSaid) {
  made.noise = 0;
  made.frames = 20;
  ReferenceVideo doubled = made.video();
  for (int t = 1; t < made.frames; t += 2) doubled.frames[t] = doubled.frames[t - 1];
  expect_finding(check(doubled), VideoProblem::kRepeated, false, "lower rate");
}

TEST_F(CheckVideo, FramesRepeatedOrDroppedAtEvenDistancesTellTheTrueRate) {
  made.frames = 26;  // of a swing
  const ReferenceVideo film = made.video();
  const auto shown = [&](int frames, const std::function<int(int)>& filmed) {
    ReferenceVideo video = film;
    video.frames.clear();
    for (int t = 0; t < frames; ++t) video.frames.push_back(film.frames[filmed(t) % made.frames]);
    return check(video);
  };
  EXPECT_EQ(shown(32, [](int t) { return t; }).rhythm.period, 0);
  const VideoChecks doubled = shown(32, [](int t) { return t / 2; });
  expect_finding(doubled, VideoProblem::kRepeated, false, "true rate is probably 12 frames");
  EXPECT_NE(doubled.find(VideoProblem::kRepeated)->sentence.find("underestimated by a factor of 4: set the rate to 48"),
            std::string::npos);
  expect_finding(shown(38, [](int t) { return t / 3; }), VideoProblem::kRepeated, false,
                 "true rate is probably 8 frames");
  expect_finding(shown(40, [](int t) { return t * 5 / 6; }), VideoProblem::kRepeated, false,
                 "true rate is probably 20 frames");
  const VideoChecks dropped = shown(32, [](int t) { return t * 3 / 2; });
  expect_finding(dropped, VideoProblem::kDropped, false, "true rate is 36 frames");
  EXPECT_NE(dropped.find(VideoProblem::kDropped)->sentence.find("overestimated by a factor of 2.25"),
            std::string::npos);
}

}  // namespace
}  // namespace pliant

#include "fitting/fit/fit_markers.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "gaussians/base/error.h"
#include "tests/physics/shapes.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

constexpr double kYoung = 2e5, kDamping = 0.2, kRelease = 0.1234, kDx = 0.015;

/// A bar 30 x 30 x 100 mm along x, held over its first three cells, under gravity along -z.
Particles bar(double young) { return fixture::block<float>({0.1 + 3 * kDx, 0.03, 0.03}, kDx, 0.0, young, 0.4, 1070); }

std::vector<Interaction> let_go() {
  Interaction pin, load;
  pin.type = InteractionType::kPin;
  pin.region = Region::half_space(Vec3d(3 * kDx, 0, 0), Vec3d(1, 0, 0));
  load.type = InteractionType::kGust;
  load.vector = Vec3d(0, 0, -9.81);
  return {pin, load};
}

MarkerFitOptions options() {
  MarkerFitOptions o;
  o.model.simulate.gravity.setZero();
  o.model.simulate.fps = 200;
  o.window = 0.2;
  o.damping_time = 0.5;
  return o;
}

/// Two markers near the tip, one half way, one far from the bar; 100 Hz; at rest until kRelease.
MarkerTracks recording(double noise) {
  const std::vector<Vec3d> rest = {{0.14, 0.015, 0.03}, {0.145, 0.0, 0.015}, {0.09, 0.03, 0.01}, {0.14, 0.1, 0.03}};
  const MarkerModel model(options().model, bar(kYoung), let_go(), rest);
  const MarkerMotion motion = model.run({1, kDamping, 0}, 0.35);
  MarkerTracks tracks;
  tracks.name = {"a", "b", "c", "d"};
  for (int t = 0; t < 36; ++t) {
    tracks.time.push_back(0.01 * t);
    tracks.position.push_back(rest);
    tracks.weight.emplace_back(4, 1.0);
    for (int k = 0; k < 3; ++k) {
      tracks.position[t][k] += motion.at(0.01 * t - kRelease, k);
      for (int a = 0; a < 3; ++a) tracks.position[t][k][a] += noise * Random(1, t, 3 * k + a).normal();
    }
  }
  tracks.weight[20][1] = 0;
  tracks.position[20][1] = {9, 9, 9};  // a gap
  return tracks;
}

TEST(MarkerMotion, InterpolationFollowsCubicsAndRestsBeforeTheRelease) {
  MarkerMotion motion;
  motion.fps = 10;
  for (int k = 0; k < 20; ++k) motion.displacement.push_back({Vec3d(std::pow(0.1 * k, 2), 0.1 * k, 0)});
  EXPECT_NEAR(motion.at(0.55, 0).x(), 0.3025, 1e-12);
  EXPECT_NEAR(motion.at(0.55, 0).y(), 0.55, 1e-12);
  EXPECT_EQ(motion.at(-0.2, 0), Vec3d::Zero());
  EXPECT_EQ(motion.at(99, 0), motion.displacement.back()[0]);
}

TEST(FitMarkers, FindsStiffnessDampingAndReleaseFromTenTimesWrongEitherWay) {
  const MarkerTracks tracks = recording(1e-5);
  for (const double wrong : {0.1, 10.0}) {
    const auto fit = fit_markers(options(), bar(wrong * kYoung), let_go(), tracks);
    EXPECT_NEAR(std::log10(fit.young / kYoung), 0, 0.005) << wrong;
    EXPECT_NEAR(fit.parameters.damping_time, kDamping, 0.02);
    EXPECT_NEAR(fit.parameters.release, kRelease, 5e-4);
    EXPECT_LT(fit.rms, 5e-5);
    EXPECT_EQ(fit.markers, (std::vector<int>{0, 1, 2}));
    ASSERT_EQ(fit.warnings.size(), 1u);
    EXPECT_NE(fit.warnings[0].find("'d'"), std::string::npos);
    EXPECT_GT(fit.sigma_log10_young, 0);
    EXPECT_LT(fit.sigma_log10_young, 0.005);
  }
}

TEST(FitMarkers, ASpikeAtRestOrInMotionIsIgnoredWithAWarning) {
  MarkerTracks tracks = recording(1e-5);
  tracks.position[5][0] += Vec3d(0, 0.2, 0.3);
  tracks.position[25][1] += Vec3d(0.3, 0, 0);
  const MarkerFitResult fit = fit_markers(options(), bar(2 * kYoung), let_go(), tracks);
  EXPECT_NEAR(std::log10(fit.young / kYoung), 0, 0.005);
  EXPECT_NEAR(fit.parameters.damping_time, kDamping, 0.02);
  EXPECT_NEAR(fit.parameters.release, kRelease, 5e-4);
  EXPECT_LT(fit.rms, 5e-5);
  ASSERT_EQ(fit.warnings.size(), 3u);  // the marker that is not on the bar
  EXPECT_NE(fit.warnings[1].find("'a' jumps away and back at 0.05 s"), std::string::npos) << fit.warnings[1];
  EXPECT_NE(fit.warnings[2].find("'b' jumps away and back at 0.25 s"), std::string::npos) << fit.warnings[2];
}

// A stiffer body, which moves less, is then always a little better.
TEST(FitMarkers, ALoadThatCannotExplainTheMotionEndsAtTheStiffEndOfTheSearch) {
  std::vector<Interaction> upwards = let_go();
  upwards[1].vector = -upwards[1].vector;
  MarkerFitOptions o = options();
  o.search_decades = 0.5;
  o.search_farthest = 1;
  o.max_iterations = 2;
  const MarkerFitResult fit = fit_markers(o, bar(kYoung), upwards, recording(1e-5));
  EXPECT_EQ(fit.search_end, 1);
  EXPECT_NEAR(fit.young / kYoung, 10, 1e-3);
  EXPECT_GE(fit.sigma_log10_young, 1);
  EXPECT_TRUE(std::isfinite(fit.sigma_log10_young));
  EXPECT_GT(fit.rms, fit.rms_still);
  // One that can has an end within the search, and explains the motion.
  o.max_iterations = 8;
  const MarkerFitResult good = fit_markers(o, bar(2 * kYoung), let_go(), recording(1e-5));
  EXPECT_EQ(good.search_end, 0);
  EXPECT_LT(good.sigma_log10_young, 0.1);
  EXPECT_LT(good.rms, 0.1 * good.rms_still);
}

TEST(FitMarkers, TheReleaseIsNotBeforeTheFirstRowHoweverEarlyTheMotionWantsIt) {
  MarkerTracks tracks = recording(0);
  // The first row is of a body at rest, soon after the release of the others.
  const std::vector<Vec3d> rest = tracks.position[0];
  const auto cut = [](auto& rows) { rows.erase(rows.begin(), rows.begin() + 13); };
  cut(tracks.time);
  cut(tracks.position);
  cut(tracks.weight);
  tracks.position[0] = rest;
  MarkerFitOptions o = options();
  o.release = tracks.time[0] + 0.005;
  const MarkerFitResult fit = fit_markers(o, bar(kYoung), let_go(), tracks);
  EXPECT_GE(fit.parameters.release, tracks.time[0]);
  EXPECT_LT(fit.parameters.release, o.release);
  // From there the rest can be predicted.
  o.fit_young = o.fit_damping = o.fit_release = o.search = false;
  o.release = tracks.time[0];
  EXPECT_EQ(fit_markers(o, bar(kYoung), let_go(), tracks).markers, fit.markers);
}

// Of both as a distance for each place that was measured, gaps left out.
TEST(FitMarkers, ACandidateOfTheSearchAndTheFitHaveErrorsOfOneKind) {
  MarkerFitOptions o = options();
  o.fit_damping = o.fit_release = false;
  o.release = kRelease;
  o.release_range = 0;
  o.damping_time = kDamping;
  o.max_iterations = 0;
  MarkerTracks tracks = recording(2e-4);
  for (size_t t = 22; t < 30; ++t) tracks.weight[t][0] = 0;
  const MarkerFitResult fit = fit_markers(o, bar(kYoung), let_go(), tracks);
  const auto last = std::ranges::min_element(
      fit.search, {}, [&](const MarkerFitResult::Candidate& c) { return std::abs(std::log(c.young / fit.young)); });
  ASSERT_NE(last, fit.search.end());
  EXPECT_NEAR(last->young / fit.young, 1, 1e-9);
  EXPECT_NEAR(last->rms / fit.rms, 1, 0.02);
}

TEST(FitMarkers, GoesOnFromWhereverItWasInterruptedAndEndsTheSame) {
  const MarkerTracks tracks = recording(1e-5);
  std::vector<MarkerFitState> kept;
  const MarkerFitResult whole = fit_markers(options(), bar(3 * kYoung), let_go(), tracks, {}, {},
                                            [&](const MarkerFitState& s) { kept.push_back(s); });
  ASSERT_GT(kept.size(), 6u);
  EXPECT_TRUE(kept.back().searched);
  for (size_t k = 0; k < kept.size(); k += 3) {
    const MarkerFitResult rest = fit_markers(options(), bar(3 * kYoung), let_go(), tracks, {}, kept[k]);
    EXPECT_EQ(rest.young, whole.young) << k;
    EXPECT_EQ(rest.parameters.damping_time, whole.parameters.damping_time) << k;
    EXPECT_EQ(rest.parameters.release, whole.parameters.release) << k;
    EXPECT_EQ(rest.sigma_log10_young, whole.sigma_log10_young) << k;
    EXPECT_EQ(rest.search.size(), whole.search.size()) << k;
    EXPECT_EQ(rest.loss, whole.loss) << k;
  }
  EXPECT_LT(fit_markers(options(), bar(3 * kYoung), let_go(), tracks, {}, kept.back()).rollouts, 2);
}

TEST(FitMarkers, WithNothingToFitItIsAPrediction) {
  MarkerFitOptions o = options();
  o.fit_young = o.fit_damping = o.fit_release = o.search = false;
  o.release = kRelease;
  o.damping_time = kDamping;
  const auto prediction = fit_markers(o, bar(kYoung), let_go(), recording(0));
  EXPECT_LT(prediction.rms, 1e-5);
  EXPECT_EQ(prediction.rollouts, 1);
  EXPECT_GT(fit_markers(o, bar(2 * kYoung), let_go(), recording(0)).rms, 1e-3);
}

TEST(FitMarkers, MarkersThatAreNotOnTheBodyOrDoNotMoveAreRefused) {
  MarkerTracks tracks = recording(0);
  for (auto& frame : tracks.position)
    for (Vec3d& x : frame) x *= 1000;  // millimetres
  EXPECT_THROW(fit_markers(options(), bar(kYoung), let_go(), tracks), Error);
  tracks = recording(0);
  for (auto& frame : tracks.position) frame = tracks.position[0];
  EXPECT_THROW(fit_markers(options(), bar(kYoung), let_go(), tracks), Error);
}

TEST(FitMarkers, AMarkerThatIsHiddenUntilTheReleaseIsSaidToBeAndIgnored) {
  MarkerFitOptions o = options();
  o.fit_young = o.fit_damping = o.fit_release = o.search = false;
  o.release = kRelease;
  o.damping_time = kDamping;
  MarkerTracks tracks = recording(0);
  const auto hide = [&](int marker) {
    for (size_t t = 0; tracks.time[t] <= kRelease; ++t) tracks.weight[t][marker] = 0;
  };
  hide(0);
  const MarkerFitResult fit = fit_markers(o, bar(kYoung), let_go(), tracks);
  EXPECT_EQ(fit.markers, (std::vector<int>{1, 2}));
  ASSERT_EQ(fit.warnings.size(), 2u);
  EXPECT_NE(fit.warnings[0].find("'a' was not measured at rest"), std::string::npos) << fit.warnings[0];
  EXPECT_NE(fit.warnings[1].find("'d' is "), std::string::npos) << fit.warnings[1];
  EXPECT_NE(fit.warnings[1].find(" mm from the body"), std::string::npos) << fit.warnings[1];
  for (const int marker : {1, 2, 3}) hide(marker);
  expect_error(Failure::kInput, {"none was measured at rest", "--marker-rest", "--marker-release"},
               [&] { fit_markers(o, bar(kYoung), let_go(), tracks); });
}

TEST(FitMarkers, AReleaseOutsideTheRecordingAndAWindowWithoutSamplesAreRefused) {
  const MarkerTracks tracks = recording(0);  // from 0 to 0.35 s
  const auto refused = [&](Failure failure, double rest, double release, double window,
                           const std::vector<std::string>& words) {
    MarkerFitOptions o = options();
    o.rest_begin = rest;
    o.release = release;
    o.window = window;
    expect_error(failure, words, [&] { fit_markers(o, bar(kYoung), let_go(), tracks); });
  };
  refused(Failure::kUsage, -INFINITY, 100, 1, {"--marker-release", "100 s", "0.35 s"});
  refused(Failure::kUsage, -INFINITY, -1, 1, {"--marker-release", "-1 s", "0 s"});
  refused(Failure::kUsage, 0.2, 0.1, 1, {"--marker-release", "0.1 s", "0.2 s", "--marker-rest"});
  refused(Failure::kInput, -INFINITY, 0.095, 0.01, {"markers", "1 sample from 0.095 s to 0.105 s", "--marker-window"});
  refused(Failure::kInput, -INFINITY, 0.335, 1, {"markers", "2 samples", "--marker-window", "--marker-release"});
}

}  // namespace
}  // namespace pliant

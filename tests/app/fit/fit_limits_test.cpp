// The sentences about what a video does not determine.

#include <gtest/gtest.h>

#include <functional>

#include "app/fit/fit_outcome.h"

namespace pliant {
namespace {

bool says(const FitEvidence& evidence, const std::string& words, double fps = 24) {
  for (const std::string& sentence : undetermined_by_video(evidence, FitBlindness(), fps))
    if (sentence.find(words) != std::string::npos) return true;
  return false;
}

MotionScores scores(double rest, double fitted, double still) {
  MotionScores out;
  out.rest = rest;
  out.fitted = {1, 9, fitted, still, 9};
  return out;
}

TEST(FitLimits, EachWeakPointIsSaidAndOnlyThen) {
  FitEvidence sure;
  sure.young = 1e5;
  sure.rms = 0.5;
  sure.rms_still = 2;
  sure.damping_low = 1;
  sure.damping_time = 1.1;
  sure.damping_high = 1.2;
  sure.periods = 3;
  sure.strongest_hz = 2;
  sure.one_stiffness = false;
  sure.losses = {1, 0.05};
  struct Weak {
    std::string words;
    std::function<void(FitEvidence&)> make;
  };
  const std::vector<Weak> all = {
      {"no better than one for the whole object", [](FitEvidence& e) { e.field_left = true; }},
      {"differences between its parts were not considered", [](FitEvidence& e) { e.one_stiffness = true; }},
      {"in 40 % of the object", [](FitEvidence& e) { e.undecided_volume = 0.4; }},
      {"was not computed", [](FitEvidence& e) { e.errors_known = false; }},
      {"refined from the given value by gradient descent", [](FitEvidence& e) { e.searched = false; }},
      {"images and optical flow were not considered", [](FitEvidence& e) { e.by_gradients = true; }},
      {"E = 4e+05 Pa explains the video almost as well",
       [](FitEvidence& e) {
         e.rival_factor = {4};
         e.rival_rms = {0.55};
       }},
      {"Film at a higher frame rate", [](FitEvidence& e) { e.strongest_hz = 7; }},
      {"Only 0.5 of a period", [](FitEvidence& e) { e.periods = 0.5; }},
      {"object's own damping time is 1 s",
       [](FitEvidence& e) {
         e.losses = {1, 0.2};
       }},
      {"Damping is barely determined", [](FitEvidence& e) { e.damping_high = 9; }},
      {"explains little of the video", [](FitEvidence& e) { e.rms_still = 0.6; }},
      {"explains nothing of the video", [](FitEvidence& e) { e.rms_still = 0.5; }},
      {"30 frames per second", [](FitEvidence& e) { e.stated_fps = 30; }},
      {"E = 4e+05 Pa explains the video better (RMSE 0.40 px against 0.50 px)",
       [](FitEvidence& e) {
         e.rival_factor = {4};
         e.rival_rms = {0.4};
       }},
      {"ended with a larger track RMSE than it began with: 0.50 px, against 0.40 px at E = 4e+05 Pa",
       [](FitEvidence& e) {
         e.rival_factor = {4};
         e.rival_rms = {0.4};
         e.refined = 0;
       }},
      {"up to 22.0 px away from rest", [](FitEvidence& e) { e.displaced = 22; }},
      {"taken to begin at 0.25 s",
       [](FitEvidence& e) {
         e.start = 0.25;
         e.start_late = true;
       }},
      {"nothing swings freely", [](FitEvidence& e) { e.start_late = e.pushed_away = true; }},
      {"from the low end of the search, where smaller values", [](FitEvidence& e) { e.search_end = -1; }},
      {"from the high end of the search, where larger values", [](FitEvidence& e) { e.search_end = 1; }},
      {"draws the fitted frames worse than the first frame held still: PSNR 19.0 dB against 22.0 dB. Do not rely",
       [](FitEvidence& e) { e.scores = scores(35, 19, 22); }},
      {"about as much (21.2 dB), so pictures do not tell",  // a grey video of a scene in colors
       [](FitEvidence& e) { e.scores = scores(21.2, 20.4, 21.7); }},
      {"draws the held-out frames worse",
       [](FitEvidence& e) {
         e.scores = scores(35, 25, 20);
         e.scores.later = {10, 19, 19.6, 23.4, 10};
       }},
  };
  for (const Weak& weak : all) {
    FitEvidence evidence = sure;
    EXPECT_FALSE(says(evidence, weak.words)) << weak.words;
    weak.make(evidence);
    EXPECT_TRUE(says(evidence, weak.words)) << weak.words;
  }
  // A rival that explains much less is none.
  FitEvidence rival = sure;
  rival.rival_factor = {4};
  rival.rival_rms = {0.9};
  EXPECT_FALSE(says(rival, "almost as well"));
}

TEST(FitLimits, PicturesThatOnlyDifferAsTheSceneAtRestDoesRaiseNoDoubt) {
  FitEvidence evidence;
  evidence.scores = scores(38.7, 26.6, 20);
  evidence.scores.later = {10, 19, 38, 45, 10};  // it has come to rest
  EXPECT_TRUE(doubts_of(evidence).empty());
}

TEST(FitLimits, WhereARefinementBeganIsNoRivalOfIt) {
  FitEvidence evidence;
  evidence.young = 1e5;
  evidence.rms = 0.5;
  evidence.rival_factor = {1.5, 4};
  evidence.rival_rms = {0.49, 0.55};
  evidence.refined = 0;
  EXPECT_FALSE(says(evidence, "E = 1.5e+05 Pa"));
  EXPECT_FALSE(says(evidence, "ended with a larger"));
  EXPECT_TRUE(says(evidence, "E = 4e+05 Pa explains the video almost as well"));
}

TEST(FitOutcome, AFieldThatWasLeftIsWrittenAsTheConstantItIs) {
  MaterialFit fit;
  EXPECT_EQ(source_of({}, fit, MaterialKind::kParts), "by parts, fitted to the reference video");
  EXPECT_EQ(source_of({}, fit, MaterialKind::kTriplanes), "triplanes, fitted to the reference video");
  fit.field_left = true;
  for (const MaterialKind kind : {MaterialKind::kParts, MaterialKind::kSmooth})
    EXPECT_EQ(source_of({}, fit, kind), "homogeneous, fitted to the reference video");
  StartMaterial given;
  given.given = true;
  EXPECT_EQ(source_of(given, fit, MaterialKind::kParts),
            "the initial material times one factor, fitted to the reference video");
}

}  // namespace
}  // namespace pliant

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

TEST(FitOutcome, AFieldThatWasLeftIsWrittenAsTheConstantItIs) {
  MaterialFit fit;
  EXPECT_EQ(source_of(fit, MaterialKind::kParts), "by parts, fitted to the reference video");
  EXPECT_EQ(source_of(fit, MaterialKind::kTriplanes), "triplanes, fitted to the reference video");
  fit.field_left = true;
  for (const MaterialKind kind : {MaterialKind::kParts, MaterialKind::kSmooth})
    EXPECT_EQ(source_of(fit, kind), "homogeneous, fitted to the reference video");
}

}  // namespace
}  // namespace pliant

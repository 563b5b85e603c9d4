// The sentences about what a recording of markers does not determine.

#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "app/fit/fit_limits.h"
#include "fitting/fit/fit_markers.h"

namespace pliant {
namespace {

bool has_words(const std::vector<std::string>& sentences, const std::string& words) {
  for (const std::string& sentence : sentences)
    if (sentence.find(words) != std::string::npos) return true;
  return false;
}

TEST(FitLimitsMarkers, EachDoubtIsSaidAndOnlyThen) {
  MarkerFitOptions options;
  MarkerFitResult sure;
  sure.converged = true;
  sure.rms = 0.002;
  sure.rms_still = 0.02;
  sure.sigma_log10_young = 0.01;
  sure.sigma_release = 0.001;
  EXPECT_TRUE(doubts_of(sure, options).empty());
  EXPECT_EQ(undetermined_by_markers(sure, options, true, false).size(), 2u);
  struct Weak {
    std::string words;
    std::function<void(MarkerFitResult&)> make;
  };
  const std::vector<Weak> all = {
      {"from the high end of the search: the recording does not determine it",
       [](MarkerFitResult& r) {
         r.search_end = 1;
         r.sigma_log10_young = 1;
       }},
      {"from the low end of the search", [](MarkerFitResult& r) { r.search_end = -1; }},
      {"explains little of the recording: marker RMSE 15 mm, against 20 mm", [](MarkerFitResult& r) { r.rms = 0.015; }},
      {"explains nothing of the recording", [](MarkerFitResult& r) { r.rms = 0.021; }},
      {"stopped before it converged", [](MarkerFitResult& r) { r.converged = false; }},
      {"not found within the range searched",
       [](MarkerFitResult& r) { r.sigma_release = std::numeric_limits<double>::infinity(); }},
      {"known only to within 0.05 s", [](MarkerFitResult& r) { r.sigma_release = 0.05; }}};
  for (const Weak& weak : all) {
    MarkerFitResult doubted = sure;
    weak.make(doubted);
    EXPECT_EQ(doubts_of(doubted, options).size(), 1u) << weak.words;
    EXPECT_TRUE(has_words(doubts_of(doubted, options), weak.words)) << weak.words;
    const std::vector<std::string> listed = undetermined_by_markers(doubted, options, true, false);
    EXPECT_EQ(listed.size(), 3u) << weak.words;
    EXPECT_TRUE(has_words({listed[0]}, weak.words)) << listed[0];
  }
  MarkerFitResult lost = sure;
  lost.sigma_release = std::numeric_limits<double>::infinity();
  options.release = 0.3;
  EXPECT_TRUE(has_words(doubts_of(lost, options), "of --marker-release, which may be wrong"));
}

TEST(FitLimitsMarkers, WhatAnyRecordingLeavesOpenIsListedButNotDoubted) {
  MarkerFitOptions options;
  MarkerFitResult fit;
  fit.converged = true;
  fit.rms = 0.002;
  fit.rms_still = 0.02;
  fit.sigma_log10_young = 0.3;
  fit.sigma_log_damping = 1;
  EXPECT_TRUE(doubts_of(fit, options).empty());
  const std::vector<std::string> listed = undetermined_by_markers(fit, options, false, true);
  for (const char* words : {"valid for the given density, Poisson's ratio and load", "One factor of the given material",
                            "within a factor of 2", "Damping is not determined by 1 s of motion"})
    EXPECT_TRUE(has_words(listed, words)) << words;
}

}  // namespace
}  // namespace pliant

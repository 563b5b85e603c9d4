#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "app/evaluate/study/study_list.h"

namespace pliant {

/// Of a pair shown for one question: whether ours was chosen.
struct StudyChoice {
  std::string scene, baseline, question;
  bool ours = false;
};
struct StudyScore {
  std::string scene, method, rating;
  int value = 0;
};

/// What one participant's file holds.
struct Participant {
  int number = 0;
  bool professional = false;
  int checks = 0, checks_passed = 0;
  std::vector<StudyChoice> choices;
  std::vector<StudyScore> scores;

  /// Whoever chose the broken clip more often than one time in four did not look.
  bool attentive() const { return 4 * (checks - checks_passed) <= checks; }
};

/// Answers that the page saved: files, or folders of them.  Answers to another study, to what it does not ask, twice by
/// one participant or for one question are an Error{kInput} that names file, key and value.
std::vector<Participant> read_answers(const StudyList& study, const std::vector<std::filesystem::path>& files);

}  // namespace pliant

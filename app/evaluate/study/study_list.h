#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace pliant {

/// What is asked about a pair of clips, and about a single one.
struct StudyQuestion {
  std::string name, text;
};
struct StudyRating {
  std::string name, text, lowest_means, highest_means;
  int lowest = 1, highest = 7;
};

struct StudyScene {
  std::string name;
  std::optional<std::filesystem::path> reference;      ///< shown beside each pair
  std::map<std::string, std::filesystem::path> clips;  ///< by method
};

/// Two clips of which one is plainly worse: who prefers it did not look.
struct StudyCheck {
  std::filesystem::path good, broken;
};

/// study.json: title, introduction, seed, ours, scenes [{name, clips {METHOD: FILE}, reference}], questions
/// [{name, text}], ratings [{name, text, lowest, highest, lowest_means, highest_means}], checks [{good, broken}].
/// Without questions, those of PhysDreamer's study are asked (Zhang et al. 2024); without ratings, one for the quality
/// of each clip, as in Sim Anything's (Zhao et al. 2024); an empty list asks none.  Checks are asked the questions, and
/// are refused without any.  Files are relative to the list.
struct StudyList {
  std::string title, introduction, ours;
  int seed = 1;
  std::vector<StudyQuestion> questions;
  std::vector<StudyRating> ratings;
  std::vector<StudyScene> scenes;
  std::vector<StudyCheck> checks;
  std::string id;  ///< of the list's content and its clips: answers name it
};

/// Throws an Error that names file, key and value.
StudyList read_study(const std::filesystem::path& file);

/// The methods other than `ours`, each once.
std::vector<std::string> baselines_of(const StudyList& study);

}  // namespace pliant

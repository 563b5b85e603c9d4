#include "app/evaluate/study/study_answers.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "gaussians/base/error.h"
#include "gaussians/io/files/json_file.h"

namespace fs = std::filesystem;
using nlohmann::json;

namespace pliant {
namespace {

std::vector<fs::path> json_files(const std::vector<fs::path>& given) {
  std::vector<fs::path> files;
  std::error_code ignored;
  for (const fs::path& path : given) {
    if (!fs::is_directory(path, ignored)) {
      files.push_back(path);
      continue;
    }
    for (const auto& entry : fs::directory_iterator(path))
      if (entry.path().extension() == ".json") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  if (files.empty()) throw input_error(given.at(0).string(), "", "has no JSON file", "give what the page saved");
  return files;
}

const StudyScene* scene_named(const StudyList& study, const std::string& name) {
  const auto found =
      std::find_if(study.scenes.begin(), study.scenes.end(), [&](const auto& s) { return s.name == name; });
  return found == study.scenes.end() ? nullptr : &*found;
}

bool flag(const JsonObject& row, const json& value, const std::string& key) {
  const auto found = value.find(key);
  if (found == value.end() || !found->is_boolean()) throw row.complaint(key, "is not true or false", "save it anew");
  return found->get<bool>();
}

/// One object of `answers`.
void add_answer(const StudyList& study, const JsonObject& row, Participant& participant,
                std::set<std::vector<std::string>>& given) {
  const auto refuse = [&](const std::string& key) {
    return row.complaint(key, "is '" + row.text(key) + "', which the study does not have",
                         "give answers to this study");
  };
  const std::string kind = row.text("kind");
  const bool rating = kind == "rating", check = kind == "check";
  if (!rating && !check && kind != "choice") throw refuse("kind");
  const std::string topic = rating ? "rating" : "question", scene_name = row.text("scene"), name = row.text(topic);
  const auto has = [&](const auto& list) {
    return std::any_of(list.begin(), list.end(), [&](const auto& asked) { return asked.name == name; });
  };
  if (rating ? !has(study.ratings) : !has(study.questions)) throw refuse(topic);
  const StudyScene* scene = scene_named(study, scene_name);
  if (!check && !scene) throw refuse("scene");
  std::string method;
  if (rating) {
    method = row.text("method");
    if (!scene->clips.count(method)) throw refuse("method");
    const auto asked =
        std::find_if(study.ratings.begin(), study.ratings.end(), [&](const auto& r) { return r.name == name; });
    const double score = row.number("value");
    if (score != static_cast<int>(score) || score < asked->lowest || score > asked->highest)
      throw row.complaint("value", "is " + json(score).dump(),
                          "scores go from " + std::to_string(asked->lowest) + " to " + std::to_string(asked->highest));
    participant.scores.push_back({scene_name, method, name, static_cast<int>(score)});
  } else {
    const json& shown = row.array("shown");
    const std::string chosen = row.text("chosen"), first = check ? "good" : study.ours;
    if (shown.size() != 2 || !shown[0].is_string() || !shown[1].is_string() || (shown[0] != first && shown[1] != first))
      throw row.complaint("shown", "is " + shown.dump(), "a pair is '" + first + "' and another");
    method = shown[0] == first ? shown[1] : shown[0];
    if (chosen != first && chosen != method) throw refuse("chosen");
    if (check) {
      ++participant.checks;
      participant.checks_passed += chosen == first;
    } else {
      if (!scene->clips.count(method)) throw row.complaint("shown", "is " + shown.dump(), "the scene has no such pair");
      participant.choices.push_back({scene_name, method, name, chosen == study.ours});
    }
  }
  if (!given.insert({kind, scene_name, method, name}).second)
    throw row.complaint(topic, "is '" + name + "' twice for scene '" + scene_name + "'", "keep one answer");
}

}  // namespace

std::vector<Participant> read_answers(const StudyList& study, const std::vector<fs::path>& files) {
  std::vector<Participant> participants;
  std::set<int> numbers;
  for (const fs::path& file : json_files(files)) {
    const json whole = read_json(file);
    const JsonObject top(whole, file.string(), "", Failure::kInput);
    if (top.text("study") != study.id)
      throw top.complaint("study", "is '" + top.text("study") + "'",
                          "these are answers to another study, or its list or clips have changed ('" + study.id + "')");
    Participant participant;
    participant.number = static_cast<int>(top.number("participant"));
    if (!numbers.insert(participant.number).second)
      throw top.complaint("participant", "is " + std::to_string(participant.number) + " in two files",
                          "keep one of them");
    participant.professional = flag(top, whole, "professional");
    std::set<std::vector<std::string>> given;
    const json& rows = top.array("answers");
    for (size_t i = 0; i < rows.size(); ++i)
      add_answer(study, JsonObject(rows[i], file.string(), "answers[" + std::to_string(i) + "]", Failure::kInput),
                 participant, given);
    participants.push_back(std::move(participant));
  }
  return participants;
}

}  // namespace pliant

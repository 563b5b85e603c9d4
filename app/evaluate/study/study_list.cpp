#include "app/evaluate/study/study_list.h"

#include <nlohmann/json.hpp>
#include <set>

#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/files/json_file.h"

namespace fs = std::filesystem;
using nlohmann::json;

namespace pliant {
namespace {

constexpr double kMostBytes = 3e8;  // of all clips: what browsers hold as one text

std::string text_or(const JsonObject& object, const std::string& key, const std::string& otherwise) {
  return object.has(key) ? object.text(key) : otherwise;
}

int whole_number(const JsonObject& object, const std::string& key, int otherwise, int low, int high) {
  const double value = object.number(key, otherwise);
  if (value != std::floor(value) || value < low || value > high)
    throw object.complaint(key, "is " + json(value).dump(),
                           "give a whole number from " + std::to_string(low) + " to " + std::to_string(high));
  return static_cast<int>(value);
}

/// Calls `each` with every object of an array and its path.
template <class F>
void for_each(const JsonObject& parent, const std::string& key, F&& each) {
  const json& rows = parent.array(key);
  for (size_t i = 0; i < rows.size(); ++i)
    each(JsonObject(rows[i], parent.file(), parent.path_of(key) + "[" + std::to_string(i) + "]"));
}

class Reader {
 public:
  explicit Reader(const fs::path& file) : folder_(file.parent_path()) {}

  /// A clip beside the list.
  fs::path clip(const JsonObject& owner, const std::string& key) {
    const fs::path file = folder_ / owner.text(key);
    const std::string extension = file.extension().string();
    if (extension != ".mp4" && extension != ".webm")
      throw owner.complaint(key, "is '" + owner.text(key) + "'", "give an .mp4 (H.264) or .webm, which browsers play");
    std::error_code failed;
    if (!fs::is_regular_file(file, failed))
      throw owner.complaint(key, "is '" + owner.text(key) + "', which does not exist",
                            "names are relative to the list");
    if (sizes_.insert(file).second) bytes_ += static_cast<double>(fs::file_size(file));
    if (bytes_ > kMostBytes)
      throw owner.complaint(key, "makes the clips larger than 300 MB together", "use shorter or smaller clips");
    hashes_ += sha256_of_file(file);
    return file;
  }
  const std::string& hashes() const { return hashes_; }

 private:
  fs::path folder_;
  std::set<fs::path> sizes_;
  double bytes_ = 0;
  std::string hashes_;
};

void refuse_twice(const JsonObject& owner, std::set<std::string>& names, const std::string& name) {
  if (name.empty()) throw owner.complaint("name", "is empty", "give it a name");
  if (!names.insert(name).second) throw owner.complaint("name", "is '" + name + "' twice", "give each its own name");
}

}  // namespace

StudyList read_study(const fs::path& file) {
  const json whole = read_json(file);
  const JsonObject top(whole, file.string());
  top.refuse_unknown({"title", "introduction", "seed", "ours", "scenes", "questions", "ratings", "checks"});
  Reader reader(file);
  StudyList study;
  study.title = text_or(top, "title", "Which motion is more realistic?");
  study.introduction = text_or(top, "introduction", "You will see clips of moving objects.");
  study.seed = whole_number(top, "seed", 1, 0, 1000000000);
  study.ours = top.text("ours");
  std::set<std::string> names;
  for_each(top, "scenes", [&](const JsonObject& row) {
    row.refuse_unknown({"name", "clips", "reference"});
    StudyScene scene;
    scene.name = row.text("name");
    refuse_twice(row, names, scene.name);
    const JsonObject clips = row.object("clips");
    for (const std::string& method : clips.keys()) scene.clips[method] = reader.clip(clips, method);
    if (!scene.clips.count(study.ours))
      throw row.complaint("clips", "has no clip of '" + study.ours + "'", "every scene needs one of `ours`");
    if (row.has("reference")) scene.reference = reader.clip(row, "reference");
    study.scenes.push_back(std::move(scene));
  });
  if (study.scenes.empty()) throw top.complaint("scenes", "is empty", "give at least one scene");
  names.clear();
  if (top.has("questions")) {
    for_each(top, "questions", [&](const JsonObject& row) {
      row.refuse_unknown({"name", "text"});
      study.questions.push_back({row.text("name"), row.text("text")});
      refuse_twice(row, names, study.questions.back().name);
    });
  } else {
    study.questions = {{"motion", "Which clip moves more realistically?"},
                       {"visual", "Which clip has the better visual quality?"}};
  }
  names.clear();
  if (top.has("ratings")) {
    for_each(top, "ratings", [&](const JsonObject& row) {
      row.refuse_unknown({"name", "text", "lowest", "highest", "lowest_means", "highest_means"});
      StudyRating rating{row.text("name"), row.text("text"), text_or(row, "lowest_means", "worst"),
                         text_or(row, "highest_means", "best")};
      rating.lowest = whole_number(row, "lowest", 1, 0, 99);
      rating.highest = whole_number(row, "highest", 7, rating.lowest + 1, rating.lowest + 10);
      refuse_twice(row, names, rating.name);
      study.ratings.push_back(std::move(rating));
    });
  } else {
    study.ratings = {{"quality", "How realistic is this clip?", "not at all", "entirely"}};
  }
  if (top.has("checks"))
    for_each(top, "checks", [&](const JsonObject& row) {
      row.refuse_unknown({"good", "broken"});
      study.checks.push_back({reader.clip(row, "good"), reader.clip(row, "broken")});
    });
  if (study.questions.empty() && study.ratings.empty())
    throw top.complaint("questions", "and ratings are empty", "ask something");
  if (study.questions.empty() && !study.checks.empty())
    throw top.complaint("checks", "are only shown with questions, which are empty",
                        "ask a question, or leave them out");
  study.id = sha256_of_text(whole.dump() + reader.hashes()).substr(0, 16);
  return study;
}

std::vector<std::string> baselines_of(const StudyList& study) {
  std::set<std::string> names;
  for (const StudyScene& scene : study.scenes)
    for (const auto& [method, clip] : scene.clips)
      if (method != study.ours) names.insert(method);
  return {names.begin(), names.end()};
}

}  // namespace pliant

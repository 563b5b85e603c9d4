#include "app/segment/scene_file_names.h"

#include <nlohmann/json.hpp>

#include "gaussians/io/files/files.h"

namespace pliant {
using nlohmann::json;
using Reach = FileNames::Reach;

namespace {

/// For a scene that was trained together with its labels, in `folder`.
FileNames names_of_training(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "run.json";
  const json record = std::filesystem::exists(file) ? json::parse(read_text(file), nullptr, false) : json();
  const json::json_pointer stage("/stages/reconstruct/inputs");
  const json inputs = record.is_object() && record.contains(stage) ? record.at(stage) : json::object();
  if (!inputs.contains("joint masks")) return {Reach::kTrained, true};
  if (!inputs.contains("masks")) return {Reach::kAll, true};
  const bool own = inputs["masks"] == inputs["joint masks"];
  return {own ? Reach::kTrained : Reach::kOther, own};
}

/// Whether a name is an ID, or what an object without a name is called.
bool is_number(std::string name) {
  if (name.rfind("object_", 0) == 0) name.erase(0, 7);
  return name.find_first_not_of("0123456789") == std::string::npos;
}

}  // namespace

FileNames names_of_file(const RunDirectory& run, const Scene& scene, const json& segmented) {
  if (segmented.value("automatic", false) || segmented.value("selected", false)) return {Reach::kGiven, false};
  if (scene.settings.file.empty()) return {Reach::kOther, false};
  const json inputs = run.manifest()["stages"]["segment"].value("inputs", json::object());
  if (inputs.contains("joint")) return names_of_training(scene.source);
  const bool ids = segmented.value("ids_hold", true);
  const std::filesystem::path& masks = scene.settings.masks;
  if (masks.empty() && segmented.value("labelled", false)) return {Reach::kOther, false};
  if (masks.empty()) return {Reach::kAll, ids};
  // Files that came into the folder since do not count.
  const bool own =
      segmented.value("own_masks", false) || (inputs.contains("masks") && inputs["masks"] == hash_of_input(masks));
  return {own ? Reach::kOwn : Reach::kOther, own && ids};
}

std::string present_name(const FileNames& names, const json& edits, std::string name) {
  const bool meant = names.reach >= Reach::kOther && (names.ids || !is_number(name));
  bool given = false;
  for (const json& edit : edits) {
    if (edit.contains("renamed")) {
      if (meant && edit["renamed"][0] == name) name = edit["renamed"][1];
      given = given || edit["renamed"][1] == name;
    }
    if (!meant && !given) continue;
    for (const json& merged : edit.value("merged", json::array()))
      if (merged[1] == name || merged[0].dump() == name) {
        name = edit["into"].dump();
        break;
      }
  }
  return meant || given ? name : "";
}

}  // namespace pliant

#include "app/segment/edit_stage.h"

#include <fmt/format.h>

#include <map>
#include <nlohmann/json.hpp>

#include "app/segment/objects_file.h"
#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"

namespace pliant {
using nlohmann::json;

namespace {

/// "kind" by id of the objects of the automatic mode; empty where objects.json tells none.
std::map<uint32_t, std::string> kinds_told(const RunDirectory& run) {
  std::map<uint32_t, std::string> kinds;
  const json objects = json::parse(read_text(run / "objects.json"), nullptr, false);
  if (!objects.is_array()) return kinds;
  for (const json& row : objects)
    if (row.is_object() && row.contains("kind") && row["kind"].is_string()) kinds[row.at("id")] = row["kind"];
  return kinds;
}

/// What is split off or given a name by hand is an object; what is split off a support is another one.
void edit_kinds(const ObjectEdit& edit, const EditOutcome& outcome, std::map<uint32_t, std::string>& kinds) {
  if (outcome.ids.empty() || kinds.count(outcome.ids[0]) == 0) return;
  const std::string kind = kinds[outcome.ids[0]], edited = kind == "rest" ? "object" : kind;
  if (edit.kind == ObjectEdit::Kind::kName && edit.name != "rest") kinds[outcome.ids[0]] = edited;
  for (size_t k = 1; k < outcome.ids.size(); ++k) kinds[outcome.ids[k]] = edited;
}

/// The cameras that `segment` has not learnt from, by its record.
std::vector<int> held_out_of(const RunDirectory& run, size_t cameras) {
  const json record = run.last_record("segment");
  if (!record.is_object()) return {};
  auto held_out = record.value("found", json::object()).value("held_out", std::vector<int>());
  std::erase_if(held_out, [&](int c) { return c < 0 || static_cast<size_t>(c) >= cameras; });
  return held_out;
}

}  // namespace

json run_edit(const Context& context, RunDirectory& run, const Scene& scene, const EditStage& stage) {
  if (stage.edits.empty())
    throw usage_error("segment edit", "", "has nothing to do",
                      "give --merge 3,7, --split 4, --drop 9 or --name 3=vase");
  run.hold();
  Segmentation segmentation = read_objects(run, scene);
  std::vector<std::pair<uint32_t, std::string>> named_before;
  for (size_t c = 0; c < segmentation.class_id.size(); ++c)
    named_before.emplace_back(segmentation.class_id[c], segmentation.class_name[c]);
  std::map<uint32_t, std::string> kinds = kinds_told(run);
  json operations = json::array();
  for (const ObjectEdit& edit : stage.edits) {
    const EditOutcome outcome = apply_edit({}, edit, scene.cloud, scene.cameras, segmentation);
    edit_kinds(edit, outcome, kinds);
    operations.push_back({{"option", edit.option()},
                          {"value", edit.text()},
                          {"gaussians", outcome.gaussians},
                          {"did", outcome.sentence}});
    if (!outcome.old_name.empty()) operations.back()["renamed"] = {outcome.old_name, edit.name};
    if (!outcome.merged.empty()) operations.back().update({{"merged", outcome.merged}, {"into", outcome.ids[0]}});
  }
  // Said once all of them are known to be possible.
  for (const json& operation : operations) context.progress.say("edit: " + operation["did"].get<std::string>());
  json edits = run.note("edits");
  for (const json& operation : operations) edits.push_back(operation);
  const json provenance = {{"pliant", PLIANT_VERSION}, {"stage", "edit"}, {"edits", edits}};
  const auto tell_kind = [&](json& rows) {
    for (json& row : rows)
      if (const auto kind = kinds.find(row["id"]); kind != kinds.end()) row["kind"] = kind->second;
  };
  const std::vector<ObjectEntry> objects =
      write_objects(context, run, scene, "segment", provenance.dump(), segmentation, tell_kind);
  run.set_note("edits", edits);
  write_held_out(run, scene, held_out_of(run, scene.cameras.size()), segmentation);
  for (const auto& [id, name] : named_before) {
    const int c = class_of_id(segmentation, id);
    if (c < 0 || segmentation.class_name[c] == name) continue;
    const std::string before = folder_of_object(id, name), after = folder_of_object(id, segmentation.class_name[c]);
    const bool there = std::filesystem::exists(run / before);
    const std::string aside = run.move_folder(before, after);
    if (!aside.empty()) context.progress.say("edit: the previous " + after + " is kept in " + aside);
    if (there) context.progress.say("edit: " + before + " is now " + after);
  }
  for (const ObjectEntry& object : objects)
    context.progress.say(fmt::format("edit: {:>4} {:<16} {:>8} Gaussians, confidence {:.2f}", object.id, object.name,
                                     object.gaussians, object.score));
  if (run.has("extract"))
    context.progress.say("edit: the objects have changed; extract and later stages run again when requested");
  return {{"edits", operations}, {"objects", objects_to_json(objects)}};
}

}  // namespace pliant

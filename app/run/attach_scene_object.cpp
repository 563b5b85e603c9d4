#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/run/attach_scene.h"
#include "app/run/scene_parts.h"
#include "gaussians/base/error.h"

namespace pliant {
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr const char* kAssumedHeight = "assumed_height";

/// The ID of an object by its folder, objects/ID_NAME.
std::string id_of_folder(const std::string& folder) {
  const std::string name = fs::path(folder).filename().string();
  return name.substr(0, name.find('_'));
}

/// Whether the material of an object is among what a stage has written.
bool writes_material(const json& record) {
  const json outputs = record.value("outputs", json::array());
  return std::any_of(outputs.begin(), outputs.end(), [](const json& output) {
    return fs::path(output.get<std::string>()).filename() == "material.h5";
  });
}

/// The hash of what `extract` cut the object from; null where it is not recorded.
json segmentation_of_object(const RunDirectory& run) {
  return run.manifest()["stages"]["extract"].value("inputs", json::object()).value("segmentation", json());
}

/// Metres per unit with which a stage was made.
double scale_of(const RunDirectory& run, const std::string& stage, const Scene& scene) {
  const json record = run.manifest()["stages"][stage].value("scene", json::object());
  return record.value("metres_per_unit", scene.metres_per_unit);
}

}  // namespace

void scale_to_height(const RunDirectory& run, Scene& scene) {
  if (scene.object_height > 0 && run.has("extract"))
    scene.metres_per_unit = scene.object_height / extracted(run, {"height"})["height"].get<double>();
}

void scale_by_object(const RunDirectory& run, Scene& scene) {
  const std::optional<double> assumed = assumed_height(run);
  if (assumed && !scene.settings.metres_per_unit) scene.object_height = *assumed;
  scale_to_height(run, scene);
}

json identity_of_object(const RunDirectory& run) {
  json identity = {{"object", object_folder(run)}};
  if (const fs::path splats = run / (object_folder(run) + "/object.ply"); fs::exists(splats))
    identity["splats"] = hash_of_input(splats);
  if (const json segmentation = segmentation_of_object(run); !segmentation.is_null())
    identity["segmentation"] = segmentation;
  return identity;
}

bool is_present_object(const RunDirectory& run, const json& identity) {
  const std::string of = identity.value("object", ""), present = object_folder(run);
  const bool renamed = id_of_folder(of) == id_of_folder(present) && !fs::exists(run / of);
  if (of != present && !renamed) return false;
  // All that is selected by hand has one ID and name.
  const json now = identity_of_object(run);
  const auto same = [&](const char* what) { return !identity.contains(what) || identity[what] == now.value(what, ""); };
  return same("segmentation") || same("splats");
}

bool is_selected_anew(const RunDirectory& run) {
  if (!run.has("extract")) return false;
  const json cut_from = segmentation_of_object(run);
  const fs::path segmentation = run / "segmentation.h5";
  if (cut_from.is_null() || !fs::exists(segmentation) || cut_from == hash_of_input(segmentation)) return false;
  const json edits = run.note("edits");
  return edits.empty() ||
         std::any_of(edits.begin(), edits.end(), [](const json& edit) { return edit.value("option", "") != "--name"; });
}

void warn_of_selection(const Context& context, const RunDirectory& run) {
  if (is_selected_anew(run))
    context.progress.warn("the objects have changed since '" + extracted(run, {"name"}).value("name", "") +
                          "' was extracted, which still counts: run `pliant extract` and what follows again");
}

std::optional<double> assumed_height(const RunDirectory& run) {
  const json note = run.note(kAssumedHeight);
  if (note.is_number()) return note.get<double>();  // of whichever object there is
  if (!note.is_object() || !run.has("extract")) return std::nullopt;
  return is_present_object(run, note) ? std::optional(note.value("height", 0.0)) : std::nullopt;
}

void record_assumed_height(RunDirectory& run, const std::optional<double>& metres) {
  json note;
  if (metres) {
    note = identity_of_object(run);
    note["height"] = *metres;
  }
  run.set_note(kAssumedHeight, note);
}

void forget_assumed_height(RunDirectory& run, Scene& scene) {
  if (run.note(kAssumedHeight).is_null()) return;
  record_assumed_height(run, {});
  scene.object_height = run.scene().value("object_height", 0.0);
  if (!run.scene().contains("metres_per_unit") && !scene.settings.metres_per_unit) scene.metres_per_unit = 1;
}

bool reads_present(const RunDirectory& run, const std::string& stage, const std::string& role) {
  const json inputs = run.manifest()["stages"][stage].value("inputs", json::object());
  const fs::path file = run / (object_folder(run) + "/" + role + (role == "object" ? ".ply" : ".h5"));
  return !inputs.contains(role) || (fs::exists(file) && inputs[role] == hash_of_input(file));
}

bool predicts_object(const RunDirectory& run) {
  if (!run.has("predict")) return false;
  const json& outputs = run.manifest()["stages"]["predict"]["outputs"];
  return !outputs.empty() && outputs[0] == object_folder(run) + "/predicted.h5" &&
         reads_present(run, "predict", "object");
}

std::string prediction_is_of(const RunDirectory& run, const Scene& scene) {
  if (!predicts_object(run)) return "of another object";
  return scale_of(run, "predict", scene) == scene.metres_per_unit ? "" : "made with another scale";
}

std::string changed_since_prediction(const RunDirectory& run, const Scene& scene) {
  const json record = run.manifest()["stages"]["predict"].value("scene", json::object());
  if (!record.contains("material")) return "";
  json before, now;
  for (const char* name : {"young", "poisson", "density"}) {
    before[name] = record["material"].value(name, json());
    now[name] = record_of({ScenePart::kMaterial}, scene).values["material"][name];
  }
  return first_difference(before, now, "material");
}

bool is_fitted(const RunDirectory& run) { return run.has("fit") && writes_material(run.manifest()["stages"]["fit"]); }

bool is_refit_unfinished(const RunDirectory& run) {
  if (run.has("fit")) return false;
  const json last = run.last_record("fit");
  return last.is_object() && last.contains("replaced") && writes_material(last["replaced"]["record"]);
}

std::string fit_is_of(const RunDirectory& run, const Scene& scene) {
  if (!is_fitted(run)) return "";
  if (!reads_present(run, "fit", "particles")) return "other particles";
  return scale_of(run, "fit", scene) == scene.metres_per_unit ? "" : "another scale";
}

void check_filled(const RunDirectory& run) {
  run.summary("fill", "run `pliant seed` first");
  if (!reads_present(run, "fill", "object"))
    throw usage_error(run.path().string(), "seed", "filled another object, or another cut of it, than is extracted",
                      "run `pliant seed` again");
}

bool seeds_object(const RunDirectory& run) { return !run.has("seed") || reads_present(run, "seed", "object"); }

void check_seeded(const RunDirectory& run) {
  run.summary("seed", "run `pliant seed` first");
  if (!seeds_object(run))
    throw usage_error(run.path().string(), "seed",
                      "placed particles in another object, or another cut of it, than is extracted",
                      "run `pliant seed` again");
}

void check_simulated(const RunDirectory& run) {
  run.summary("simulate", "run `pliant simulate` first");
  if (!seeds_object(run))
    throw usage_error(run.path().string(), "simulate", "moved another object, or another cut of it, than is extracted",
                      "run `pliant seed` and `pliant simulate` again");
  if (!reads_present(run, "simulate", "particles"))
    throw usage_error(run.path().string(), "simulate", "used particles that have since been replaced by `seed`",
                      "run `pliant simulate` again");
}

void check_simulated_with(const RunDirectory& run, const Scene& scene) {
  check_simulated(run);
  const json& record = run.manifest()["stages"]["simulate"];
  const json session = record["summary"].value("session", json::object());
  const json material = record["inputs"].value("material", json());
  const fs::path file = run / session.value("material_file", std::string());
  if (session.contains("material_file") && !material.is_null() && fs::exists(file) && material != hash_of_input(file))
    throw usage_error(run.path().string(), "simulate", "used a material that has since been replaced",
                      "run `pliant simulate` again");
  if (scale_of(run, "simulate", scene) != scene.metres_per_unit)
    throw usage_error(run.path().string(), "simulate", "used a scale that has since been replaced",
                      "run `pliant simulate` again");
}

json extracted(const RunDirectory& run, const std::vector<std::string>& names) {
  const json& all = run.summary("extract", "run `pliant extract DIR --object NAME` first");
  json out = json::object();
  for (const std::string& name : names)
    if (all.contains(name)) out[name] = all[name];
  return out;
}

std::string object_folder(const RunDirectory& run) {
  return run.summary("extract", "run `pliant extract DIR --object NAME` first")["folder"];
}

}  // namespace pliant

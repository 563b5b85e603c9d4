#include <sstream>

#include "app/fit/fit_report.h"
#include "app/fit/fit_stage.h"
#include "app/fit/fit_video.h"
#include "app/fit/start_material.h"
#include "app/run/attach_scene.h"
#include "app/run/physdreamer_scene.h"
#include "app/simulate/moving_scene.h"
#include "fitting/fields/triplane_field.h"
#include "gaussians/base/error.h"
#include "physics/laws/law.h"

namespace pliant {
namespace {

/// Files that the command line of a program names: the program itself, a script, weights.
void add_program(const std::string& option, const std::string& command, FitInputs& in) {
  std::istringstream words(command);
  for (std::string word; words >> word;)
    if (std::error_code none; std::filesystem::is_regular_file(word, none)) in.files[option + " " + word] = word;
}

void add_video(const Scene& scene, const FitStage& stage, FitInputs& in) {
  in.parts.insert({ScenePart::kDrawing, ScenePart::kCameras, ScenePart::kFolder});
  const bool named = !stage.videos.empty() || !stage.generate.command.empty();
  in.parts.insert(named ? ScenePart::kVideoCamera : ScenePart::kVideo);
  for (const auto& [role, file] : video_files(scene, stage)) in.files[role] = file;
  in.found["videos"] = video_records(scene, stage);
  // A camera is found by what the scene looks like, a program is shown it, labels are those of its Gaussians.
  if (!knows_cameras(scene, stage) || stage.refine_camera || !stage.generate.command.empty() ||
      !stage.part_labels.empty())
    in.parts.insert(ScenePart::kSplats);
}

void add_released_fields(const Scene& scene, FitInputs& in) {
  const std::optional<PhysDreamerFolder> source = physdreamer_folder(scene);
  if (!source)
    throw usage_error("--released-fields", "", "needs a scene folder of PhysDreamer",
                      "give a PhysDreamer scene folder");
  if (source->material_field.empty())
    throw input_error((scene.source / "sim_fields.pt").string(), "", "is missing", "copy the published field there");
  in.parts.insert({ScenePart::kFolder, ScenePart::kSplats});
  in.files["material_field"] = source->material_field;
  if (!source->velocity_field.empty()) in.files["velocity_field"] = source->velocity_field;
}

}  // namespace

FitKind kind_of(const FitStage& stage, const Scene& scene) {
  if (!stage.markers.file.empty()) return FitKind::kMarkers;
  if (stage.released_young) return FitKind::kReleased;
  if (stage.kinematic()) return FitKind::kKinematic;
  const bool guided = !stage.compare.guide.empty() && (stage.distilled() || !has_video(scene, stage));
  return guided ? FitKind::kGuided : FitKind::kVideo;
}

FitInputs inputs_of(const RunDirectory& run, const Scene& scene, const FitStage& stage) {
  check_fit_stage(stage, has_video(scene, stage));
  check_seeded(run);
  const std::string folder = object_folder(run);
  const FitKind kind = kind_of(stage, scene);
  FitInputs in;
  in.options = with_recipe(stage);
  add_program("guidance-cmd", stage.compare.guide, in);
  add_program("video-model-cmd", stage.generate.command, in);
  in.parts = {ScenePart::kUp, ScenePart::kMetresPerUnit, ScenePart::kMaterial};
  in.files["particles"] = run / (folder + "/particles.h5");
  in.outputs = {folder + "/material.h5", folder + "/velocity.h5", "fit/results.json"};
  in.kept = {"fit", folder + "/material.h5", folder + "/velocity.h5"};
  // The law and its constants are no options of this stage.
  const std::string initial = initial_material_file(run, scene, stage);
  if (!initial.empty()) in.files["initial_material"] = initial;
  const ObjectMaterial material = check_material(scene, stage.material, start_set_by(stage));
  in.found["material"] = material_to_json(material);
  const Law law = material.material.law;
  if (kind == FitKind::kVideo && stage.recipe == "search" && !is_elastic(law))
    throw usage_error("fit", "material.law",
                      "is '" + std::string(law_name(law)) + "', and the search covers elastic vibration alone",
                      "add " + stage.typed("recipe") + " physdreamer, which fits by gradients alone");
  if (kind == FitKind::kVideo || kind == FitKind::kGuided || kind == FitKind::kKinematic) {
    in.files["object"] = run / (folder + "/object.ply");
    in.files["background"] = background_of(run);
  }
  switch (kind) {
    case FitKind::kVideo:
      add_video(scene, stage, in);
      if (stage.recipe != "search" && run.summary("seed", "").value("pinned", nlohmann::json()).empty())
        in.found.update(extracted(run, {"height", "contact"}));
      in.outputs.push_back("fit/side_by_side.mp4");
      break;
    case FitKind::kKinematic:
      add_video(scene, stage, in);
      in.outputs = {"fit/trajectory.h5", "fit/results.json", "fit/side_by_side.mp4"};
      in.kept = {"fit"};
      break;
    case FitKind::kGuided:
      in.parts.insert({ScenePart::kDrawing, ScenePart::kCameras, ScenePart::kVideoCamera});
      if (!stage.part_labels.empty()) in.parts.insert(ScenePart::kSplats);
      in.found.update(extracted(run, {"height", "contact"}));
      in.outputs.push_back("fit/guided.mp4");
      break;
    case FitKind::kMarkers:
      in.outputs.push_back("fit/markers.png");
      break;
    case FitKind::kReleased:
      add_released_fields(scene, in);
      break;
  }
  in.scene = only(in.parts, scene);
  return in;
}

void require_networks(const FitStage& stage) {
  if (with_recipe(stage).field == "triplanes" || stage.kinematic() || stage.released_young) require_triplane_fields();
}

nlohmann::json run_fit(const Context& context, RunDirectory& run, const Scene& scene, const FitStage& stage) {
  const FitInputs in = inputs_of(run, scene, stage);
  const auto fit = [&] {
    switch (kind_of(stage, scene)) {
      case FitKind::kMarkers:
        return fit_to_markers;
      case FitKind::kReleased:
        return take_released_fields;
      case FitKind::kGuided:
        return fit_to_guide;
      case FitKind::kKinematic:
        return fit_without_physics;
      case FitKind::kVideo:
        break;
    }
    return fit_to_video;
  };
  nlohmann::json summary = run_stage(context, run, in, [&](const auto&... inputs) {
    require_networks(stage);
    return fit()(inputs...);
  });
  write_fit_page(run);
  return summary;
}

}  // namespace pliant

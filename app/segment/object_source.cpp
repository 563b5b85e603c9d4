#include "app/segment/object_source.h"

#include <nlohmann/json.hpp>

#include "app/run/physdreamer_scene.h"
#include "app/segment/automatic_objects.h"
#include "app/segment/label_choice.h"
#include "gaussians/base/error.h"

namespace pliant {
using nlohmann::json;

ObjectSource source_of(const Scene& scene, const SegmentStage& stage) {
  const bool gesture = has_gestures(stage);
  const bool shape = selection_of(stage).has_value(), grouping = !stage.gaussian_grouping.empty();
  const bool configured = !stage.physgaussian.empty(), labelling = labels_photos(stage);
  if (configured && (shape || gesture))
    throw usage_error("--physgaussian", stage.physgaussian, "was given together with a selection",
                      "its sim_area selects the object");
  const bool asked =
      shape || gesture || configured || grouping || stage.automatic || stage.joint || !stage.masks.empty() || labelling;
  const bool by_roles = !asked && physdreamer_folder(scene);
  const bool selecting = shape || gesture || configured || by_roles;
  if (stage.joint && selecting)
    throw usage_error("--joint", "", "was given together with a selection",
                      "joint training needs masks; give --masks FOLDER");
  if (grouping && (selecting || stage.joint || !stage.masks.empty()))
    throw usage_error("--gaussian-grouping", stage.gaussian_grouping, "was given together with masks or a selection",
                      "its classifier defines the objects");
  if (labelling && (selecting || grouping || stage.automatic || stage.joint || !stage.masks.empty())) {
    const TypedOption typed = labelling_option(stage.label);
    throw usage_error(typed.name, typed.value,
                      "was given together with --masks, --auto, --joint, --gaussian-grouping or a selection",
                      "leave one of them out: it makes masks of the photos");
  }
  const bool masks = labelling || !stage.masks.empty() || !scene.settings.masks.empty();
  if (grouping) return ObjectSource::kGrouping;
  if (segments_automatically(stage, selecting, masks)) return ObjectSource::kAutomatic;
  if (stage.joint) return ObjectSource::kJoint;
  if (configured) return ObjectSource::kConfiguration;
  if (by_roles) return ObjectSource::kPointFiles;
  if (prompts_segmenter(stage)) return ObjectSource::kSegmenter;
  return gesture ? ObjectSource::kGesture : shape ? ObjectSource::kShape : ObjectSource::kMasks;
}

void check_object_options(ObjectSource source, const SegmentStage& stage) {
  if (!learns_from_masks(source) && (stage.iterations || !stage.start_from_vote))
    throw usage_error(stage.iterations ? "--iterations" : "--no-vote", "",
                      "does nothing without masks: a selection and --auto say what every Gaussian is", "leave it out");
  if (stage.iterations == 0 && !stage.start_from_vote)
    throw usage_error("--no-vote", "", "leaves nothing that could tell labels where --iterations is 0",
                      "leave one of them out");
  const bool zero = !stage.mask_zero.empty() && source != ObjectSource::kJoint;
  if (source != ObjectSource::kMasks && (zero || stage.associate != "auto"))
    throw usage_error(zero ? "--mask-zero" : "--associate", "", "does nothing: the scene has no masks to learn from",
                      "give --masks FOLDER, or leave it out");
}

bool learns_from_masks(ObjectSource source) {
  return source == ObjectSource::kMasks || source == ObjectSource::kSegmenter || source == ObjectSource::kJoint;
}

bool has_learned_objects(const RunDirectory& run) {
  if (!run.has("segment")) return false;
  const json summary = run.last_record("segment").value("summary", json::object());
  return !summary.value("automatic", false) && !summary.value("selected", false);
}

bool selects_one_object(ObjectSource source) {
  return source == ObjectSource::kConfiguration || source == ObjectSource::kPointFiles ||
         source == ObjectSource::kSegmenter || source == ObjectSource::kGesture || source == ObjectSource::kShape;
}

std::optional<SelectionShape> selection_of(const SegmentStage& stage) {
  if (!stage.aabb.empty() && !stage.sphere.empty())
    throw usage_error("--sphere", "", "was given together with --aabb", "give one of them");
  if (!stage.aabb.empty()) return SelectionShape::from_aabb(stage.aabb);
  if (!stage.sphere.empty()) return SelectionShape::from_sphere(stage.sphere);
  return std::nullopt;
}

std::string origin_of(const SegmentStage& stage, ObjectSource source) {
  std::string how = source == ObjectSource::kPointFiles ? "PhysDreamer's point files" : "";
  const auto add = [&](bool given, const char* name) {
    how += given ? (how.empty() ? "" : ", ") + std::string(name) : "";
  };
  add(!stage.physgaussian.empty(), "PhysGaussian configuration");
  add(!stage.boxes.empty(), "box");
  add(!stage.clicks.empty(), "click");
  add(!stage.strokes.empty(), "stroke");
  add(!stage.aabb.empty(), "aabb");
  add(!stage.sphere.empty(), "sphere");
  add(stage.joint, "joint training");
  add(!stage.gaussian_grouping.empty(), "Gaussian Grouping");
  add(prompts_segmenter(stage), "segmenter");
  return how.empty() ? "masks" : how;
}

}  // namespace pliant

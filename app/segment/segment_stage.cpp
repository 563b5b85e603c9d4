#include "app/segment/segment_stage.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <numeric>

#include "app/import/gaussian_grouping.h"
#include "app/import/physgaussian_space.h"
#include "app/run/physdreamer_scene.h"
#include "app/segment/associated_masks.h"
#include "app/segment/automatic_objects.h"
#include "app/segment/grouping_objects.h"
#include "app/segment/interruption.h"
#include "app/segment/label_choice.h"
#include "app/segment/object_source.h"
#include "app/segment/objects_file.h"
#include "app/segment/prepared_scene_file.h"
#include "app/segment/prompted_masks.h"
#include "app/segment/sheet_prompts.h"
#include "app/store/segmentation.h"
#include "gaussians/base/error.h"
#include "gaussians/io/images/image_io.h"
#include "gaussians/reconstruct/training_photos.h"
#include "segmentation/field/islands.h"
#include "segmentation/field/known_labels.h"
#include "segmentation/field/semantic_field.h"
#include "segmentation/labels/mask_layouts.h"
#include "segmentation/select/selection.h"
#include "segmentation/sheets/selection_sheet.h"

namespace pliant {
using nlohmann::json;

namespace {

/// What the gestures in `cameras` select [N]; writes selection.png, from `sides` when there are some.
std::vector<uint8_t> gesture_members(const Context& context, const RunDirectory& run, const Scene& scene,
                                     const Gesture& gesture, const std::vector<Camera>& cameras,
                                     const std::optional<SelectionShape>& shape, std::vector<Camera> sides) {
  const GestureOptions options = gesture_options(context, scene);
  context.progress.say(fmt::format("segment: selecting by {} boxes and {} strokes and clicks", gesture.boxes.size(),
                                   gesture.strokes.size()));
  const GestureResult result =
      select_by_gesture(options, gesture, shape, scene.cloud, cameras, prepared_scene(context, run, scene));
  context.progress.say("segment: " + result.summary.describe() + fmt::format(" ({:.1f} s)", result.summary.seconds));
  for (const std::string& warning : result.summary.warnings) context.progress.warn(warning);
  std::vector<uint8_t> member(scene.cloud.size());
  std::vector<int> selected;
  for (size_t p = 0; p < member.size(); ++p)
    if ((member[p] = result.selected(p))) selected.push_back(static_cast<int>(p));
  if (sides.empty()) {
    sides = sheet_sides(scene.cloud.select(selected), scene.up);
    for (size_t k = 0; k < sides.size(); ++k) sides[k].name = fmt::format("selection.png:{}", k);
  }
  write_image(run / "selection.png", selection_sheet(result, scene.cloud, sides, options.render));
  write_selection_cells(run, sides);
  return member;
}

/// Whether the objects are those of the scene file's masks.
bool has_own_masks(const Scene& scene, const SegmentStage& stage, ObjectSource source) {
  std::error_code ignored;
  return source == ObjectSource::kMasks && !labels_photos(stage) &&
         (stage.masks.empty() || std::filesystem::equivalent(stage.masks, scene.settings.masks, ignored));
}

/// The segmentation of a selection that `option` made.
Segmentation selected_object(const Context& context, const Scene& scene, const std::string& option,
                             const std::vector<uint8_t>& member) {
  if (std::count(member.begin(), member.end(), 0) == 0)
    context.progress.warn(
        fmt::format("{} contains all {} Gaussians: the whole scene is the object and nothing is left as background",
                    option, member.size()));
  return segmentation_of_members(option, member, scene.cloud, scene.cameras, scene.report.antialiased);
}

/// What a joint training found out about the Gaussians of `scene`.
Segmentation joint_segmentation(const std::filesystem::path& file, const Scene& scene) {
  Segmentation segmentation = read_segmentation(file);
  if (segmentation.label.size() != scene.cloud.size())
    throw input_error(file.string(), "label",
                      fmt::format("has {} rows for {} Gaussians", segmentation.label.size(), scene.cloud.size()),
                      "delete it and run.json next to it, and repeat the command");
  segmentation.antialiased = scene.report.antialiased;
  return segmentation;
}

SemanticOptions semantic_options(const StageInputs<SegmentStage>& in, uint64_t seed) {
  const SegmentStage& stage = in.options;
  SemanticOptions options;
  options.start_from_vote = stage.start_from_vote;
  if (!stage.start_from_vote) options.kl_weight = 2.0;  // what no mask tells comes from neighbours alone
  if (stage.iterations) options.iterations = *stage.iterations;
  options.seed = seed;
  options.render.antialiased = in.scene.report.antialiased;
  options.trained_on_views = !in.scene.cameras_are_orbit;
  options.held_out = in.found.value("held_out", std::vector<int>());
  return options;
}

json segment_scene(const Context& context, RunDirectory& run, const StageInputs<SegmentStage>& in,
                   const std::vector<Camera>& sides, const std::string& provenance) {
  const SegmentStage& stage = in.options;
  const Scene& scene = in.scene;
  const ObjectSource source = source_of(scene, stage);
  const SemanticOptions options = semantic_options(in, context.seed);
  const std::optional<SelectionShape> selection = selection_of(stage);
  const std::vector<Camera> gesture_cameras = with_sides(stage, sides, scene.cameras);
  const Gesture gesture = gesture_of(stage, gesture_cameras);

  SemanticResult result;
  AutomaticResult found;
  bool ids_hold = true;
  Segmentation& segmentation = result.segmentation;
  const auto fit_to = [&](const MaskSet& masks) {
    for (const std::string& warning : masks.warnings) context.progress.warn(warning);
    context.progress.begin("segment", options.iterations);
    result = fit_semantic_field(options, scene.cloud, scene.cameras, masks, [&](int done, int, double) {
      stop_if_interrupted(context, "segment");
      if (done > 0) context.progress.done(done);
    });
    context.progress.end();
    if (source != ObjectSource::kMasks || !stage.mask_zero.empty()) return;
    // Masks that were made from the photos are all that was found there.
    const double unlabelled = labels_photos(stage) ? 0 : result.summary.unlabelled;
    if (const std::string warning = warning_of_zero(segmentation.class_name, unlabelled); !warning.empty())
      context.progress.warn(warning);
  };
  switch (source) {
    case ObjectSource::kAutomatic:
      found = find_automatically(context, scene, options.held_out);
      segmentation = segmentation_of_labels(found.label, names_of(found.found), scene.cloud, scene.cameras,
                                            context.seed, scene.report.antialiased);
      break;
    case ObjectSource::kConfiguration:
      segmentation = selected_object(context, scene, "--physgaussian",
                                     physgaussian_members(read_physgaussian_config(stage.physgaussian), scene.cloud));
      break;
    case ObjectSource::kPointFiles:
      segmentation =
          selected_object(context, scene, "clean_object_points.ply",
                          physdreamer_roles({}, physdreamer_folder(scene).value(), scene.cloud.position).object);
      break;
    case ObjectSource::kGesture:
      segmentation = selected_object(context, scene, gesture.boxes.empty() ? "--click" : "--box",
                                     gesture_members(context, run, scene, gesture, gesture_cameras, selection, sides));
      break;
    case ObjectSource::kShape:
      segmentation = selected_object(context, scene, selection->sphere ? "--sphere" : "--aabb",
                                     shape_members(*selection, scene.cloud));
      break;
    case ObjectSource::kJoint:
      segmentation = joint_segmentation(in.files.at("joint"), scene);
      break;
    case ObjectSource::kGrouping:
      segmentation = grouping_objects(scene, in.files.at("gaussian_grouping"), scene.settings.labels);
      break;
    case ObjectSource::kSegmenter:
      fit_to(prompted_masks(context, run, scene, gesture, stage.label.models));
      break;
    case ObjectSource::kMasks: {
      const AssociatedMasks masks = associated_masks(context, scene, stage, options, in.files.at("masks"));
      ids_hold = masks.ids_hold;
      fit_to(masks.masks);
      break;
    }
  }
  // Labels that are known are taken as they are.
  const size_t merged = learns_from_masks(source) ? merge_islands({}, scene.cloud, segmentation) : 0;
  if (merged > 0)
    context.progress.say(
        fmt::format("segment: {} Gaussians in small components were given the label of their surroundings", merged));
  tell_how_found(found.found, segmentation);
  const std::vector<ObjectEntry> objects =
      write_objects(context, run, scene, origin_of(stage, source), provenance, segmentation,
                    [&](json& rows) { tell_kinds(found.found, rows); });
  run.set_note("edits", {});
  write_held_out(run, scene, options.held_out, segmentation);
  for (const ObjectEntry& object : objects)
    context.progress.say(fmt::format("segment: {:>4} {:<16} {:>8} Gaussians, confidence {:.2f}", object.id, object.name,
                                     object.gaussians, object.score));
  return {{"automatic", source == ObjectSource::kAutomatic},
          {"selected", selects_one_object(source)},
          {"labelled", source == ObjectSource::kMasks && labels_photos(stage)},
          {"own_masks", has_own_masks(scene, stage, source)},
          {"ids_hold", ids_hold},
          {"objects", objects.size()},
          {"unseen", result.summary.unseen},
          {"cross_entropy", result.summary.cross_entropy},
          {"grouping", result.summary.grouping},
          {"views", result.summary.views},
          {"screen_variance", segmentation.screen_variance},
          {"merged_islands", merged}};
}

}  // namespace

Gesture gesture_of(const SegmentStage& stage, const std::vector<Camera>& cameras) {
  Gesture gesture;
  const float width = static_cast<float>(stage.stroke_width);
  for (const std::string& text : stage.boxes) add_box(text, cameras, gesture);
  for (const std::string& text : stage.clicks) add_click(text, cameras, width, gesture);
  for (const std::string& text : stage.strokes) add_stroke(text, cameras, width, gesture);
  gesture.grow = stage.grow;
  return gesture;
}

std::vector<int> held_out_cameras(const std::vector<Camera>& cameras) {
  std::vector<int> order(cameras.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return cameras[a].name < cameras[b].name; });
  std::vector<int> held_out;
  for (size_t i = 0; i < order.size(); i += PhotoOptions().hold_out_every) held_out.push_back(order[i]);
  std::sort(held_out.begin(), held_out.end());
  return held_out;
}

StageInputs<SegmentStage> inputs_of(const RunDirectory& run, const Scene& scene, const SegmentStage& stage,
                                    const std::vector<Camera>& sides) {
  check_networks(stage);
  const ObjectSource source = source_of(scene, stage);
  check_object_options(source, stage);
  StageInputs<SegmentStage> in;
  in.options = stage;
  in.parts = {ScenePart::kSplats, ScenePart::kCameras, ScenePart::kPhotos, ScenePart::kUp};
  in.outputs = {"segmentation.h5", "objects.json", "objects.png", "features.png"};
  in.found["automatic"] = source == ObjectSource::kAutomatic;
  std::vector<int> held_out = stage.hold_out ? held_out_cameras(scene.cameras) : std::vector<int>();
  switch (source) {
    case ObjectSource::kMasks:
      in.parts.insert({ScenePart::kMasks, ScenePart::kLabels});
      in.files["masks"] = labels_photos(stage)  ? run / "labelled"
                          : stage.masks.empty() ? scene.settings.masks
                                                : std::filesystem::path(stage.masks);
      if (const std::set<std::string> trained = trained_photos(in.files["masks"]); !trained.empty())
        in.found["images_train"] = trained;
      break;
    case ObjectSource::kJoint:
      in.files["joint"] = scene.source / "segmentation.h5";
      break;
    case ObjectSource::kGrouping:
      in.parts.insert(ScenePart::kLabels);
      in.files["gaussian_grouping"] = grouping_classifier_file(stage.gaussian_grouping);
      break;
    case ObjectSource::kPointFiles:
      in.parts.insert(ScenePart::kFolder);
      break;
    case ObjectSource::kSegmenter: {
      if (!sides.empty())
        throw usage_error("--segmenter", stage.label.models.segmenter,
                          "needs prompts on photos, and one is on selection.png",
                          "mark the object in photos or on objects.png");
      add_files(stage.label.models, in.files);
      const std::vector<int> marked = marked_cameras(gesture_of(stage, scene.cameras));
      std::erase_if(held_out, [&](int c) { return std::count(marked.begin(), marked.end(), c) > 0; });
      for (const int c : marked) in.outputs.push_back("prompted/" + scene.cameras[c].name + ".jpg");
      break;
    }
    case ObjectSource::kGesture:
      gesture_of(stage, with_sides(stage, sides, scene.cameras));
      in.outputs.insert(in.outputs.end(), {"selection.png", "selection_sheet.json"});
      if (!sides.empty()) in.found["stroke_sides"] = sides_json(sides);
      break;
    default:
      break;
  }
  in.scene = only(in.parts, scene);
  in.found["held_out"] = held_out;
  for (const int camera : held_out) in.outputs.push_back("held_out/" + scene.cameras[camera].name + ".png");
  if (!run.note("edits").empty() || (has_gestures(stage) && has_learned_objects(run)))
    in.kept = {"segmentation.h5", "objects.json", "objects.png"};
  return in;
}

json run_segment(const Context& context, RunDirectory& run, const Scene& scene, const SegmentStage& given) {
  const auto [stage, sides] = with_sheet_prompts(context, run, given);
  check_networks(stage);
  if (source_of(scene, stage) == ObjectSource::kMasks && labels_photos(stage))
    run_label(context, run, scene, stage.label);
  const StageInputs<SegmentStage> in = inputs_of(run, scene, stage, sides);
  if (in.found["automatic"] && !stage.automatic)
    context.progress.say(
        "segment: the scene has no masks and nothing is selected: free-standing objects are found automatically");
  if (const json edits = run.note("edits"); !edits.empty() && context.overwrite) {
    run.forget("segment");
    context.progress.say(fmt::format("segment: {} manual edits are discarded", edits.size()));
  }
  // Only what a person has edited, or marks replace, is kept, whatever the result before it kept of its predecessor.
  Context replacing = context;
  replacing.overwrite = context.overwrite || in.kept.empty();
  const json summary = run.stage(replacing, key_of(in), [&](const std::string& provenance) {
    return segment_scene(context, run, in, sides, provenance);
  });
  if (const json edits = run.note("edits"); !edits.empty())
    context.progress.say(fmt::format("segment: {} manual edits are kept; --overwrite discards them", edits.size()));
  return summary;
}

}  // namespace pliant

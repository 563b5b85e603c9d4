#include <fmt/format.h>

#include "app/import/physgaussian_space.h"
#include "app/pipeline/automatic_masks.h"
#include "app/pipeline/photos.h"
#include "app/pipeline/stages.h"
#include "app/store/segmentation.h"
#include "gaussians/base/error.h"
#include "gaussians/io/files.h"
#include "gaussians/io/image_io.h"
#include "segmentation/lift/associate.h"
#include "segmentation/lift/islands.h"
#include "segmentation/lift/objects_sheet.h"
#include "segmentation/lift/selection.h"
#include "segmentation/lift/selection_sheet.h"
#include "segmentation/lift/semantic_field.h"

namespace pliant {
using nlohmann::json;

namespace {

std::optional<SelectionShape> selection_of(const SegmentStage& stage) {
  if (!stage.aabb.empty() && !stage.sphere.empty())
    throw usage_error("--sphere", "", "was given together with --aabb", "give one of them");
  if (!stage.aabb.empty()) return SelectionShape::from_aabb(stage.aabb);
  if (!stage.sphere.empty()) return SelectionShape::from_sphere(stage.sphere);
  return std::nullopt;
}

Gesture gesture_of(const SegmentStage& stage, const std::vector<Camera>& cameras) {
  Gesture gesture;
  const float width = static_cast<float>(stage.stroke_width);
  for (const std::string& text : stage.boxes) add_box(text, cameras, gesture);
  for (const std::string& text : stage.clicks) add_click(text, cameras, width, gesture);
  for (const std::string& text : stage.strokes) add_stroke(text, cameras, width, gesture);
  return gesture;
}

json box_to_json(const Box& box) {
  return {{"low", {box.low.x(), box.low.y(), box.low.z()}}, {"high", {box.high.x(), box.high.y(), box.high.z()}}};
}

json objects_json(const std::vector<ObjectEntry>& objects, double metres_per_unit) {
  json rows = json::array();
  for (const ObjectEntry& object : objects) {
    Box metres{object.bounds.low * static_cast<float>(metres_per_unit), object.bounds.high * static_cast<float>(metres_per_unit)};
    rows.push_back({{"id", object.id}, {"name", object.name}, {"score", object.score}, {"gaussians", object.gaussians},
                    {"views", object.views}, {"bounds", box_to_json(object.bounds)}, {"bounds_m", box_to_json(metres)}});
  }
  return rows;
}

/// Masks of what the gestures select, which `member` [N] tells; writes selection.png.
MaskSet gesture_masks(const Context& context, const RunDirectory& run, const Scene& scene, const Gesture& gesture,
                      const std::optional<SelectionShape>& shape, std::vector<uint8_t>& member) {
  GestureOptions options;
  options.seed = context.seed, options.up = scene.up.cast<float>();
  options.render.antialiased = scene.report.antialiased;
  context.progress.say(fmt::format("segment: selecting by {} boxes and {} strokes and clicks", gesture.boxes.size(), gesture.strokes.size()));
  const GestureResult result = select_by_gesture(options, gesture, shape, scene.cloud, scene.cameras);
  context.progress.say("segment: " + result.summary.describe() + fmt::format(" ({:.1f} s)", result.summary.seconds));
  for (const std::string& warning : result.summary.warnings) context.progress.warn(warning);
  write_image(run / "selection.png", selection_sheet(result, scene.cloud, scene.up, options.render));
  member.resize(scene.cloud.size());
  for (size_t p = 0; p < member.size(); ++p) member[p] = result.selected(p);
  return member_masks(gesture.boxes.empty() ? "--click" : "--box", member, scene.cloud, scene.cameras);
}

/// Masks whose ids hold in all views.
MaskSet associated_masks(const Context& context, const Scene& scene, const SegmentStage& stage, const SemanticOptions& semantic,
                         MaskSet masks) {
  if (stage.associate == "never") return masks;
  AssociateOptions options;
  options.held_out = semantic.held_out, options.footprint.render = semantic.render;
  if (stage.associate == "auto") options.keep_above = 0.75;
  AssociateResult result = associate(options, scene.cloud, scene.cameras, masks);
  if (result.summary.associated) context.progress.say("segment: association: " + result.summary.describe());
  return std::move(result.masks);
}

/// held_out/<camera>.png of the cameras that were not learnt from.
void write_held_out(const RunDirectory& run, const Scene& scene, const SemanticOptions& options, const Segmentation& segmentation) {
  if (!options.held_out.empty()) std::filesystem::create_directories(run / "held_out");
  for (int camera : options.held_out)
    write_ids(run / "held_out" / (scene.cameras[camera].name + ".png"), render_ids(segmentation, scene.cloud, scene.cameras[camera]));
}

/// What a joint training found out about the Gaussians of `scene`.
Segmentation joint_segmentation(const std::filesystem::path& file, const Scene& scene) {
  Segmentation segmentation = read_segmentation(file);
  if (segmentation.label.size() != scene.cloud.size())
    throw input_error(file.string(), "label", fmt::format("has {} rows for {} Gaussians", segmentation.label.size(), scene.cloud.size()),
                      "repeat the command with --overwrite");
  return segmentation;
}

}  // namespace

json run_segment(const Context& context, RunDirectory& run, const Scene& scene, const SegmentStage& stage) {
  const std::optional<SelectionShape> selection = selection_of(stage);
  const Gesture gesture = gesture_of(stage, scene.cameras);
  const bool configured = !stage.physgaussian.empty();
  if (configured && (selection || !gesture.empty()))
    throw usage_error("--physgaussian", stage.physgaussian, "was given together with a selection", "its sim_area selects the object");
  const bool selecting = selection || !gesture.empty() || configured;
  if (stage.joint && selecting)
    throw usage_error("--joint", "", "was given together with a selection", "joint training needs masks; give --masks FOLDER");
  const std::filesystem::path masks_folder = stage.masks.empty() ? scene.settings.masks : std::filesystem::path(stage.masks);
  const bool automatic = segments_automatically(stage, selecting, !masks_folder.empty());
  if (automatic && !stage.automatic)
    context.progress.say("segment: the scene has no masks and nothing is selected: free-standing objects are found automatically");

  SemanticOptions options;
  options.start_from_vote = stage.start_from_vote;
  if (!stage.start_from_vote) options.kl_weight = 2.0;  // what no mask tells comes from neighbours alone
  if (stage.iterations) options.iterations = *stage.iterations;
  options.seed = context.seed;
  options.render.antialiased = scene.report.antialiased;
  if (stage.hold_out)
    for (int c = 0; c < static_cast<int>(scene.cameras.size()); c += 8) options.held_out.push_back(c);

  StageKey key{"segment",
               {{"aabb", stage.aabb}, {"sphere", stage.sphere}, {"box", stage.boxes}, {"click", stage.clicks},
                {"stroke", stage.strokes}, {"stroke_width", stage.stroke_width}, {"vote", stage.start_from_vote}, {"associate", stage.associate},
                {"iterations", options.iterations}, {"held_out", options.held_out},
                {"up", {scene.up.x(), scene.up.y(), scene.up.z()}}, {"metres_per_unit", scene.metres_per_unit}},
               {{"splats", scene.settings.splats}},
               {"segmentation.h5", "objects.json", "objects.png"}};
  for (const std::filesystem::path& file : scene.report.files) {
    const auto name = file.lexically_proximate(scene.settings.splats.parent_path());
    if (file != scene.settings.splats) key.inputs["splats " + name.string()] = file;
  }
  if (!scene.settings.cameras.empty()) key.inputs["cameras"] = scene.settings.cameras;
  const std::filesystem::path trained = scene.source / "segmentation.h5";
  if (stage.joint) key.inputs["joint"] = trained;
  else if (automatic) key.options["automatic"] = true;
  else if (!selecting) key.inputs["masks"] = masks_folder;
  if (configured) key.inputs["physgaussian"] = stage.physgaussian;
  if (!gesture.empty()) key.outputs.push_back("selection.png");
  for (int camera : options.held_out) key.outputs.push_back("held_out/" + scene.cameras[camera].name + ".png");

  return run.stage(context, key, [&]() -> json {
    std::vector<uint8_t> member;  // of a selection by gesture or configuration
    if (configured) member = physgaussian_members(read_physgaussian_config(stage.physgaussian), scene.cloud);
    SemanticResult result;
    AutomaticResult found;
    Segmentation& segmentation = result.segmentation;
    if (stage.joint) {
      segmentation = joint_segmentation(trained, scene);
    } else {
      if (automatic) found = automatic_masks(context, scene, options.held_out);
      const MaskSet masks = automatic          ? std::move(found.masks)
                            : configured       ? member_masks("--physgaussian", member, scene.cloud, scene.cameras)
                            : !gesture.empty() ? gesture_masks(context, run, scene, gesture, selection, member)
                            : selection      ? selection_masks(*selection, scene.cloud, scene.cameras)
                                             : associated_masks(context, scene, stage, options,
                                                                load_masks(masks_folder, scene.settings.labels, scene.cameras));
      for (const std::string& warning : masks.warnings) context.progress.warn(warning);
      context.progress.begin("segment", options.iterations);
      result = fit_semantic_field(options, scene.cloud, scene.cameras, masks, [&](int done, int, double) { context.progress.done(done); });
      context.progress.end();
    }
    const size_t merged = merge_islands({}, scene.cloud, segmentation);
    if (merged > 0) context.progress.say(fmt::format("segment: {} Gaussians in small islands took the label around them", merged));
    size_t restricted = 0;
    if (selecting) {
      restricted = !member.empty() ? restrict_to_members(member, segmentation) : restrict_to_selection(*selection, scene.cloud, segmentation);
      if (restricted > 0)
        context.progress.say(fmt::format("segment: {} Gaussians outside the selection were given back to the rest", restricted));
    }
    const std::vector<ObjectEntry> objects = list_objects(segmentation, scene.cloud.position);
    write_segmentation(run / "segmentation.h5", segmentation, run.provenance(context, key));
    json rows = objects_json(objects, scene.metres_per_unit);
    tell_how_found(found.found, rows);
    write_text(run / "objects.json", rows.dump(2) + "\n");
    write_image(run / "objects.png", objects_sheet(segmentation, scene.cloud, scene.cameras,
                                                   [&](int camera) { return photo_or_render(scene, camera); }));
    write_held_out(run, scene, options, segmentation);
    for (const ObjectEntry& object : objects)
      context.progress.say(fmt::format("segment: {:>4} {:<16} {:>8} Gaussians, confidence {:.2f}", object.id, object.name,
                                       object.gaussians, object.score));
    return {{"automatic", automatic}, {"objects", objects.size()}, {"unseen", result.summary.unseen}, {"cross_entropy", result.summary.cross_entropy},
            {"grouping", result.summary.grouping}, {"views", result.summary.views}, {"merged_islands", merged}, {"outside_selection", restricted}};
  });
}

}  // namespace pliant

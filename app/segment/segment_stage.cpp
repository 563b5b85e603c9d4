#include "app/segment/segment_stage.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "app/import/gaussian_grouping.h"
#include "app/import/physgaussian_space.h"
#include "app/run/physdreamer_scene.h"
#include "app/segment/automatic_masks.h"
#include "app/segment/grouping_objects.h"
#include "app/segment/label_choice.h"
#include "app/segment/objects_file.h"
#include "app/segment/prompted_masks.h"
#include "app/segment/sheet_prompts.h"
#include "app/store/segmentation.h"
#include "gaussians/base/error.h"
#include "gaussians/io/images/image_io.h"
#include "segmentation/associate/associate.h"
#include "segmentation/field/islands.h"
#include "segmentation/field/semantic_field.h"
#include "segmentation/labelling/label_set.h"
#include "segmentation/select/selection.h"
#include "segmentation/sheets/selection_sheet.h"

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

/// Masks of what the gestures in `cameras` select, which `member` [N] tells; writes selection.png, from `sides` when
/// there are some.
MaskSet gesture_masks(const Context& context, const RunDirectory& run, const Scene& scene, const Gesture& gesture,
                      const std::vector<Camera>& cameras, const std::optional<SelectionShape>& shape,
                      std::vector<Camera> sides, std::vector<uint8_t>& member) {
  GestureOptions options;
  options.seed = context.seed;
  options.up = scene.up.cast<float>();
  options.render.antialiased = scene.report.antialiased;
  context.progress.say(fmt::format("segment: selecting by {} boxes and {} strokes and clicks", gesture.boxes.size(),
                                   gesture.strokes.size()));
  const GestureResult result = select_by_gesture(options, gesture, shape, scene.cloud, cameras);
  context.progress.say("segment: " + result.summary.describe() + fmt::format(" ({:.1f} s)", result.summary.seconds));
  for (const std::string& warning : result.summary.warnings) context.progress.warn(warning);
  member.resize(scene.cloud.size());
  std::vector<int> selected;
  for (size_t p = 0; p < member.size(); ++p)
    if ((member[p] = result.selected(p))) selected.push_back(static_cast<int>(p));
  if (sides.empty()) {
    sides = sheet_sides(scene.cloud.select(selected), scene.up);
    for (size_t k = 0; k < sides.size(); ++k) sides[k].name = fmt::format("selection.png:{}", k);
  }
  write_image(run / "selection.png", selection_sheet(result, scene.cloud, sides, options.render));
  write_selection_cells(run, sides);
  return member_masks(gesture.boxes.empty() ? "--click" : "--box", member, scene.cloud, scene.cameras);
}

/// Masks whose ids hold in all views.
MaskSet associated_masks(const Context& context, const Scene& scene, const SegmentStage& stage,
                         const SemanticOptions& semantic, const std::filesystem::path& folder) {
  // Names that lie beside the masks are those of things in single photos, as `label` writes them.
  const bool labelled = std::filesystem::exists(folder / "labels.json");
  MaskSet masks = load_masks(folder, labelled ? folder / "labels.json" : scene.settings.labels, scene.cameras);
  if (stage.zero_is_background) label_background(masks);
  if (stage.associate == "never" || stage.label.track) return masks;
  AssociateOptions options;
  options.held_out = semantic.held_out;
  options.footprint.render = semantic.render;
  if (stage.associate == "auto" && !labelled) options.keep_above = 0.75;
  const MaskSet as_labelled = masks;
  const uint32_t rest = labelled ? take_out_rest(masks) : 0;
  AssociateResult result = associate(options, scene.cloud, scene.cameras, masks);
  if (result.summary.associated) context.progress.say("segment: association: " + result.summary.describe());
  if (labelled) result.masks.names = carried_names(masks, result.masks);
  if (rest != 0) put_back_rest(as_labelled, rest, result.masks);
  return std::move(result.masks);
}

/// How the objects are found, for objects.json.
std::string origin_of(const SegmentStage& stage, bool by_roles) {
  std::string how = by_roles ? "PhysDreamer's point files" : "";
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

/// held_out/<camera>.png of the cameras that were not learnt from.
void write_held_out(const RunDirectory& run, const Scene& scene, const SemanticOptions& options,
                    const Segmentation& segmentation) {
  if (!options.held_out.empty()) std::filesystem::create_directories(run / "held_out");
  for (int camera : options.held_out)
    write_ids(run / "held_out" / (scene.cameras[camera].name + ".png"),
              render_ids(segmentation, scene.cloud, scene.cameras[camera]));
}

/// What a joint training found out about the Gaussians of `scene`.
Segmentation joint_segmentation(const std::filesystem::path& file, const Scene& scene) {
  Segmentation segmentation = read_segmentation(file);
  if (segmentation.label.size() != scene.cloud.size())
    throw input_error(file.string(), "label",
                      fmt::format("has {} rows for {} Gaussians", segmentation.label.size(), scene.cloud.size()),
                      "repeat the command with --overwrite");
  return segmentation;
}

}  // namespace

json run_segment(const Context& context, RunDirectory& run, const Scene& scene, const SegmentStage& given) {
  const SheetPrompts prompts = with_sheet_prompts(context, run, given);
  const SegmentStage& stage = prompts.stage;
  const std::optional<SelectionShape> selection = selection_of(stage);
  const std::vector<Camera> gesture_cameras = prompts.with_sides(scene.cameras);
  const Gesture gesture = gesture_of(stage, gesture_cameras);
  const bool configured = !stage.physgaussian.empty();
  if (configured && (selection || !gesture.empty()))
    throw usage_error("--physgaussian", stage.physgaussian, "was given together with a selection",
                      "its sim_area selects the object");
  const bool grouping = !stage.gaussian_grouping.empty();
  check_networks(stage);
  const bool labelling = labels_photos(stage), prompted = prompts_segmenter(stage);
  const bool asked = selection || !gesture.empty() || configured || grouping || stage.automatic || stage.joint ||
                     !stage.masks.empty() || labelling;
  const std::optional<PhysDreamerFolder> roles = asked ? std::nullopt : physdreamer_folder(scene);
  const bool by_roles = roles.has_value();
  const bool selecting = selection || !gesture.empty() || configured || by_roles;
  if (stage.joint && selecting)
    throw usage_error("--joint", "", "was given together with a selection",
                      "joint training needs masks; give --masks FOLDER");
  if (grouping && (selecting || stage.joint || !stage.masks.empty()))
    throw usage_error("--gaussian-grouping", stage.gaussian_grouping, "was given together with masks or a selection",
                      "its classifier says what the objects are");
  if (labelling && (selecting || grouping || stage.automatic || stage.joint || !stage.masks.empty())) {
    const TypedOption typed = labelling_option(stage.label);
    throw usage_error(typed.name, typed.value,
                      "was given together with --masks, --auto, --joint, --gaussian-grouping or a selection",
                      "leave one of them out: it makes masks of the photos");
  }
  if (prompted && !prompts.sides.empty())
    throw usage_error("--segmenter", stage.label.models.segmenter, "looks at photos, and a gesture is on selection.png",
                      "mark the object in photos or on objects.png");
  if (labelling) run_label(context, run, scene, stage.label);
  const std::filesystem::path masks_folder = labelling             ? run / "labelled"
                                             : stage.masks.empty() ? scene.settings.masks
                                                                   : std::filesystem::path(stage.masks);
  const bool automatic = !grouping && segments_automatically(stage, selecting, !masks_folder.empty());
  if (automatic && !stage.automatic)
    context.progress.say(
        "segment: the scene has no masks and nothing is selected: free-standing objects are found automatically");

  SemanticOptions options;
  options.start_from_vote = stage.start_from_vote;
  if (!stage.start_from_vote) options.kl_weight = 2.0;  // what no mask tells comes from neighbours alone
  if (stage.iterations) options.iterations = *stage.iterations;
  options.seed = context.seed;
  options.render.antialiased = scene.report.antialiased;
  options.trained_on_views = !scene.cameras_are_orbit;
  if (stage.hold_out)
    for (int c = 0; c < static_cast<int>(scene.cameras.size()); c += 8) options.held_out.push_back(c);
  const std::vector<int> marked = prompted ? marked_cameras(gesture) : std::vector<int>();
  std::erase_if(options.held_out, [&](int c) { return std::count(marked.begin(), marked.end(), c) > 0; });

  StageKey key{"segment",
               {{"aabb", stage.aabb},
                {"sphere", stage.sphere},
                {"box", stage.boxes},
                {"click", stage.clicks},
                {"stroke", stage.strokes},
                {"stroke_width", stage.stroke_width},
                {"vote", stage.start_from_vote},
                {"associate", stage.associate},
                {"iterations", options.iterations},
                {"held_out", options.held_out},
                {"up", {scene.up.x(), scene.up.y(), scene.up.z()}},
                {"metres_per_unit", scene.metres_per_unit}},
               {{"splats", scene.settings.splats}},
               {"segmentation.h5", "objects.json", "objects.png", "features.png"}};
  for (const std::filesystem::path& file : scene.report.files) {
    const auto name = file.lexically_proximate(scene.settings.splats.parent_path());
    if (file != scene.settings.splats) key.inputs["splats " + name.string()] = file;
  }
  if (!scene.settings.cameras.empty()) key.inputs["cameras"] = scene.settings.cameras;
  const std::filesystem::path trained = scene.source / "segmentation.h5";
  if (stage.joint)
    key.inputs["joint"] = trained;
  else if (grouping)
    key.inputs["gaussian_grouping"] = grouping_classifier_file(stage.gaussian_grouping);
  else if (automatic)
    key.options["automatic"] = true;
  else if (!selecting)
    key.inputs["masks"] = masks_folder;
  const bool reads_names = grouping || key.inputs.count("masks");
  if (reads_names && !scene.settings.labels.empty()) key.inputs["labels"] = scene.settings.labels;
  if (prompted) add_inputs(stage.label.models, key);
  for (const int c : marked) {
    if (!scene.cameras[c].photo.empty()) key.inputs["photo " + scene.cameras[c].name] = scene.cameras[c].photo;
    key.outputs.push_back("prompted/" + scene.cameras[c].name + ".jpg");
  }
  if (stage.zero_is_background) key.options["zero"] = "background";
  if (configured) key.inputs["physgaussian"] = stage.physgaussian;
  if (by_roles) key.inputs["object_points"] = scene.source / "clean_object_points.ply";
  if (!prompts.sides.empty()) key.options["stroke_sides"] = prompts.sides_json();
  if (!gesture.empty() && !prompted) key.outputs.push_back("selection.png");
  for (int camera : options.held_out) key.outputs.push_back("held_out/" + scene.cameras[camera].name + ".png");

  if (const json edits = run.note("edits"); !edits.empty()) {
    if (context.overwrite) run.forget("segment");
    context.progress.say(
        context.overwrite ? fmt::format("segment: {} edits by hand are undone", edits.size())
                          : fmt::format("segment: {} edits by hand are kept, --overwrite undoes them", edits.size()));
  }
  return run.stage(context, key, [&]() -> json {
    std::vector<uint8_t> member;  // of a selection by gesture or configuration
    if (configured) member = physgaussian_members(read_physgaussian_config(stage.physgaussian), scene.cloud);
    if (by_roles) member = physdreamer_roles({}, *roles, scene.cloud.position).object;
    SemanticResult result;
    AutomaticResult found;
    Segmentation& segmentation = result.segmentation;
    if (stage.joint) {
      segmentation = joint_segmentation(trained, scene);
    } else if (grouping) {
      segmentation = grouping_objects(scene, key.inputs["gaussian_grouping"], scene.settings.labels);
    } else {
      if (automatic) found = automatic_masks(context, scene, options.held_out);
      const MaskSet masks = automatic    ? std::move(found.masks)
                            : configured ? member_masks("--physgaussian", member, scene.cloud, scene.cameras)
                            : by_roles   ? member_masks("clean_object_points.ply", member, scene.cloud, scene.cameras)
                            : prompted   ? prompted_masks(context, run, scene, gesture, stage.label.models)
                            : !gesture.empty() ? gesture_masks(context, run, scene, gesture, gesture_cameras, selection,
                                                               prompts.sides, member)
                            : selection        ? selection_masks(*selection, scene.cloud, scene.cameras)
                                               : associated_masks(context, scene, stage, options, masks_folder);
      for (const std::string& warning : masks.warnings) context.progress.warn(warning);
      context.progress.begin("segment", options.iterations);
      result = fit_semantic_field(options, scene.cloud, scene.cameras, masks,
                                  [&](int done, int, double) { context.progress.done(done); });
      context.progress.end();
    }
    const size_t merged = grouping ? 0 : merge_islands({}, scene.cloud, segmentation);  // its result is taken as it is
    if (merged > 0)
      context.progress.say(fmt::format("segment: {} Gaussians in small islands took the label around them", merged));
    size_t restricted = 0;
    if (selecting) {
      if (!member.empty())
        restricted = restrict_to_members(member, segmentation);
      else if (selection)
        restricted = restrict_to_selection(*selection, scene.cloud, segmentation);
      if (restricted > 0)
        context.progress.say(
            fmt::format("segment: {} Gaussians outside the selection were given back to the rest", restricted));
    }
    tell_how_found(found.found, segmentation);
    if (!context.overwrite && !run.note("edits").empty())
      context.progress.warn("objects were found anew, edits by hand are undone");
    const std::vector<ObjectEntry> objects =
        write_objects(run, scene, origin_of(stage, by_roles), run.provenance(context, key), segmentation,
                      [&](json& rows) { tell_kinds(found.found, rows); });
    run.set_note("edits", {});
    write_held_out(run, scene, options, segmentation);
    for (const ObjectEntry& object : objects)
      context.progress.say(fmt::format("segment: {:>4} {:<16} {:>8} Gaussians, confidence {:.2f}", object.id,
                                       object.name, object.gaussians, object.score));
    return {{"automatic", automatic},
            {"objects", objects.size()},
            {"unseen", result.summary.unseen},
            {"cross_entropy", result.summary.cross_entropy},
            {"grouping", result.summary.grouping},
            {"views", result.summary.views},
            {"screen_variance", segmentation.screen_variance},
            {"merged_islands", merged},
            {"outside_selection", restricted}};
  });
}

}  // namespace pliant

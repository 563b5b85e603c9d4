#include "app/segment/extract_stage.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "app/segment/automatic_objects.h"
#include "app/segment/choose_object.h"
#include "app/segment/objects_file.h"
#include "app/segment/scene_file_names.h"
#include "app/store/segmentation.h"
#include "gaussians/base/error.h"
#include "gaussians/base/orbit.h"
#include "gaussians/base/portable.h"
#include "gaussians/io/files/json_file.h"
#include "gaussians/io/images/image_io.h"
#include "gaussians/io/splats/ply.h"
#include "segmentation/labels/object_names.h"
#include "segmentation/sheets/extract_sheet.h"

namespace pliant {
using nlohmann::json;

namespace {

/// The object to cut: that of --object, else the scene file's, else choose_object().
ChosenClass chosen_class(const Scene& scene, const Segmentation& segmentation, const std::string& wish,
                         const FileNames& file_names, const json& edits, const ObjectHints& hints) {
  if (!wish.empty()) return {class_of_object(segmentation, "--object", wish), "", false};
  const std::string named = present_name(file_names, edits, scene.settings.object);
  if (!named.empty() &&
      (file_names.reach >= FileNames::Reach::kTrained || !classes_called(segmentation, named).empty()))
    return {class_of_object(segmentation, scene.settings.file.string() + ": object", named), "", false};
  return choose_object(scene, segmentation, hints);
}

/// What every rule moved: number of Gaussians, how many of them no later rule moved again, and the share of the latter
/// in the candidates' opacity.
json rules_json(const ExtractResult& result) {
  std::array<size_t, kExtractRules> left = {};
  for (ExtractRule rule : result.rule) ++left[static_cast<int>(rule)];
  json rows = json::object();
  for (int k = 1; k < kExtractRules; ++k) {
    const ExtractRule rule = static_cast<ExtractRule>(k);
    rows[name_of(rule)] = {{"moved", result.summary.moved_by(rule)},
                           {"gaussians", left[k]},
                           {"opacity_share", result.summary.opacity_share[k]}};
  }
  return rows;
}

/// Height of the object along up, scene units: that of its Gaussians' centres, or where these lie level what the
/// Gaussians measure themselves.
double height_of(const GaussianCloud& object, const Vec3d& up) {
  constexpr double kReach = 4;      // standard deviations from end to end of a Gaussian
  constexpr double kLeast = 0.001;  // of the object's diagonal
  const Framing framing = robust_framing(object, up);
  const Vec3f vertical = up.normalized().cast<float>();
  std::vector<float> size(object.size()), opacity(object.size());
  for (size_t i = 0; i < object.size(); ++i) {
    const Vec3f scale = object.log_scale[i].array().exp();
    size[i] = (rotation_matrix<float>(object.rotation[i]).transpose() * vertical).cwiseProduct(scale).norm();
    opacity[i] = sigmoid(object.opacity_logit[i]);
  }
  const double height = std::max({framing.high.z() - framing.low.z(), kReach * weighted_percentile(size, opacity, 0.5),
                                  kLeast * framing.diagonal()});
  if (!(height > 0))
    throw usage_error("extract", "object", "has no extent", "choose one whose Gaussians have a size or lie apart");
  return height;
}

json vector_json(const Vec3f& v) { return {v.x(), v.y(), v.z()}; }

json extract_object(const Context& context, const RunDirectory& run, const StageInputs<ExtractStage>& in,
                    const std::string&) {
  const Scene& scene = in.scene;
  const Segmentation segmentation = read_segmentation(in.files.at("segmentation"));
  const uint32_t id = in.found["id"];
  const std::string name = in.found["name"], folder = folder_of_object(id, name);
  if (in.found.contains("chosen"))
    context.progress.say(
        fmt::format("extract: using '{}', {} (--object selects another)", name, in.found["chosen"].get<std::string>()));
  if (in.found.contains("label"))
    context.progress.warn(
        fmt::format("no object is called '{}': --label is taken for '{}'; if another is meant, select it with --object "
                    "(objects.png "
                    "shows them)",
                    in.found["label"].get<std::string>(), name));
  ExtractOptions options;
  options.object = id;
  options.probability = static_cast<float>(in.options.threshold);
  options.up = scene.up.cast<float>();
  options.hull = in.options.hull;
  if (in.found.contains("support")) options.support = in.found["support"].get<uint32_t>();
  if (in.found.contains("supports")) options.supports = in.found["supports"].get<std::vector<uint32_t>>();
  const ExtractResult result = extract(options, scene.cloud, segmentation);
  const GaussianCloud object = scene.cloud.select(result.object);
  std::filesystem::create_directories(run / folder);
  const ReadReport& report = scene.report;
  write_ply(run / (folder + "/object.ply"), object, report.antialiased, report.z_is_up);
  write_ply(run / "background.ply", scene.cloud.select(result.background), report.antialiased, report.z_is_up);

  RenderOptions render;
  render.antialiased = scene.report.antialiased;
  write_image(run / "extract.png", extract_sheet(result, scene.cloud, scene.up, render));

  const double height = height_of(object, scene.up);
  context.progress.say("extract: " + result.summary.describe());
  json summary = {{"id", id},
                  {"name", name},
                  {"folder", folder},
                  {"object_gaussians", result.object.size()},
                  {"background_gaussians", result.background.size()},
                  {"height", height},
                  {"candidates", result.summary.candidates},
                  {"dropped", result.summary.dropped},
                  {"rules", rules_json(result)}};
  if (in.found.contains("chosen")) summary["chosen"] = in.found["chosen"];
  if (result.contact.found) {
    std::string support = "support";
    for (size_t c = 0; c < segmentation.class_id.size(); ++c)
      if (result.summary.support == segmentation.class_id[c]) support = segmentation.class_name[c];
    summary["contact"] = {{"support", support},
                          {"point", vector_json(result.contact.point)},
                          {"normal", vector_json(result.contact.normal)},
                          {"band", result.contact.band_high}};
  }
  return summary;
}

}  // namespace

StageInputs<ExtractStage> inputs_of(const RunDirectory& run, const Scene& scene, const ExtractStage& stage) {
  const json segmented = run.summary("segment", "run `pliant segment SCENE --out DIR` first");
  const Segmentation segmentation = read_objects(run, scene);
  // The automatic mode knows what stands on what; its rest and its other objects carry nothing.
  const bool automatic = segmented.value("automatic", false);
  const std::vector<uint32_t> supports =
      automatic ? supports_among(read_json(run / "objects.json")) : std::vector<uint32_t>();
  const json edits = run.note("edits");
  const FileNames names = names_of_file(run, scene, segmented);
  const ChosenClass chosen = chosen_class(scene, segmentation, stage.object, names, edits, {stage.label, supports});
  const uint32_t id = segmentation.class_id[chosen.index];
  const std::string& name = segmentation.class_name[chosen.index];
  const std::string support = present_name(names, edits, scene.settings.support);
  const std::vector<size_t> carriers = classes_called(segmentation, support);
  const std::string field = scene.settings.file.string() + ": support";
  // A person may have dropped it.
  if (!support.empty() && carriers.empty() && names.reach == FileNames::Reach::kOwn && edits.empty())
    throw usage_error(field, support, "is not in this scene",
                      "name one of " + list_of_objects(segmentation) + ", or leave it out");
  if (carriers.size() > 1 && names.ids) class_of_object(segmentation, field, support);  // refuses it
  StageInputs<ExtractStage> in;
  in.options = stage;
  in.parts = {ScenePart::kSplats, ScenePart::kUp, ScenePart::kSupport};
  in.scene = only(in.parts, scene);
  in.files["segmentation"] = run / "segmentation.h5";
  in.found = {{"id", id}, {"name", name}};
  if (!chosen.why.empty()) in.found["chosen"] = chosen.why + "; of " + list_of_objects(segmentation);
  if (chosen.unnamed) in.found["label"] = stage.label;
  if (automatic) in.found["supports"] = supports;
  if (carriers.size() == 1) in.found["support"] = segmentation.class_id[carriers[0]];
  const std::string folder = folder_of_object(id, name);
  in.outputs = {folder + "/object.ply", "background.ply", "extract.png"};
  return in;
}

json run_extract(const Context& context, RunDirectory& run, const Scene& scene, const ExtractStage& stage) {
  return run_stage(context, run, inputs_of(run, scene, stage), extract_object);
}

OptionTable options_of(ExtractStage& stage) {
  return {"extract",
          {{.name = "object",
            .field = &stage.object,
            .help = "Object to cut (default: scene.json's, else the most prominent)",
            .value = "ID|NAME",
            .recorded = Recorded::kElsewhere},
           {.name = "threshold",
            .field = &stage.threshold,
            .help = "Minimum probability of the object's Gaussians",
            .low = 0,
            .high = 1},
           {.name = "hull",
            .field = &stage.hull,
            .help = "Assign Gaussians inside the object's convex hull, above its support, to the object"}}};
}

}  // namespace pliant

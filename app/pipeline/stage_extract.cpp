#include <fmt/format.h>

#include <algorithm>

#include "app/pipeline/stages.h"
#include "app/store/segmentation.h"
#include "gaussians/base/error.h"
#include "gaussians/base/orbit.h"
#include "gaussians/io/files.h"
#include "gaussians/io/ply.h"
#include "segmentation/lift/extract.h"

namespace pliant {
using nlohmann::json;

namespace {

/// Class of the object that the user means by id or name; without a wish the scene file's, else the only one.  What
/// a selection or the automatic mode (`automatic`) made of the rest of the scene counts only when it is asked for.
size_t chosen_class(const Segmentation& segmentation, const std::string& wish, std::string scene_default, bool automatic) {
  const std::vector<std::string>& names = segmentation.class_name;
  if (automatic && std::find(names.begin(), names.end(), scene_default) == names.end()) scene_default.clear();
  const std::string wanted = wish.empty() ? scene_default : wish;
  std::vector<size_t> candidates;
  std::string list;
  for (size_t c = 0; c < names.size(); ++c) {
    if (wanted == names[c] || wanted == std::to_string(segmentation.class_id[c])) return c;
    if (names[c] != "rest" && !(automatic && names[c].starts_with("support_"))) candidates.push_back(c);
    list += fmt::format("{}{} = {}", c ? ", " : "", segmentation.class_id[c], names[c]);
  }
  if (wanted.empty() && candidates.size() == 1) return candidates[0];
  if (wanted.empty()) throw usage_error("--object", "", "is needed: the scene has several objects", "choose one of " + list);
  throw usage_error("--object", wanted, "is not in this scene", "did you mean '" + nearest_name(wanted, names) + "'? There are " + list);
}

/// Name as part of a folder's name.
std::string folder_name(std::string name) {
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '-' && c != '_') c = '_';
  return name;
}

json vector_json(const Vec3f& v) { return {v.x(), v.y(), v.z()}; }

}  // namespace

json run_extract(const Context& context, RunDirectory& run, const Scene& scene, const ExtractStage& stage) {
  const json segmented = run.summary("segment", "run `pliant segment SCENE --out DIR` first");
  const Segmentation segmentation = read_segmentation(run / "segmentation.h5");
  if (segmentation.label.size() != scene.cloud.size())
    throw input_error((run / "segmentation.h5").string(), "label",
                      fmt::format("has {} rows, the scene {} Gaussians", segmentation.label.size(), scene.cloud.size()),
                      "segment the scene again with --overwrite");
  const size_t chosen = chosen_class(segmentation, stage.object, scene.settings.object, segmented.value("automatic", false));
  const uint32_t id = segmentation.class_id[chosen];
  const std::string name = segmentation.class_name[chosen];
  const std::string folder = fmt::format("objects/{}_{}", id, folder_name(name));

  const StageKey key{"extract",
                     {{"object", name}, {"id", id}, {"threshold", stage.threshold}},
                     {{"segmentation", run / "segmentation.h5"}},
                     {folder + "/object.ply", "background.ply"}};
  return run.stage(context, key, [&]() -> json {
    ExtractOptions options;
    options.object = id, options.probability = static_cast<float>(stage.threshold), options.up = scene.up.cast<float>();
    for (size_t c = 0; c < segmentation.class_id.size(); ++c)
      if (!scene.settings.support.empty() && segmentation.class_name[c] == scene.settings.support)
        options.support = segmentation.class_id[c];
    const ExtractResult result = extract(options, scene.cloud, segmentation);
    const GaussianCloud object = scene.cloud.select(result.object);
    std::filesystem::create_directories(run / folder);
    write_ply(run / (folder + "/object.ply"), object, scene.report.antialiased);
    write_ply(run / "background.ply", scene.cloud.select(result.background), scene.report.antialiased);

    const Framing framing = robust_framing(object, scene.up);
    const double height = framing.high.z() - framing.low.z();
    context.progress.say("extract: " + result.summary.describe());
    json summary = {{"id", id}, {"name", name}, {"folder", folder}, {"object_gaussians", result.object.size()},
                    {"background_gaussians", result.background.size()}, {"height", height},
                    {"candidates", result.summary.candidates}, {"below_probability", result.summary.below_probability},
                    {"outliers", result.summary.outliers}, {"floaters", result.summary.floaters},
                    {"dropped", result.summary.dropped}, {"contact_to_support", result.summary.contact_to_support},
                    {"contact_to_object", result.summary.contact_to_object},
                    {"enclosed", result.summary.enclosed}};
    if (result.contact.found) {
      std::string support = "support";
      for (size_t c = 0; c < segmentation.class_id.size(); ++c)
        if (segmentation.class_id[c] == result.summary.support) support = segmentation.class_name[c];
      summary["contact"] = {{"support", support}, {"point", vector_json(result.contact.point)},
                            {"normal", vector_json(result.contact.normal)}, {"band", result.contact.band_high}};
    }
    return summary;
  });
}

}  // namespace pliant

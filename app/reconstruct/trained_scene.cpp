#include "app/reconstruct/trained_scene.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <set>

#include "app/reconstruct/training_masks.h"
#include "gaussians/base/error.h"
#include "gaussians/io/cameras/cameras_json.h"
#include "gaussians/io/cameras/transforms.h"
#include "gaussians/io/files/json_file.h"
#include "gaussians/io/images/image_io.h"
#include "gaussians/io/splats/ply.h"

namespace pliant {
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr const char* kMaskNames = "mask_names.json";

/// Masks that belong to the photos as they were trained on.  Names that no file of labels tells go to kMaskNames in
/// `folder`.
void write_masks(const fs::path& folder, const TrainedScene& scene, json& out) {
  const SceneFile& settings = scene.set.settings;
  const fs::path beside = settings.masks / "labels.json";
  const bool labelled = fs::exists(beside);
  const fs::path labels = labelled ? beside : settings.labels;
  const MaskSet masks = training_masks(settings.masks, labels, scene.cameras, scene.photos);
  for (const MaskSet::View& view : masks.views)
    write_ids(folder / "masks" / (scene.photos.photos[view.camera].camera.name + ".png"), view.ids);
  out["masks"] = "masks";
  if (masks.names.empty() || (!labelled && !labels.empty() && masks.names == read_label_names(labels))) return;
  json names = json::object();
  for (const auto& [id, name] : masks.names) names[std::to_string(id)] = name;
  // Names of things in single photos, as `label` writes them, lie beside the masks.
  write_json(folder / (labelled ? "masks/labels.json" : kMaskNames), names);
  if (!labelled) out["labels"] = kMaskNames;
}

std::string path_from(const fs::path& folder, const fs::path& file) {
  return fs::relative(file, folder).generic_string();
}

}  // namespace

void refuse_own_source(const fs::path& folder, const PhotoSet& set, const ReconstructStage& stage) {
  static const std::set<std::string> made = {".",        "point_cloud",     "photos",       "masks",
                                             kMaskNames, "transforms.json", "cameras.json", "scene.json"};
  const std::pair<const char*, fs::path> sources[] = {{"cameras", set.cameras},
                                                      {"photos", set.photos},
                                                      {"masks", set.settings.masks},
                                                      {"masks", stage.masks},
                                                      {"splats", stage.splats}};
  for (const auto& [what, source] : sources) {
    if (source.empty()) continue;
    const fs::path within = fs::weakly_canonical(source).lexically_relative(fs::weakly_canonical(folder));
    if (!within.empty() && made.count(within.begin()->string()))
      throw usage_error("--out", folder.string(), fmt::format("contains the {} to train on", what),
                        "give another folder");
  }
}

std::vector<std::string> write_trained_scene(const fs::path& folder, const TrainedScene& scene) {
  std::vector<std::string> lost;
  const SceneFile& settings = scene.set.settings;
  fs::remove(folder / "scene.json");
  for (const char* part : {"point_cloud", "photos", "masks", kMaskNames}) fs::remove_all(folder / part);

  const std::string splats = fmt::format("point_cloud/iteration_{}/point_cloud.ply", scene.iteration);
  write_ply(folder / splats, scene.cloud, scene.antialiased);
  const std::vector<Camera> cameras = write_training_photos(folder / "photos", scene.photos);
  write_transforms(folder / "transforms.json", cameras);
  write_cameras_json(folder / "cameras.json", cameras);

  json out = {{"splats", splats}, {"cameras", "transforms.json"}};
  if (scene.photos.changed) {
    out["photos"] = "photos";
  } else if (!scene.set.photos.empty()) {
    out["photos"] = path_from(folder, scene.set.photos);
  }
  if (!settings.masks.empty()) {
    if (!scene.photos.changed) {
      out["masks"] = path_from(folder, settings.masks);
    } else {
      try {
        write_masks(folder, scene, out);
      } catch (const Error& error) {
        if (error.failure != Failure::kInput) throw;
        lost.push_back(fmt::format("{}; the scene gets no masks", error.what()));
      }
    }
  }
  write_json(folder / "scene.json", out);
  update_scene_file(folder, scene.set);
  return lost;
}

void update_scene_file(const fs::path& folder, const PhotoSet& set) {
  const json before = read_json(folder / "scene.json");
  json now = set.scene.is_object() ? set.scene : json::object();
  for (const char* made : {"splats", "cameras", "photos", "masks"}) {
    now.erase(made);
    if (before.contains(made)) now[made] = before[made];
  }
  if (!set.settings.labels.empty()) now["labels"] = path_from(folder, set.settings.labels);
  if (before.value("labels", "") == kMaskNames) now["labels"] = kMaskNames;
  if (set.settings.video) now["video"]["file"] = path_from(folder, set.settings.video->file);
  if (now != before) write_json(folder / "scene.json", now);
}

}  // namespace pliant

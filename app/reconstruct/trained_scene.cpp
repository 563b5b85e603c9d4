#include "app/reconstruct/trained_scene.h"

#include <fmt/format.h>

#include <map>
#include <nlohmann/json.hpp>

#include "app/reconstruct/training_masks.h"
#include "gaussians/io/cameras/cameras_json.h"
#include "gaussians/io/cameras/transforms.h"
#include "gaussians/io/files/json_file.h"
#include "gaussians/io/images/image_io.h"
#include "gaussians/io/splats/ply.h"

namespace pliant {
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

/// Masks that belong to the photos as they were trained on; returns their number.
int write_masks(const fs::path& folder, const TrainedScene& scene) {
  std::map<std::string, const Camera*> lens_of;
  for (const Camera& camera : scene.cameras.cameras) lens_of[camera.name] = &camera;
  int written = 0;
  for (const TrainingPhoto& photo : scene.photos.photos) {
    const std::string name = photo.camera.name + ".png";
    const auto lens = lens_of.find(photo.camera.name);
    if (lens == lens_of.end() || !fs::exists(scene.set.settings.masks / name)) continue;
    write_ids(folder / name,
              ids_through_pinhole(read_ids(scene.set.settings.masks / name), *lens->second, photo.camera));
    ++written;
  }
  return written;
}

std::string path_from(const fs::path& folder, const fs::path& file) {
  return fs::relative(file, folder).generic_string();
}

}  // namespace

std::vector<std::string> write_trained_scene(const fs::path& folder, const TrainedScene& scene) {
  std::vector<std::string> lost;
  const SceneFile& settings = scene.set.settings;
  fs::remove(folder / "scene.json");
  for (const char* part : {"point_cloud", "photos", "masks"}) fs::remove_all(folder / part);

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
    } else if (write_masks(folder / "masks", scene) > 0) {
      out["masks"] = "masks";
    } else {
      lost.push_back(
          fmt::format("{} contains no mask named like a photo: the scene gets no masks", settings.masks.string()));
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
  if (set.settings.video) now["video"]["file"] = path_from(folder, set.settings.video->file);
  if (now != before) write_json(folder / "scene.json", now);
}

}  // namespace pliant

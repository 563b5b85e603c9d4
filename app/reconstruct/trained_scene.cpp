#include "app/reconstruct/trained_scene.h"

#include <fmt/format.h>

#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "app/reconstruct/training_masks.h"
#include "app/store/lenses.h"
#include "gaussians/base/error.h"
#include "gaussians/io/cameras/cameras_json.h"
#include "gaussians/io/cameras/transforms.h"
#include "gaussians/io/files/json_file.h"
#include "gaussians/io/files/paths.h"
#include "gaussians/io/images/image_io.h"
#include "gaussians/io/scene/up_direction.h"
#include "gaussians/io/splats/ply.h"

namespace pliant {
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr const char* kMaskNames = "mask_names.json";
constexpr const char* kParts[] = {"photos", "masks", kMaskNames};  // that a training writes only where it needs them
/// In run.json: {written: scene.json as the training and the source have it, parts: {part: hash as it was written, or
/// kUnfinished}, lost_up: of lost_up, or null}.
constexpr const char* kSceneNote = "scene_file";
/// In place of the hash of a part: the training that writes it has not come to its end.
constexpr const char* kUnfinished = "unfinished";

/// Masks that belong to the photos as they were trained on.  Names that no file of labels tells go to kMaskNames in
/// `folder`.
void write_masks(const fs::path& folder, const TrainedScene& scene, json& out) {
  const SceneFile& settings = scene.set.settings;
  const bool labelled = fs::exists(settings.masks / "labels.json");
  const fs::path labels = labels_of(settings.masks, settings.labels);
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

/// scene.json of an earlier training, as the user may have changed it.
json read_own_scene(const fs::path& file) {
  json scene = read_json(file);
  const JsonObject checked(scene, file.string());  // it is an object
  return scene;
}

/// Whether the training itself made a part of the folder, by what it says in scene.json.
bool is_made(const json& made, const std::string& part) {
  const char* key = part == kMaskNames ? "labels" : part == "masks" ? "masks" : "photos";
  return made.value(key, "") == part;
}

/// Where photos that were written anew no longer say how they were held: the up that the source's photos tell.  It
/// holds where the source's scene.json says none.
std::optional<Eigen::Vector3d> lost_up(const TrainedScene& scene, const std::vector<Camera>& written) {
  constexpr double kAlike = 0.98;  // cosine
  if (!scene.photos.changed) return std::nullopt;
  const std::optional<UpDirection> source = up_of_cameras(scene.cameras.cameras), now = up_of_cameras(written);
  if (!source || (now && source->up.dot(now->up) > kAlike)) return std::nullopt;
  return source->up;
}

/// Whether +z points up, as the splats say that the training went on from, the source's scene.json or its cameras.
bool has_z_up(const TrainedScene& scene) {
  if (scene.z_is_up) return true;
  if (scene.set.settings.up) return is_near_z(*scene.set.settings.up);
  const std::optional<UpDirection> seen = up_of_cameras(scene.cameras.cameras);
  return seen && is_near_z(seen->up);
}

/// Removes what the last training wrote, and what one that did not come to its end has begun.  What someone else put in
/// its place, or has changed since, is moved aside.  Notes which parts are about to be written.
std::vector<std::string> make_room(RunDirectory& run, const TrainedScene& scene) {
  json note = run.note(kSceneNote);
  if (!note.is_object()) note = {{"written", json::object()}, {"parts", json::object()}};
  json& hashes = note["parts"];
  const bool masks = scene.photos.changed && !scene.set.settings.masks.empty();
  const std::map<std::string, bool> needed = {{"photos", scene.photos.changed}, {"masks", masks}, {kMaskNames, masks}};
  std::vector<std::string> said, made;
  for (const char* part : kParts) {
    const bool noted = hashes.contains(part);
    if (fs::exists(run / part)) {
      if (noted && (hashes[part] == kUnfinished || hash_of_input(run / part) == hashes[part]))
        made.push_back(part);
      else if (noted || needed.at(part))
        said.push_back(fmt::format("{} was not made by the last training, or changed since: it is kept as {}",
                                   (run / part).string(), run.move_aside({part}).at(part)));
    }
    if (needed.at(part)) hashes[part] = kUnfinished;
  }
  run.set_note(kSceneNote, note);
  for (const std::string& part : made) fs::remove_all(run / part);
  return said;
}

/// Frames of transforms.json whose photos the training did not change name these where the source has them now.
void follow_photos(const fs::path& folder, const CameraFile& source) {
  std::map<std::string, fs::path> photo_of;
  for (const Camera& camera : source.cameras)
    if (!camera.photo.empty()) photo_of[camera.name] = camera.photo;
  const fs::path file = folder / "transforms.json";
  const json before = read_json(file);
  const json& frames = JsonObject(before, file.string()).array("frames");
  json now = before;
  for (size_t i = 0; i < frames.size(); ++i) {
    const JsonObject frame(frames[i], file.string(), "frames[" + std::to_string(i) + "]");
    const std::string path = frame.text("file_path"),
                      name = frame.has("camera_name") ? frame.text("camera_name") : name_of_photo(path);
    const auto photo = photo_of.find(name);
    if (photo == photo_of.end() || path == "photos/" + name + ".png") continue;
    const std::string found = path_as_seen_from(fs::absolute(file).parent_path(), photo->second).generic_string();
    now["frames"][i]["file_path"] = found;
    if (name_of_photo(found) != name) now["frames"][i]["camera_name"] = name;
  }
  if (now != before) write_json(file, now);
}

/// scene.json from what the source says, what the training made, and what the user has made of it since it was last
/// written.  A new training decides what shows it.  `note` is kSceneNote without what is written.
void merge_scene_file(RunDirectory& run, const PhotoSet& set, const json& made, json note, bool trained) {
  const fs::path folder = run.path(), file = folder / "scene.json";
  json now = set.scene.is_object() ? set.scene : json::object();
  for (const char* key : {"splats", "cameras", "photos", "masks", "antialiased"}) now.erase(key);
  if (!set.settings.labels.empty()) now["labels"] = path_from(folder, set.settings.labels);
  if (set.settings.video) now["video"]["file"] = path_from(folder, set.settings.video->file);
  now.update(made);

  const json noted = run.note(kSceneNote);
  json written = noted.is_object() ? noted["written"] : json::object();
  if (trained)
    for (const char* key : {"splats", "cameras", "photos"}) written.erase(key);
  json merged = now;
  if (fs::exists(file)) {
    const json before = merged = read_own_scene(file);
    for (const json* said : {&now, &written}) {
      for (const auto& [key, value] : said->items()) {
        if (now.contains(key) == written.contains(key) && (!now.contains(key) || now[key] == written[key])) continue;
        if (now.contains(key))
          merged[key] = now[key];
        else
          merged.erase(key);
      }
    }
    if (merged == before && now == written) return;
  }
  write_json(file, merged);
  note["written"] = now;
  run.set_note(kSceneNote, note);
}

}  // namespace

void refuse_other_run(const RunDirectory& run) {
  std::string of = run.scene().is_null() ? "" : "another command";
  for (const auto& [stage, record] : run.manifest()["stages"].items())
    if (stage != "reconstruct") of = "`" + stage + "`";
  if (!of.empty())
    throw usage_error("--out", run.path().string(), "holds the results of " + of,
                      "give another folder; a run directory has its trained scene in scene/");
}

void check_own_scene(const RunDirectory& run) {
  if (fs::exists(run / "scene.json")) read_own_scene(run / "scene.json");
}

void refuse_own_source(const fs::path& folder, const PhotoSet& set, const ReconstructStage& stage) {
  static const std::set<std::string> made = {
      ".", "point_cloud", "photos", "masks", kMaskNames, "transforms.json", "cameras.json", "scene.json", kLensFile};
  std::vector<std::pair<const char*, fs::path>> sources = {
      {"cameras", set.cameras}, {"photos", set.photos}, {"masks", set.settings.masks}, {"masks", stage.masks}};
  for (const fs::path& file : stage.splats) sources.emplace_back("splats", file);
  for (const auto& [what, source] : sources) {
    if (source.empty()) continue;
    const fs::path within = fs::weakly_canonical(source).lexically_relative(fs::weakly_canonical(folder));
    if (!within.empty() && made.count(within.begin()->string()))
      throw usage_error("--out", folder.string(), fmt::format("contains the {} to train on", what),
                        "give another folder");
  }
}

std::vector<std::string> write_trained_scene(RunDirectory& run, const TrainedScene& scene) {
  const fs::path& folder = run.path();
  const SceneFile& settings = scene.set.settings;
  fs::remove_all(folder / "point_cloud");
  std::vector<std::string> lost = make_room(run, scene);

  const std::string splats = fmt::format("point_cloud/iteration_{}/point_cloud.ply", scene.iteration);
  write_ply(folder / splats, scene.cloud, scene.antialiased, has_z_up(scene));
  const std::vector<Camera> cameras = write_training_photos(folder / "photos", scene.photos);
  write_transforms(folder / "transforms.json", cameras);
  write_cameras_json(folder / "cameras.json", cameras);
  write_lenses(folder / kLensFile, scene.photos);

  json made = {{"splats", splats}, {"cameras", "transforms.json"}};
  json note = {{"parts", json::object()}, {"lost_up", nullptr}};
  if (const auto up = lost_up(scene, cameras)) note["lost_up"] = {up->x(), up->y(), up->z()};
  if (!settings.up && !note["lost_up"].is_null()) made["up"] = note["lost_up"];
  // Black is not said, but where the source says another color.
  if (const auto& b = scene.background; b && (settings.background || *b != Vec3d::Zero()))
    made["background"] = {b->x(), b->y(), b->z()};
  if (scene.photos.changed) {
    made["photos"] = "photos";
  } else if (!scene.set.photos.empty()) {
    made["photos"] = path_from(folder, scene.set.photos);
  }
  if (!settings.masks.empty()) {
    if (!scene.photos.changed) {
      made["masks"] = path_from(folder, settings.masks);
    } else {
      try {
        write_masks(folder, scene, made);
      } catch (const Error& error) {
        if (error.failure != Failure::kInput) throw;
        lost.push_back(fmt::format("{}; the scene gets no masks", error.what()));
      }
    }
  }
  for (const char* part : kParts)
    if (fs::exists(folder / part) && is_made(made, part)) note["parts"][part] = hash_of_input(folder / part);
  merge_scene_file(run, scene.set, made, note, true);
  return lost;
}

void update_scene_file(RunDirectory& run, const PhotoSet& set, const CameraFile& cameras) {
  const fs::path& folder = run.path();
  const SceneFile& settings = set.settings;
  json note = run.note(kSceneNote), written;
  if (note.is_object()) {
    written = note["written"];
  } else {
    // A scene that was trained before there were notes says itself what its training made.
    written = read_own_scene(folder / "scene.json");
    if (settings.masks.empty()) written.erase("masks");
    note = {{"parts", json::object()}};
  }
  json made = json::object();
  for (const char* key : {"splats", "cameras", "background"})
    if (written.contains(key)) made[key] = written[key];
  // What the training did not change lies where the source has it now.
  if (is_made(written, "photos"))
    made["photos"] = "photos";
  else if (!set.photos.empty())
    made["photos"] = path_from(folder, set.photos);
  if (is_made(written, "masks"))
    made["masks"] = "masks";
  else if (written.contains("masks") && !settings.masks.empty())
    made["masks"] = path_from(folder, settings.masks);
  if (is_made(written, kMaskNames)) made["labels"] = kMaskNames;
  if (!settings.up && is_made(written, "photos")) {
    // Older notes do not say whether an up is the training's: it stays.
    const json up = note.contains("lost_up") ? note["lost_up"] : written.value("up", json());
    if (!up.is_null()) made["up"] = up;
  }
  follow_photos(folder, cameras);
  merge_scene_file(run, set, made, note, false);
}

}  // namespace pliant

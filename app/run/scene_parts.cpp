#include "app/run/scene_parts.h"

#include <fmt/format.h>

#include <functional>
#include <nlohmann/json.hpp>

#include "app/import/physdreamer_folder.h"
#include "gaussians/io/files/files.h"

namespace pliant {
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr const char* kSplatsRole = "splats";  ///< of a single file, whose name does not count; else with the names

/// A part, how it is taken over, and what is recorded of it.
struct PartRow {
  ScenePart part;
  std::function<void(const Scene& from, Scene& to)> take;
  std::function<void(const Scene& scene, SceneRecord& record)> record;
};

template <class T>
json list_of(const T& vector) {
  return {vector.x(), vector.y(), vector.z()};
}

template <class T>
json value_or_null(const std::optional<T>& value) {
  return value ? json(*value) : json();
}

void record_file(const std::string& role, const fs::path& file, SceneRecord& record) {
  if (!file.empty()) record.files[role] = file;
}

/// Nothing where it is black, so that a scene without the key stays the same.
void record_background(const Scene& scene, SceneRecord& record) {
  const Vec3d color = scene.settings.background.value_or(Vec3d::Zero());
  if (color != Vec3d::Zero()) record.values["background"] = list_of(color);
}

void record_splats(const Scene& scene, SceneRecord& record) {
  if (scene.settings.antialiased) record.values["antialiased"] = scene.report.antialiased;
  record_background(scene, record);
  record.values["level"] = scene.report.level;
  const std::vector<fs::path>& files = scene.report.files;
  if (files.size() == 1) {
    record.files[kSplatsRole] = files[0];
    return;
  }
  const fs::path folder = scene.settings.splats.parent_path();
  for (const fs::path& file : files)
    record.files[kSplatsRole + (" " + file.lexically_proximate(folder).string())] = file;
}

/// A digest of what the cameras are, wherever they come from: an orbit has no file.
void record_cameras(const Scene& scene, SceneRecord& record) {
  std::string text;
  for (const Camera& camera : scene.cameras) {
    text += fmt::format("{} {} {} {} {} {} {}", camera.name, camera.width, camera.height, camera.fx, camera.fy,
                        camera.cx, camera.cy);
    for (int k = 0; k < 12; ++k) text += fmt::format(" {}", camera.cam_from_world.matrix()(k / 4, k % 4));
    text += "\n";
  }
  record.values["cameras"] = sha256_of_text(text);
  record.values["cameras_are_orbit"] = scene.cameras_are_orbit;
}

void record_photos(const Scene& scene, SceneRecord& record) {
  for (const Camera& camera : scene.cameras)
    if (fs::exists(camera.photo)) record.files["photo " + camera.name] = camera.photo;
}

void record_folder(const Scene& scene, SceneRecord& record) {
  std::error_code ignored;
  if (scene.source.empty() || fs::exists(scene.source / "scene.json", ignored) || !is_physdreamer_folder(scene.source))
    return;
  for (const char* name : {"clean_object_points.ply", "internal_filled_points.ply", "moving_part_points.ply", "masks"})
    if (fs::exists(scene.source / name)) record.files[name] = scene.source / name;
}

json region_json(const SceneFile::Region& region) {
  return {{"sphere", region.sphere}, {"low", list_of(region.low)}, {"high", list_of(region.high)}};
}

const std::vector<PartRow>& rows() {
  static const std::vector<PartRow> all = {
      {ScenePart::kSplats,
       [](const Scene& from, Scene& to) {
         to.cloud = from.cloud;
         to.report = from.report;
         to.settings.splats = from.settings.splats;
         to.settings.antialiased = from.settings.antialiased;
         to.settings.background = from.settings.background;
       },
       record_splats},
      {ScenePart::kDrawing,
       [](const Scene& from, Scene& to) {
         to.report.antialiased = from.report.antialiased;
         to.report.z_is_up = from.report.z_is_up;
         to.settings.background = from.settings.background;
       },
       [](const Scene& scene, SceneRecord& record) {
         record.values["antialiased"] = scene.report.antialiased;
         record_background(scene, record);
       }},
      {ScenePart::kCameras,
       [](const Scene& from, Scene& to) {
         to.cameras = from.cameras;
         to.cameras_are_orbit = from.cameras_are_orbit;
         for (Camera& camera : to.cameras) camera.photo.clear();
       },
       record_cameras},
      {ScenePart::kPhotos,
       [](const Scene& from, Scene& to) {
         for (size_t c = 0; c < to.cameras.size(); ++c) to.cameras[c].photo = from.cameras[c].photo;
       },
       record_photos},
      {ScenePart::kUp, [](const Scene& from, Scene& to) { to.up = from.up; },
       [](const Scene& scene, SceneRecord& record) { record.values["up"] = list_of(scene.up); }},
      {ScenePart::kMetresPerUnit, [](const Scene& from, Scene& to) { to.metres_per_unit = from.metres_per_unit; },
       [](const Scene& scene, SceneRecord& record) { record.values["metres_per_unit"] = scene.metres_per_unit; }},
      {ScenePart::kFolder, [](const Scene& from, Scene& to) { to.source = from.source; }, record_folder},
      {ScenePart::kMasks, [](const Scene& from, Scene& to) { to.settings.masks = from.settings.masks; },
       [](const Scene& scene, SceneRecord& record) { record_file("masks", scene.settings.masks, record); }},
      {ScenePart::kLabels, [](const Scene& from, Scene& to) { to.settings.labels = from.settings.labels; },
       [](const Scene& scene, SceneRecord& record) { record_file("labels", scene.settings.labels, record); }},
      {ScenePart::kSupport, [](const Scene& from, Scene& to) { to.settings.support = from.settings.support; },
       [](const Scene& scene, SceneRecord& record) { record.values["support"] = scene.settings.support; }},
      {ScenePart::kObject, [](const Scene& from, Scene& to) { to.settings.object = from.settings.object; },
       [](const Scene& scene, SceneRecord& record) { record.values["object"] = scene.settings.object; }},
      {ScenePart::kPinned, [](const Scene& from, Scene& to) { to.settings.pinned = from.settings.pinned; },
       [](const Scene& scene, SceneRecord& record) {
         json& regions = record.values["pinned"] = json::array();
         for (const SceneFile::Region& region : scene.settings.pinned) regions.push_back(region_json(region));
       }},
      {ScenePart::kMaterial, [](const Scene& from, Scene& to) { to.settings.material = from.settings.material; },
       [](const Scene& scene, SceneRecord& record) {
         const MaterialValues& m = scene.settings.material;
         record.values["material"] = {{"young", value_or_null(m.young)},
                                      {"poisson", value_or_null(m.poisson)},
                                      {"density", value_or_null(m.density)},
                                      {"law", m.law},
                                      {"constants", m.constants}};
       }},
      {ScenePart::kVideo, [](const Scene& from, Scene& to) { to.settings.video = from.settings.video; },
       [](const Scene& scene, SceneRecord& record) {
         if (const auto& video = scene.settings.video)
           record.values["video"] = {{"camera", video->camera}, {"fps", video->fps}};
       }},
      {ScenePart::kVideoCamera,
       [](const Scene& from, Scene& to) {
         if (from.settings.video) to.settings.video = VideoReference{{}, from.settings.video->camera, 0};
       },
       [](const Scene& scene, SceneRecord& record) {
         if (scene.settings.video) record.values["video_camera"] = scene.settings.video->camera;
       }},
  };
  return all;
}

}  // namespace

json splats_of(const json& inputs) {
  json out = json::object();
  for (const auto& [role, hash] : inputs.items())
    if (role == kSplatsRole || role.starts_with(kSplatsRole + std::string(" "))) out[role] = hash;
  return out;
}

Scene only(const ScenePartSet& parts, const Scene& scene) {
  Scene out;
  for (const PartRow& row : rows())
    if (parts.count(row.part)) row.take(scene, out);
  return out;
}

SceneRecord record_of(const ScenePartSet& parts, const Scene& scene) {
  SceneRecord record;
  record.values = json::object();
  for (const PartRow& row : rows())
    if (parts.count(row.part)) row.record(scene, record);
  return record;
}

}  // namespace pliant

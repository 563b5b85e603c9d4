#include "app/segment/objects_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <nlohmann/json.hpp>

#include "app/segment/photo_or_render.h"
#include "app/segment/sheet_prompts.h"
#include "app/store/segmentation.h"
#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/images/image_io.h"
#include "segmentation/labels/object_names.h"
#include "segmentation/sheets/feature_picture.h"
#include "segmentation/sheets/objects_sheet.h"

namespace pliant {
using nlohmann::json;

namespace {

json box_to_json(const Box& box) {
  return {{"low", {box.low.x(), box.low.y(), box.low.z()}}, {"high", {box.high.x(), box.high.y(), box.high.z()}}};
}

}  // namespace

json objects_to_json(const std::vector<ObjectEntry>& objects) {
  json rows = json::array();
  for (const ObjectEntry& object : objects) {
    json row = {{"id", object.id},       {"name", object.name},
                {"score", object.score}, {"gaussians", object.gaussians},
                {"views", object.views}, {"found", object.origin}};
    if (object.gaussians > 0) row["bounds"] = box_to_json(object.bounds);
    rows.push_back(std::move(row));
  }
  return rows;
}

std::vector<ObjectEntry> write_objects(const Context& context, const RunDirectory& run, const Scene& scene,
                                       const std::string& origin, const std::string& provenance,
                                       Segmentation& segmentation, const std::function<void(json& rows)>& complete) {
  if (segmentation.class_cameras.empty()) find_class_cameras(scene.cloud, scene.cameras, segmentation);
  segmentation.class_origin.resize(segmentation.class_id.size());
  for (std::string& known : segmentation.class_origin)
    if (known.empty()) known = origin;
  std::vector<ObjectEntry> objects = list_objects(segmentation, scene.cloud.position);
  // The sheets only show the result, so a bad photo does not keep it from being written.
  bool warned = false;
  const auto picture = [&](int camera) {
    try {
      return photo_or_render(scene, camera);
    } catch (const Error& error) {
      if (error.failure != Failure::kInput) throw;
      if (!warned)
        context.progress.warn(
            fmt::format("{}; objects.png and features.png show renders in place of such photos", error.what()));
      warned = true;
      return render_for_photo(scene, camera);
    }
  };
  std::vector<SheetCell> cells;
  const ImageF objects_picture = objects_sheet(segmentation, scene.cloud, scene.cameras, picture, 12, &cells);
  const ImageF features_picture =
      features_sheet(segmentation.attribute, scene.cloud, scene.cameras, picture, segmentation.antialiased);
  write_segmentation(run / "segmentation.h5", segmentation, provenance);
  json rows = objects_to_json(objects);
  if (complete) complete(rows);
  write_text(run / "objects.json", rows.dump(2, ' ', false, json::error_handler_t::replace) + "\n");
  write_image(run / "objects.png", objects_picture);
  write_sheet_cells(run, cells, scene.cameras);
  write_image(run / "features.png", features_picture);
  return objects;
}

void write_held_out(const RunDirectory& run, const Scene& scene, const std::vector<int>& held_out,
                    const Segmentation& segmentation) {
  if (!held_out.empty()) std::filesystem::create_directories(run / "held_out");
  for (const int camera : held_out)
    write_ids(run / "held_out" / (scene.cameras[camera].name + ".png"),
              render_ids(segmentation, scene.cloud, scene.cameras[camera]));
}

std::string folder_of_object(uint32_t id, std::string name) {
  name.resize(std::min(name.size(), kLongestName));
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '-' && c != '_') c = '_';
  return fmt::format("objects/{}_{}", id, name);
}

Segmentation read_objects(const RunDirectory& run, const Scene& scene) {
  run.summary("segment", "run `pliant segment SCENE --out DIR` first");
  Segmentation segmentation = read_segmentation(run / "segmentation.h5");
  segmentation.antialiased = scene.report.antialiased;
  if (segmentation.label.size() != scene.cloud.size())
    throw input_error((run / "segmentation.h5").string(), "label",
                      fmt::format("has {} rows, the scene {} Gaussians", segmentation.label.size(), scene.cloud.size()),
                      "delete it, and segment the scene again");
  return segmentation;
}

}  // namespace pliant

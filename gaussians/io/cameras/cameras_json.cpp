#include "gaussians/io/cameras/cameras_json.h"

#include <nlohmann/json.hpp>

#include "gaussians/base/error.h"
#include "gaussians/io/files/json_file.h"

namespace fs = std::filesystem;

namespace pliant {
namespace {

Eigen::Isometry3d read_3dgs_pose(const JsonObject& entry) {
  const std::vector<double> position = entry.numbers("position", 3);
  const nlohmann::json& rows = entry.array("rotation");
  const std::string remedy = "it must be a rotation of 3 rows of 3 numbers";
  Eigen::Matrix3d rotation;
  if (rows.size() != 3) throw entry.complaint("rotation", "has " + std::to_string(rows.size()) + " rows", remedy);
  for (int i = 0; i < 3; ++i) {
    if (!rows[i].is_array() || rows[i].size() != 3)
      throw entry.complaint("rotation", "has a row that is not 3 numbers", remedy);
    for (int j = 0; j < 3; ++j) {
      if (!rows[i][j].is_number())
        throw entry.complaint("rotation", "holds " + rows[i][j].dump().substr(0, 40), remedy);
      rotation(i, j) = rows[i][j];
    }
  }
  if (!rotation.allFinite() || !make_rotation(rotation)) throw entry.complaint("rotation", "is not a rotation", remedy);
  Eigen::Isometry3d world_from_cam = Eigen::Isometry3d::Identity();
  world_from_cam.linear() = rotation;
  world_from_cam.translation() = Eigen::Vector3d(position[0], position[1], position[2]);
  return world_from_cam.inverse();
}

}  // namespace

CameraFile read_cameras_json(const fs::path& file, const fs::path& photos, PhotoFit fit) {
  const nlohmann::json json = read_json(file);
  if (!json.is_array() || json.empty())
    throw input_error(file.string(), "", "is not an array of cameras", "give the cameras.json of a 3DGS model");
  CameraCollector collector(file, fit);
  const fs::path folder = file.parent_path();
  for (size_t i = 0; i < json.size(); ++i) {
    std::string place = "[";
    place.append(std::to_string(i)).append("]");
    const JsonObject entry(json[i], file.string(), place, Failure::kInput);
    Camera camera;
    camera.cam_from_world = read_3dgs_pose(entry);
    const double width = entry.number("width"), height = entry.number("height");
    if (!(width >= 1 && width <= 65536 && height >= 1 && height <= 65536)) {
      throw entry.complaint(width >= 1 && width <= 65536 ? "height" : "width", "is out of range",
                            "sizes are 1 to 65536 pixels");
    }
    camera.width = static_cast<int>(width);
    camera.height = static_cast<int>(height);
    camera.fx = entry.number("fx");
    camera.fy = entry.number("fy");
    for (const char* key : {"fx", "fy"}) {
      if (!(entry.number(key) > 0))
        throw entry.complaint(key, "is " + std::to_string(entry.number(key)), "it must be positive");
    }
    camera.cx = 0.5 * camera.width;
    camera.cy = 0.5 * camera.height;
    const std::string name = entry.text("img_name");
    camera.photo = find_photo(photos, {folder / "images", folder / "input", folder}, name, fit).string();
    collector.add(std::move(camera), name);
  }
  return collector.finish("cameras.json of 3DGS");
}

void write_cameras_json(const fs::path& file, const std::vector<Camera>& cameras) {
  nlohmann::json out = nlohmann::json::array();
  for (const Camera& camera : cameras) {
    const Eigen::Isometry3d world_from_cam = camera.cam_from_world.inverse();
    nlohmann::json rotation = nlohmann::json::array();
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d row = world_from_cam.linear().row(i).array() + 0.0;  // -0 becomes 0
      rotation.push_back({row[0], row[1], row[2]});
    }
    const Eigen::Vector3d centre = world_from_cam.translation().array() + 0.0;
    const fs::path photo = camera.photo;
    const bool named = photo.empty() || name_of_photo(photo) != camera.name;
    const std::string name = named ? camera.name : photo.filename().string();
    out.push_back({{"id", out.size()},
                   {"img_name", name},
                   {"width", camera.width},
                   {"height", camera.height},
                   {"position", {centre[0], centre[1], centre[2]}},
                   {"rotation", rotation},
                   {"fx", camera.fx},
                   {"fy", camera.fy}});
  }
  write_json(file, out);
}

}  // namespace pliant

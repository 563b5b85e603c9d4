#include "gaussians/io/cameras/camera_path.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "gaussians/io/cameras/camera_file.h"
#include "gaussians/io/cameras/cameras.h"
#include "gaussians/io/files/json_file.h"
#include "gaussians/io/files/number_order.h"

namespace fs = std::filesystem;

namespace pliant {
namespace {

int side_of(const JsonObject& top, const std::string& key) {
  const double side = top.number(key);
  if (!(side >= 1 && side <= 65536)) throw top.complaint(key, "is out of range", "sizes are 1 to 65536 pixels");
  return static_cast<int>(side);
}

/// Frames of nerfstudio: camera_to_world row by row with OpenGL axes, the vertical field of view in degrees.
CameraPath read_nerfstudio(const nlohmann::json& json, const fs::path& file) {
  const JsonObject top(json, file.string(), "", Failure::kInput);
  if (top.has("camera_type") && top.text("camera_type") != "perspective")
    throw top.complaint("camera_type", "is '" + top.text("camera_type") + "'", "only perspective cameras are drawn");
  if (top.has("crop") && !json["crop"].is_null())
    throw top.complaint("crop", "is not supported", "export the path without a crop");
  CameraPath path;
  path.fps = top.number("fps", path.fps);
  if (!(path.fps > 0 && path.fps <= 1000))
    throw top.complaint("fps", "is out of range", "give frames per second, at most 1000");
  const int width = side_of(top, "render_width"), height = side_of(top, "render_height");
  const nlohmann::json& frames = top.array("camera_path");
  if (frames.empty()) throw top.complaint("camera_path", "is empty", "a path needs at least one pose");
  const size_t digits = std::to_string(frames.size() - 1).size();
  for (size_t k = 0; k < frames.size(); ++k) {
    const JsonObject frame(frames[k], file.string(), "camera_path[" + std::to_string(k) + "]", Failure::kInput);
    const std::vector<double> rows = frame.numbers("camera_to_world", 16);
    const Eigen::Matrix4d world_from_cam = Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(rows.data());
    Camera camera;
    camera.name = std::to_string(k);
    camera.name.insert(0, digits - camera.name.size(), '0');
    camera.width = width;
    camera.height = height;
    if (const char* problem = cam_from_opengl(world_from_cam, camera.cam_from_world))
      throw frame.complaint("camera_to_world", problem, "it must be a rotation, a position, and 0 0 0 1");
    const double fov = frame.number("fov");
    if (!(fov > 0 && fov < 180)) throw frame.complaint("fov", "is out of range", "give degrees between 0 and 180");
    camera.fx = camera.fy = 0.5 * height / std::tan(fov * M_PI / 360);
    camera.cx = 0.5 * width;
    camera.cy = 0.5 * height;
    path.cameras.push_back(std::move(camera));
  }
  return path;
}

}  // namespace

Camera CameraPath::at(double time) const {
  const double place = std::clamp(time * fps, 0.0, static_cast<double>(cameras.size() - 1));
  const size_t k = static_cast<size_t>(place);
  const double u = place - static_cast<double>(k);
  if (u == 0) return cameras[k];
  const Camera &a = cameras[k], &b = cameras[k + 1];
  const auto between = [u](double from, double to) { return from + u * (to - from); };
  Camera out = a;
  out.fx = between(a.fx, b.fx);
  out.fy = between(a.fy, b.fy);
  out.cx = between(a.cx, b.cx);
  out.cy = between(a.cy, b.cy);
  const Eigen::Quaterniond turned =
      Eigen::Quaterniond(a.cam_from_world.linear()).slerp(u, Eigen::Quaterniond(b.cam_from_world.linear()));
  const Eigen::Vector3d centre = a.centre() + u * (b.centre() - a.centre());
  out.cam_from_world.linear() = turned.toRotationMatrix();
  out.cam_from_world.translation() = -(out.cam_from_world.linear() * centre);
  return out;
}

bool is_camera_path(const fs::path& file) {
  if (file.extension() != ".json") return false;
  const nlohmann::json json = read_json(file);
  return json.is_object() && json.contains("camera_path");
}

void order_by_photo(std::vector<Camera>& cameras) {
  const bool photos =
      std::all_of(cameras.begin(), cameras.end(), [](const Camera& camera) { return !camera.photo.empty(); });
  std::stable_sort(cameras.begin(), cameras.end(), [photos](const Camera& a, const Camera& b) {
    return photos ? number_order(a.photo, b.photo) : number_order(a.name, b.name);
  });
}

CameraPath read_views(const fs::path& file) {
  CameraFile read = read_cameras(file, {}, PhotoFit::kView);
  if (read.format.rfind("COLMAP", 0) == 0) order_by_photo(read.cameras);
  CameraPath path;
  path.cameras = std::move(read.cameras);
  path.warnings = std::move(read.warnings);
  return path;
}

CameraPath read_camera_path(const fs::path& file) {
  if (is_camera_path(file)) return read_nerfstudio(read_json(file), file);
  CameraPath path = read_views(file);
  for (const Camera& camera : path.cameras)
    if (camera.width != path.cameras[0].width || camera.height != path.cameras[0].height)
      throw input_error(file.string(), camera.name, "has another size than the first camera",
                        "give a path whose cameras have one size");
  return path;
}

}  // namespace pliant

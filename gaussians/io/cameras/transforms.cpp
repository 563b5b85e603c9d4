#include "gaussians/io/cameras/transforms.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "gaussians/base/error.h"
#include "gaussians/io/files/json_file.h"
#include "gaussians/io/files/paths.h"

namespace fs = std::filesystem;

namespace pliant {
namespace {

/// cam_from_world from the frame's world_from_cam with OpenGL axes.
Eigen::Isometry3d read_pose(const JsonObject& frame) {
  const std::string key = "transform_matrix";
  const nlohmann::json& rows = frame.array(key);
  const auto refuse = [&](const std::string& problem) {
    return frame.complaint(key, problem, "it must be a 4x4 matrix: a rotation, a position, and 0 0 0 1");
  };
  if (rows.size() != 3 && rows.size() != 4) throw refuse("has " + std::to_string(rows.size()) + " rows");
  Eigen::Matrix4d world_from_cam = Eigen::Matrix4d::Identity();
  for (size_t i = 0; i < rows.size(); ++i) {
    if (!rows[i].is_array() || rows[i].size() != 4) throw refuse("has a row that is not 4 numbers");
    for (size_t j = 0; j < 4; ++j) {
      if (!rows[i][j].is_number()) throw refuse("holds " + rows[i][j].dump().substr(0, 40));
      world_from_cam(i, j) = rows[i][j].get<double>();
    }
  }
  if (!world_from_cam.allFinite()) throw refuse("holds values that are not finite");
  Eigen::Isometry3d cam_from_world;
  if (const char* problem = cam_from_opengl(world_from_cam, cam_from_world)) throw refuse(problem);
  return cam_from_world;
}

/// Reads the frames of one file; values of a frame win over those of the whole file.
class Reader {
 public:
  Reader(const fs::path& file, const fs::path& photos, PhotoFit fit)
      : file_(file),
        photos_(photos),
        fit_(fit),
        json_(read_json(file)),
        top_(json_, file.string()),
        collector_(file, fit) {}

  CameraFile read() {
    const nlohmann::json& frames = top_.array("frames");
    if (frames.empty()) throw top_.complaint("frames", "is empty", "a camera file needs at least one frame");
    for (size_t i = 0; i < frames.size(); ++i) read_frame(frames[i], i);
    CameraFile file = collector_.finish("transforms.json", photo_width_ > 0);
    if (moments_.size() > 1)
      file.warnings.push_back(file_.string() + ": the frames are of " + std::to_string(moments_.size()) +
                              " moments (\"time\"), and a scene is trained as if they were of one: what moves between "
                              "them is blurred; keep the frames of one moment");
    if (masked_ > 0)
      file.warnings.push_back(file_.string() + ": mask_path of " + std::to_string(masked_) +
                              " frames is ignored: all pixels of the photos are used");
    return file;
  }

 private:
  bool has(const JsonObject& frame, const std::string& key) const { return frame.has(key) || top_.has(key); }
  double number(const JsonObject& frame, const std::string& key) const {
    return frame.has(key) ? frame.number(key) : top_.number(key);
  }

  void read_frame(const nlohmann::json& value, size_t index) {
    const JsonObject frame(value, file_.string(), "frames[" + std::to_string(index) + "]");
    for (const JsonObject* object : {&frame, static_cast<const JsonObject*>(&top_)}) {
      if (!object->has("camera_model")) continue;
      const std::string model = object->text("camera_model");
      static const std::set<std::string> pinhole = {"PINHOLE", "SIMPLE_PINHOLE", "OPENCV", "RADIAL", "SIMPLE_RADIAL"};
      if (!pinhole.count(model)) {
        throw object->complaint("camera_model", "is '" + model + "'",
                                "only pinhole cameras are supported: undistort the photos");
      }
    }
    refuse_other_lenses(frame, value);
    masked_ += frame.has("mask_path");
    if (const auto time = value.find("time"); time != value.end() && time->is_number())
      moments_.insert(time->get<double>());
    Camera camera;
    for (size_t k = 0; k < kDistortionNames.size(); ++k) {
      if (has(frame, kDistortionNames[k])) camera.distortion[k] = number(frame, kDistortionNames[k]);
    }
    const std::string file_path = frame.text("file_path");
    if (frame.has("camera_name")) camera.name = frame.text("camera_name");
    camera.cam_from_world = read_pose(frame);
    camera.photo = find_photo(photos_, {file_.parent_path()}, file_path, fit_).string();
    read_size(frame, camera);
    read_intrinsics(frame, camera);
    collector_.add(std::move(camera), file_path);
  }

  /// Lenses that k1, k2, p1, p2 and k3 do not describe: the fisheye of instant-ngp, and k4, which is the coefficient
  /// of r^8 in these files and of the denominator in Camera::distortion.
  void refuse_other_lenses(const JsonObject& frame, const nlohmann::json& value) const {
    const std::pair<const JsonObject*, const nlohmann::json*> places[] = {{&frame, &value}, {&top_, &json_}};
    for (const auto& [object, json] : places)
      if (object->has("is_fisheye") && json->at("is_fisheye") == true)
        throw object->complaint("is_fisheye", "is true", "only pinhole cameras are supported: undistort the photos");
    const JsonObject& place = frame.has("k4") ? frame : top_;
    if (const double k4 = place.number("k4", 0.0); k4 != 0)
      throw place.complaint("k4", "is " + std::to_string(k4),
                            "distortion is supported up to k3, the coefficient of r^6: undistort the photos");
  }

  void read_size(const JsonObject& frame, Camera& camera) {
    if (has(frame, "w") && has(frame, "h")) {
      const double w = number(frame, "w"), h = number(frame, "h");
      if (!(w >= 1 && w <= 65536 && h >= 1 && h <= 65536)) {
        throw frame.complaint(w >= 1 && w <= 65536 ? "h" : "w", "is out of range", "sizes are 1 to 65536 pixels");
      }
      camera.width = static_cast<int>(w);
      camera.height = static_cast<int>(h);
      return;
    }
    // Without sizes in the file the first photo tells them.
    if (!size_was_sought_) find_size();
    camera.width = photo_width_;
    camera.height = photo_height_;
    if (camera.width == 0 && has(frame, "cx") && has(frame, "cy")) {
      camera.width = static_cast<int>(std::lround(std::clamp(2 * number(frame, "cx"), 0.0, 65536.0)));
      camera.height = static_cast<int>(std::lround(std::clamp(2 * number(frame, "cy"), 0.0, 65536.0)));
    }
    if (camera.width < 1 || camera.height < 1) {
      throw frame.complaint("w", "is missing and the photo does not exist", "add w and h");
    }
  }

  /// The size of the first photo that exists and can be read.
  void find_size() {
    size_was_sought_ = true;
    size_t index = 0;
    for (const nlohmann::json& value : top_.array("frames")) {
      const JsonObject frame(value, file_.string(), "frames[" + std::to_string(index++) + "]");
      const std::string photo = find_photo(photos_, {file_.parent_path()}, frame.text("file_path"), fit_).string();
      if (!photo.empty() && read_photo_size(photo, fit_, photo_width_, photo_height_)) return;
    }
  }

  /// Focal length in pixels of a field of view over so many pixels.
  double focal_of_angle(const JsonObject& frame, const std::string& key, int pixels) const {
    const double angle = number(frame, key);
    if (!(angle > 0 && angle < M_PI))
      throw frame.complaint(key, "is " + std::to_string(angle), "it must be between 0 and pi");
    return 0.5 * pixels / std::tan(0.5 * angle);
  }

  void read_intrinsics(const JsonObject& frame, Camera& camera) {
    if (has(frame, "fl_x")) {
      camera.fx = number(frame, "fl_x");
    } else if (has(frame, "camera_angle_x")) {
      camera.fx = focal_of_angle(frame, "camera_angle_x", camera.width);
    } else {
      throw frame.complaint("fl_x", "is missing, and so is camera_angle_x", "add the focal length in pixels");
    }
    if (has(frame, "fl_y"))
      camera.fy = number(frame, "fl_y");
    else
      camera.fy = !has(frame, "fl_x") && has(frame, "camera_angle_y")
                      ? focal_of_angle(frame, "camera_angle_y", camera.height)
                      : camera.fx;
    camera.cx = has(frame, "cx") ? number(frame, "cx") : 0.5 * camera.width;
    camera.cy = has(frame, "cy") ? number(frame, "cy") : 0.5 * camera.height;
    if (!(camera.fx > 0)) throw frame.complaint("fl_x", "is " + std::to_string(camera.fx), "it must be positive");
    if (!(camera.fy > 0)) throw frame.complaint("fl_y", "is " + std::to_string(camera.fy), "it must be positive");
  }

  fs::path file_, photos_;
  PhotoFit fit_;
  nlohmann::json json_;
  JsonObject top_;
  CameraCollector collector_;
  int photo_width_ = 0, photo_height_ = 0, masked_ = 0;
  bool size_was_sought_ = false;
  std::set<double> moments_;
};

}  // namespace

CameraFile read_transforms(const fs::path& file, const fs::path& photos, PhotoFit fit) {
  return Reader(file, photos, fit).read();
}

void write_transforms(const fs::path& file, const std::vector<Camera>& cameras, const fs::path& points) {
  const auto intrinsics = [](const Camera& camera) {
    nlohmann::json out = {{"w", camera.width}, {"h", camera.height}, {"fl_x", camera.fx},
                          {"fl_y", camera.fy}, {"cx", camera.cx},    {"cy", camera.cy}};
    for (size_t k = 0; k < kDistortionNames.size(); ++k) {
      if (camera.distortion[k] != 0) out[kDistortionNames[k]] = camera.distortion[k];
    }
    return out;
  };
  bool distorted = false;
  for (const Camera& camera : cameras) distorted = distorted || camera.distortion != Camera().distortion;
  bool shared = !cameras.empty();
  for (const Camera& camera : cameras) shared = shared && intrinsics(camera) == intrinsics(cameras[0]);
  nlohmann::json out = shared ? intrinsics(cameras[0]) : nlohmann::json::object();
  out["camera_model"] = distorted ? "OPENCV" : "PINHOLE";
  out["frames"] = nlohmann::json::array();
  const auto from_folder = [&](const fs::path& named) {
    return path_as_seen_from(fs::absolute(file).parent_path(), named).generic_string();
  };
  if (!points.empty()) out["ply_file_path"] = from_folder(points);
  for (const Camera& camera : cameras) {
    nlohmann::json frame = shared ? nlohmann::json::object() : intrinsics(camera);
    frame["file_path"] = camera.photo.empty() ? camera.name : from_folder(camera.photo);
    if (name_of_photo(frame["file_path"].get<std::string>()) != camera.name) frame["camera_name"] = camera.name;
    Eigen::Matrix4d world_from_cam = camera.cam_from_world.inverse().matrix();
    world_from_cam.col(1) *= -1;
    world_from_cam.col(2) *= -1;
    frame["transform_matrix"] = nlohmann::json::array();
    for (int i = 0; i < 4; ++i) {
      const Eigen::Vector4d row = world_from_cam.row(i).array() + 0.0;  // -0 becomes 0
      frame["transform_matrix"].push_back({row[0], row[1], row[2], row[3]});
    }
    out["frames"].push_back(std::move(frame));
  }
  write_json(file, out);
}

}  // namespace pliant

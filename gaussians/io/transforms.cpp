#include "gaussians/io/transforms.h"

#include <Eigen/SVD>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "gaussians/base/error.h"
#include "gaussians/io/image_io.h"
#include "gaussians/io/json_file.h"

namespace fs = std::filesystem;

namespace pliant {
namespace {

const std::vector<std::string> kDistortion = {"k1", "k2", "k3", "k4", "p1", "p2"};

/// The photo of a frame: below the folder of the file or in `photos`, suffix optional.  Empty when there is none.
fs::path find_photo(const fs::path& folder, const fs::path& photos, const std::string& file_path) {
  std::vector<fs::path> stems = {folder / file_path};
  if (!photos.empty()) stems.insert(stems.begin(), {photos / file_path, photos / fs::path(file_path).filename()});
  for (const fs::path& stem : stems) {
    for (const char* suffix : {"", ".png", ".jpg", ".jpeg", ".PNG", ".JPG", ".JPEG"}) {
      std::error_code ignored;
      const fs::path candidate = stem.string() + suffix;
      if (fs::is_regular_file(candidate, ignored)) return candidate.lexically_normal();
    }
  }
  return {};
}

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
  if ((world_from_cam.row(3) - Eigen::RowVector4d(0, 0, 0, 1)).norm() > 1e-6) throw refuse("has another last row");
  Eigen::Matrix3d rotation = world_from_cam.topLeftCorner<3, 3>();
  const double defect = (rotation.transpose() * rotation - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (!(defect < 1e-2) || rotation.determinant() < 0) throw refuse("does not begin with a rotation");
  if (defect > 1e-9) {
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(rotation, Eigen::ComputeFullU | Eigen::ComputeFullV);
    rotation = svd.matrixU() * svd.matrixV().transpose();
  }
  rotation.col(1) *= -1, rotation.col(2) *= -1;
  Eigen::Isometry3d cam_from_world = Eigen::Isometry3d::Identity();
  cam_from_world.linear() = rotation.transpose();
  cam_from_world.translation() = -rotation.transpose() * world_from_cam.topRightCorner<3, 1>();
  return cam_from_world;
}

/// Reads the frames of one file; values of a frame win over those of the whole file.
class Reader {
 public:
  Reader(const fs::path& file, const fs::path& photos)
      : file_(file), photos_(photos), json_(read_json(file)), top_(json_, file.string()) {}

  CameraFile read() {
    const nlohmann::json& frames = top_.array("frames");
    if (frames.empty()) throw top_.complaint("frames", "is empty", "a camera file needs at least one frame");
    for (size_t i = 0; i < frames.size(); ++i) read_frame(frames[i], i);
    result_.frames = static_cast<int>(frames.size());
    keep_frames_with_photos();
    make_names_unique();
    match_size_of_photos();
    if (!distorted_.empty()) {
      std::string keys;
      for (const std::string& key : distorted_) keys += (keys.empty() ? "" : ", ") + key;
      result_.warnings.push_back(file_.string() + ": lens distortion (" + keys +
                                 ") is ignored; undistort the photos for exact results");
    }
    return std::move(result_);
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
        throw object->complaint("camera_model", "is '" + model + "'", "only pinhole cameras are supported: undistort the photos");
      }
    }
    for (const std::string& key : kDistortion) {
      if (has(frame, key) && number(frame, key) != 0) distorted_.insert(key);
    }
    Camera camera;
    const std::string file_path = frame.text("file_path");
    camera.cam_from_world = read_pose(frame);
    camera.photo = find_photo(file_.parent_path(), photos_, file_path).string();
    camera.name = fs::path(file_path).stem().string();
    result_.photos_found += !camera.photo.empty();
    read_size(frame, camera);
    read_intrinsics(frame, camera);
    paths_.push_back(file_path);
    result_.cameras.push_back(std::move(camera));
  }

  void read_size(const JsonObject& frame, Camera& camera) {
    if (has(frame, "w") && has(frame, "h")) {
      const double w = number(frame, "w"), h = number(frame, "h");
      if (!(w >= 1 && w <= 65536 && h >= 1 && h <= 65536)) {
        throw frame.complaint(w >= 1 && w <= 65536 ? "h" : "w", "is out of range", "sizes are 1 to 65536 pixels");
      }
      camera.width = static_cast<int>(w), camera.height = static_cast<int>(h);
      return;
    }
    // Without sizes in the file the first photo tells them.
    if (photo_width_ == 0 && !camera.photo.empty()) {
      const ImageF photo = read_image(camera.photo);
      photo_width_ = photo.width, photo_height_ = photo.height;
    }
    camera.width = photo_width_, camera.height = photo_height_;
    if (camera.width == 0 && has(frame, "cx") && has(frame, "cy")) {
      camera.width = static_cast<int>(std::lround(std::clamp(2 * number(frame, "cx"), 0.0, 65536.0)));
      camera.height = static_cast<int>(std::lround(std::clamp(2 * number(frame, "cy"), 0.0, 65536.0)));
    }
    if (camera.width < 1 || camera.height < 1) {
      throw frame.complaint("w", "is missing and the photo does not exist", "add w and h");
    }
  }

  void read_intrinsics(const JsonObject& frame, Camera& camera) {
    if (has(frame, "fl_x")) {
      camera.fx = number(frame, "fl_x");
    } else if (has(frame, "camera_angle_x")) {
      const double angle = number(frame, "camera_angle_x");
      if (!(angle > 0 && angle < M_PI)) {
        throw frame.complaint("camera_angle_x", "is " + std::to_string(angle), "it must be between 0 and pi");
      }
      camera.fx = 0.5 * camera.width / std::tan(0.5 * angle);
    } else {
      throw frame.complaint("fl_x", "is missing, and so is camera_angle_x", "add the focal length in pixels");
    }
    camera.fy = has(frame, "fl_y") ? number(frame, "fl_y") : camera.fx;
    camera.cx = has(frame, "cx") ? number(frame, "cx") : 0.5 * camera.width;
    camera.cy = has(frame, "cy") ? number(frame, "cy") : 0.5 * camera.height;
    if (!(camera.fx > 0)) throw frame.complaint("fl_x", "is " + std::to_string(camera.fx), "it must be positive");
    if (!(camera.fy > 0)) throw frame.complaint("fl_y", "is " + std::to_string(camera.fy), "it must be positive");
  }

  void keep_frames_with_photos() {
    const int missing = result_.frames - result_.photos_found;
    if (missing == 0) return;
    if (result_.photos_found == 0) {
      result_.warnings.push_back(file_.string() + ": none of the " + std::to_string(missing) +
                                 " photos exists; the cameras are used without photos");
      return;
    }
    std::vector<Camera> cameras;
    std::vector<std::string> paths;
    for (size_t i = 0; i < result_.cameras.size(); ++i) {
      if (result_.cameras[i].photo.empty()) continue;
      cameras.push_back(std::move(result_.cameras[i])), paths.push_back(paths_[i]);
    }
    result_.cameras = std::move(cameras), paths_ = std::move(paths);
    result_.warnings.push_back(file_.string() + ": " + std::to_string(missing) + " of " +
                               std::to_string(result_.frames) + " frames name photos that do not exist; they are left out");
  }

  /// Cameras are found by name, so equal stems (train/r_0, test/r_0) take their folders into the name.
  void make_names_unique() {
    std::map<std::string, int> uses;
    for (const Camera& camera : result_.cameras) ++uses[camera.name];
    std::set<std::string> taken;
    for (size_t i = 0; i < result_.cameras.size(); ++i) {
      std::string& name = result_.cameras[i].name;
      if (uses[name] > 1) {
        name = fs::path(paths_[i]).lexically_normal().replace_extension().generic_string();
        for (char& c : name) c = c == '/' ? '_' : c;
      }
      if (name.empty() || !taken.insert(name).second) {
        throw input_error(file_.string(), "file_path", "'" + paths_[i] + "' names two frames", "give each frame its own photo");
      }
    }
  }

  /// Photos that were scaled after the camera file was written: the cameras follow the first photo.
  void match_size_of_photos() {
    if (result_.cameras.empty() || result_.cameras[0].photo.empty() || photo_width_ > 0) return;
    const ImageF photo = read_image(result_.cameras[0].photo);
    const Camera first = result_.cameras[0];
    if (photo.width == first.width && photo.height == first.height) return;
    const double scale = static_cast<double>(photo.width) / first.width;
    const std::string sizes = std::to_string(photo.width) + " x " + std::to_string(photo.height) + " pixels but the camera says " +
                              std::to_string(first.width) + " x " + std::to_string(first.height);
    if (std::abs(first.height * scale - photo.height) > 1.0) {
      throw input_error(first.photo, "", "has " + sizes, "use the photos that the cameras belong to");
    }
    for (Camera& camera : result_.cameras) camera = camera.scaled(scale);
    result_.warnings.push_back(first.photo + ": has " + sizes + "; the cameras are scaled to the photos");
  }

  fs::path file_, photos_;
  nlohmann::json json_;
  JsonObject top_;
  CameraFile result_;
  std::vector<std::string> paths_;
  std::set<std::string> distorted_;
  int photo_width_ = 0, photo_height_ = 0;
};

}  // namespace

CameraFile read_transforms(const fs::path& file, const fs::path& photos) { return Reader(file, photos).read(); }

void write_transforms(const fs::path& file, const std::vector<Camera>& cameras) {
  const auto intrinsics = [](const Camera& camera) {
    return nlohmann::json{{"w", camera.width}, {"h", camera.height}, {"fl_x", camera.fx},
                          {"fl_y", camera.fy}, {"cx", camera.cx},    {"cy", camera.cy}};
  };
  bool shared = !cameras.empty();
  for (const Camera& camera : cameras) shared = shared && intrinsics(camera) == intrinsics(cameras[0]);
  nlohmann::json out = shared ? intrinsics(cameras[0]) : nlohmann::json::object();
  out["camera_model"] = "PINHOLE";
  out["frames"] = nlohmann::json::array();
  const fs::path folder = fs::absolute(file).parent_path().lexically_normal();
  for (const Camera& camera : cameras) {
    nlohmann::json frame = shared ? nlohmann::json::object() : intrinsics(camera);
    frame["file_path"] = camera.photo.empty() ? camera.name
                             : fs::absolute(camera.photo).lexically_normal().lexically_proximate(folder).generic_string();
    Eigen::Matrix4d world_from_cam = camera.cam_from_world.inverse().matrix();
    world_from_cam.col(1) *= -1, world_from_cam.col(2) *= -1;
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

#include "gaussians/io/cameras/sparse_points.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>
#include <unordered_map>

#include "gaussians/base/lens.h"
#include "gaussians/io/cameras/camera_file.h"
#include "gaussians/io/cameras/cameras.h"
#include "gaussians/io/cameras/colmap_records.h"
#include "gaussians/io/cameras/ply_points.h"
#include "gaussians/io/files/byte_reader.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/files/json_file.h"

namespace fs = std::filesystem;

namespace pliant {
namespace {

constexpr uint64_t kPointBytes = 8 + 3 * 8 + 3 + 8 + 8;  // id, position, colour, error, length of the track

void add_point(SparsePoints& points, const double* position, const double* color, const std::string& file,
               const std::string& field) {
  const Vec3f x = Eigen::Map<const Vec3d>(position).cast<float>();
  if (!x.allFinite()) throw input_error(file, field, "has a position that is not finite", "the file is damaged");
  points.position.push_back(x);
  points.color.push_back((Eigen::Map<const Vec3d>(color).cast<float>() / 255).cwiseMax(0.0f).cwiseMin(1.0f));
}

/// Whether the path of a photo ends with the name that a model gives to it, `exactly` or whatever their suffixes.
bool ends_with_name(const std::string& photo, const std::string& name, bool exactly) {
  const auto compared = [exactly](const std::string& path) {
    const fs::path normal = with_slashes(path).lexically_normal();
    return "/" + (exactly ? normal : normal.parent_path() / name_of_photo(normal)).generic_string();
  };
  return compared(photo).ends_with(compared(name));
}

/// What turns rays of one camera into those of another that stands in the same place and looks the same way, as when
/// photos were rotated in their plane.  The identity for other poses, which are other readings of the same photo.
Eigen::Matrix3d turn_in_plane(const Camera& to, const Camera& from) {
  const Eigen::Matrix3d turn = to.cam_from_world.linear() * from.cam_from_world.linear().transpose();
  const double distance = (to.centre() - from.centre()).norm();
  const bool same = turn(2, 2) > 1 - 1e-6 && distance <= 1e-4 * std::max(to.centre().norm(), from.centre().norm());
  return same ? turn : Eigen::Matrix3d(Eigen::Matrix3d::Identity());
}

/// What the images of a COLMAP model say about the cameras that were passed.
class ColmapTracks {
 public:
  ColmapTracks(const fs::path& folder, const std::string& extension, const std::vector<Camera>& cameras)
      : cameras_(cameras) {
    for (size_t i = 0; i < cameras.size(); ++i) by_name_[cameras[i].name] = static_cast<int>(i);
    const auto lenses = read_colmap_cameras(folder / ("cameras" + extension), {});
    std::unordered_map<uint32_t, std::string> photo_of;
    for_each_colmap_image(folder / ("images" + extension), true, [&](const ColmapImage& image, const std::string&) {
      View& view = views_[image.id];
      view.points = image.points;
      const auto lens = lenses.find(image.camera);
      if (lens != lenses.end()) view.model = lens->second;
      view.model.cam_from_world = image.cam_from_world();
      ++uses_[name_of_photo(image.photo)];
      ++long_uses_[long_name_of_photo(image.photo)];
      photo_of[image.id] = image.photo;
    });
    for (const auto& [id, photo] : photo_of) {
      View& view = views_[id];
      view.camera = camera_of(photo);
      if (view.camera >= 0) view.turn = turn_in_plane(cameras[static_cast<size_t>(view.camera)], view.model);
    }
  }

  /// One whose image or feature is not there, as in models whose images were written anew, is left out.
  void add(uint32_t image, uint32_t index, const std::string& field, SparsePoints& points) {
    ++all_;
    const auto found = views_.find(image);
    if (found == views_.end())
      return leave_out(field + " is seen by the image " + std::to_string(image) + ", which does not exist");
    const View& view = found->second;
    if (index >= view.points.size())
      return leave_out(field + " is the feature " + std::to_string(index) + " of the image " + std::to_string(image) +
                       ", which has " + std::to_string(view.points.size()));
    if (view.camera < 0 || view.model.width == 0) return;
    // The same ray through the lens of the model and through that of the camera that was passed.
    const Camera& camera = cameras_[static_cast<size_t>(view.camera)];
    const auto ray = unproject(view.model, view.points[index]);
    if (!ray) return;
    const Eigen::Vector2d x = distort(camera.distortion, (view.turn * ray->homogeneous()).hnormalized());
    const Eigen::Vector2d pixel(camera.fx * x.x() + camera.cx, camera.fy * x.y() + camera.cy);
    points.observations.push_back({static_cast<int>(points.position.size()) - 1, view.camera, pixel.cast<float>()});
  }

  void warn(const std::string& file, SparsePoints& points) const {
    if (left_out_ > 0)
      points.warnings.push_back(file + ": " + std::to_string(left_out_) + " of " + std::to_string(all_) +
                                " observations do not match the images and are left out, the first: " + first_);
  }

 private:
  /// The camera of a photo, which bears its name as CameraCollector makes it unique; -1 = none.  Of photos that share a
  /// name one alone may be there: the camera of that name is its.
  int camera_of(const std::string& photo) const {
    const std::string name = name_of_photo(photo), long_name = long_name_of_photo(photo);
    const bool one_of_several = long_uses_.at(long_name) > 1;
    if (const auto full = by_name_.find(full_name_of_photo(photo)); one_of_several && full != by_name_.end())
      return full->second;
    for (const std::string& each : {long_name, name}) {
      const auto found = by_name_.find(each);
      if (found == by_name_.end()) continue;
      const bool shared = one_of_several || (each != long_name && uses_.at(name) > 1);
      const std::string& file = cameras_[static_cast<size_t>(found->second)].photo;
      return !shared || ends_with_name(file, photo, one_of_several) ? found->second : -1;
    }
    return -1;
  }

  void leave_out(const std::string& sentence) {
    if (left_out_++ == 0) first_ = sentence;
  }

  struct View {
    int camera = -1;
    Camera model;                                        ///< to which the features refer
    Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();  ///< of its rays into the camera that was passed
    std::vector<Eigen::Vector2d> points;
  };

  const std::vector<Camera>& cameras_;
  std::unordered_map<std::string, int> by_name_;           // of the cameras
  std::unordered_map<std::string, int> uses_, long_uses_;  // of the names of photos, without and with their folders
  std::unordered_map<uint32_t, View> views_;
  size_t all_ = 0, left_out_ = 0;
  std::string first_;  // that was left out
};

void read_binary_points(const fs::path& path, ColmapTracks& tracks, SparsePoints& points) {
  const std::string bytes = read_text(path);
  ByteReader in(bytes, path.string());
  const auto count = in.take<uint64_t>("number of points");
  in.expect(count, kPointBytes, "number of points");
  points.position.reserve(count);
  points.color.reserve(count);
  for (uint64_t i = 0; i < count; ++i) {
    const std::string field = "point " + std::to_string(in.take<uint64_t>("point id"));
    double position[3], color[3];
    for (double& value : position) value = in.take<double>(field);
    for (double& value : color) value = in.take<uint8_t>(field);
    in.take<double>(field);  // the mean reprojection error
    add_point(points, position, color, in.file(), field);
    const auto length = in.take<uint64_t>(field);
    in.expect(length, 8, field + ": length of the track");
    for (uint64_t k = 0; k < length; ++k) {
      const auto image = in.take<uint32_t>(field), index = in.take<uint32_t>(field);
      tracks.add(image, index, field, points);
    }
  }
}

void read_text_points(const fs::path& path, ColmapTracks& tracks, SparsePoints& points) {
  std::istringstream in(read_text(path));
  std::string line;
  for (int number = 0; next_colmap_line(in, line, number);) {
    if (line.find_first_not_of(" \t") == std::string::npos) continue;
    const std::string field = "line " + std::to_string(number);
    std::istringstream words(line);
    uint64_t id;
    double position[3], color[3], error;
    words >> id;
    for (double& value : position) words >> value;
    for (double& value : color) words >> value;
    if (!(words >> error)) {
      throw input_error(path.string(), field, "is '" + line.substr(0, 60) + "'",
                        "it must be: id, x, y, z, r, g, b, error, track");
    }
    add_point(points, position, color, path.string(), field);
    for (uint32_t image, index; words >> image;) {
      if (!(words >> index)) throw input_error(path.string(), field, "ends inside a track", "the file is truncated");
      tracks.add(image, index, field, points);
    }
    if (!words.eof())
      throw input_error(path.string(), field, "has a track that is not numbers", "it must be: image, feature, ...");
  }
}

void read_colmap_points(const fs::path& file, const std::vector<Camera>& cameras, SparsePoints& points) {
  const std::string extension = file.extension();
  ColmapTracks tracks(file.parent_path(), extension, cameras);
  if (extension == ".bin")
    read_binary_points(file, tracks, points);
  else
    read_text_points(file, tracks, points);
  tracks.warn(file.string(), points);
  points.file = file;
  points.source = std::to_string(points.position.size()) + " points of " + file.string();
}

/// Where the points of a camera file or COLMAP model are, or in a sentence why there are none.
struct PointsPlace {
  fs::path file;
  std::string none;
  bool colmap = false;
};
PointsPlace points_place(const fs::path& path) {
  std::error_code ignored;
  fs::path at = cameras_at(path);
  if (at.empty() && fs::is_directory(path, ignored)) at = cameras_in(path);
  if (fs::is_directory(at, ignored)) {
    const std::string name = "points3D" + colmap_extension(at);
    if (fs::is_regular_file(at / name, ignored)) return {at / name, "", true};
    return {{}, at.string() + " holds no " + name, true};
  }
  const std::string without = at.string() + " comes without points";
  if (at.extension() != ".json") return {{}, without};
  const nlohmann::json json = read_json(at);
  if (!json.is_object() || !json.contains("ply_file_path")) return {{}, without};
  const std::string name = JsonObject(json, at.string(), "", Failure::kInput).text("ply_file_path");
  const fs::path file = at.parent_path() / name, slashed = at.parent_path() / with_slashes(name);
  for (const fs::path& place : {file, slashed})
    if (fs::is_regular_file(place, ignored)) return {place, ""};
  return {{}, at.string() + " names the points " + file.string() + ", which do not exist"};
}

}  // namespace

fs::path sparse_points_file(const fs::path& path) { return points_place(path).file; }

SparsePoints read_sparse_points(const fs::path& path, const std::vector<Camera>& cameras) {
  const PointsPlace place = points_place(path);
  if (!place.file.empty() && !place.colmap) return read_ply_points(place.file);
  SparsePoints points;
  if (place.file.empty())
    points.source = place.none;
  else
    read_colmap_points(place.file, cameras, points);
  return points;
}

}  // namespace pliant

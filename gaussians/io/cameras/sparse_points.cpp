#include "gaussians/io/cameras/sparse_points.h"

#include <algorithm>
#include <cmath>
#include <fstream>
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
#include "gaussians/io/splats/ply_header.h"
#include "gaussians/io/splats/ply_rows.h"

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

/// Whether the path of a photo ends with the name that a model gives to it, whatever their suffixes.
bool ends_with_name(const std::string& photo, const std::string& name) {
  const auto without_suffix = [](std::string path) {
    std::replace(path.begin(), path.end(), '\\', '/');
    const fs::path normal = fs::path(path).lexically_normal();
    return "/" + (normal.parent_path() / name_of_photo(normal)).generic_string();
  };
  const std::string whole = without_suffix(photo), end = without_suffix(name);
  return whole.size() >= end.size() && whole.compare(whole.size() - end.size(), end.size(), end) == 0;
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
    std::unordered_map<std::string, int> by_name;
    for (size_t i = 0; i < cameras.size(); ++i) by_name[cameras[i].name] = static_cast<int>(i);
    const auto lenses = read_colmap_cameras(folder / ("cameras" + extension));
    std::unordered_map<std::string, int> uses;  // of the names of photos without their folders
    std::unordered_map<uint32_t, std::string> photo_of;
    for_each_colmap_image(folder / ("images" + extension), true, [&](const ColmapImage& image, const std::string&) {
      View& view = views_[image.id];
      view.points = image.points;
      const auto lens = lenses.find(image.camera);
      if (lens != lenses.end()) view.model = lens->second;
      view.model.cam_from_world = image.cam_from_world();
      ++uses[name_of_photo(image.photo)];
      photo_of[image.id] = image.photo;
    });
    for (const auto& [id, photo] : photo_of) {
      const std::string name = name_of_photo(photo);
      auto found = by_name.find(long_name_of_photo(photo));
      // Of photos in several folders that have one name, one alone may be there: the camera of that name is its.
      if (found == by_name.end()) {
        found = by_name.find(name);
        if (found != by_name.end() && uses[name] > 1 &&
            !ends_with_name(cameras[static_cast<size_t>(found->second)].photo, photo))
          found = by_name.end();
      }
      if (found == by_name.end()) continue;
      View& view = views_[id];
      view.camera = found->second;
      view.turn = turn_in_plane(cameras[static_cast<size_t>(view.camera)], view.model);
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
  const fs::path file = at.parent_path() / JsonObject(json, at.string(), "", Failure::kInput).text("ply_file_path");
  if (fs::is_regular_file(file, ignored)) return {file, ""};
  return {{}, at.string() + " names the points " + file.string() + ", which do not exist"};
}

}  // namespace

SparsePoints read_ply_points(const fs::path& file) {
  SparsePoints points;
  std::ifstream in(file, std::ios::binary);
  if (!in) throw input_error(file.string(), "", "cannot be opened", "check its permissions");
  const PlyHeader header = read_ply_header(in, file);
  const PlyElement* vertex = header.find("vertex");
  int column[6];
  const char* names[] = {"x", "y", "z", "red", "green", "blue"};
  for (int k = 0; k < 6; ++k) {
    column[k] = vertex ? vertex->find(names[k]) : -1;
    if (k < 3 && column[k] < 0)
      throw input_error(file.string(), std::string("property ") + names[k], "is missing", "give a point cloud");
  }
  if (vertex->has_list()) throw input_error(file.string(), "element vertex", "holds a list", "give a point cloud");
  for (const PlyElement& element : header.elements) {
    PlyRows rows(in, header, element, file.string(), fs::file_size(file));
    if (&element != vertex) {
      rows.skip();
      continue;
    }
    rows.check_size();
    const bool colored = column[3] >= 0 && column[4] >= 0 && column[5] >= 0;
    const bool bytes = colored && vertex->properties[column[3]].type == PlyType::kUint8;
    rows.for_each_row([&](const float* row) {
      double position[3], color[3];
      for (int k = 0; k < 3; ++k) {
        position[k] = row[column[k]];
        color[k] = colored ? row[column[3 + k]] * (bytes ? 1.0 : 255.0) : 127.5;
      }
      add_point(points, position, color, file.string(), "vertex " + std::to_string(points.position.size()));
    });
    break;
  }
  points.file = file;
  points.source = std::to_string(points.position.size()) + " points of " + file.string();
  return points;
}

void write_ply_points(const fs::path& file, const SparsePoints& points) {
  std::string bytes = "ply\nformat binary_little_endian 1.0\nelement vertex " + std::to_string(points.position.size()) +
                      "\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\n"
                      "property uchar green\nproperty uchar blue\nend_header\n";
  for (size_t i = 0; i < points.position.size(); ++i) {
    bytes.append(reinterpret_cast<const char*>(points.position[i].data()), 3 * sizeof(float));
    for (int c = 0; c < 3; ++c) bytes.push_back(static_cast<char>(std::lround(255 * points.color[i][c])));
  }
  write_text(file, bytes);
}

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

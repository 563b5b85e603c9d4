#include "gaussians/io/colmap.h"

#include <Eigen/Geometry>
#include <map>
#include <sstream>

#include "gaussians/io/byte_reader.h"
#include "gaussians/io/files.h"

namespace fs = std::filesystem;

namespace pliant {
namespace {

/// Camera models in the order of COLMAP's ids.  `supported` ones are a pinhole with radial or tangential distortion.
struct Model {
  const char* name;
  int parameters;
  bool supported;
};
constexpr Model kModels[] = {
    {"SIMPLE_PINHOLE", 3, true},
    {"PINHOLE", 4, true},
    {"SIMPLE_RADIAL", 4, true},
    {"RADIAL", 5, true},
    {"OPENCV", 8, true},
    {"OPENCV_FISHEYE", 8, false},
    {"FULL_OPENCV", 12, false},
    {"FOV", 5, false},
    {"SIMPLE_RADIAL_FISHEYE", 4, false},
    {"RADIAL_FISHEYE", 5, false},
    {"THIN_PRISM_FISHEYE", 12, false},
};

/// The camera of one record, without a pose.
Camera camera_of(const Model& model, uint64_t width, uint64_t height, const std::vector<double>& p,
                 const std::string& file, const std::string& field) {
  if (width < 1 || width > 65536 || height < 1 || height > 65536) {
    throw input_error(file, field, "has the size " + std::to_string(width) + " x " + std::to_string(height),
                      "sizes are 1 to 65536 pixels");
  }
  for (double value : p) {
    if (!std::isfinite(value))
      throw input_error(file, field, "holds values that are not finite", "the file is damaged");
  }
  Camera camera;
  camera.width = static_cast<int>(width), camera.height = static_cast<int>(height);
  const std::string name = model.name;
  const bool two_focals = name == "PINHOLE" || name == "OPENCV";
  size_t at = 0;
  camera.fx = p[at++];
  camera.fy = two_focals ? p[at++] : camera.fx;
  camera.cx = p[at++], camera.cy = p[at++];
  for (size_t k = 0; at < p.size(); ++k) camera.distortion[k] = p[at++];
  if (!(camera.fx > 0 && camera.fy > 0)) {
    throw input_error(file, field, "has the focal length " + std::to_string(std::min(camera.fx, camera.fy)),
                      "it must be positive");
  }
  return camera;
}

const Model& checked_model(const Model* model, const std::string& name, const std::string& file,
                           const std::string& field) {
  if (model && model->supported) return *model;
  throw input_error(
      file, field, "has the camera model " + (model ? std::string(model->name) : name),
      "SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL and OPENCV are read; undistort first: colmap image_undistorter");
}

/// Pose and photo name of one record.
struct Pose {
  double q[4], t[3];  // world to camera, q = w, x, y, z
  uint32_t camera = 0;
  std::string photo;
};

void add_frame(const Pose& pose, const std::map<uint32_t, Camera>& cameras, const fs::path& folder,
               const fs::path& photos, const std::string& file, const std::string& field, CameraCollector& collector) {
  const auto found = cameras.find(pose.camera);
  if (found == cameras.end()) {
    throw input_error(file, field, "names the camera " + std::to_string(pose.camera) + ", which does not exist",
                      "the files do not belong together");
  }
  Eigen::Quaterniond q(pose.q[0], pose.q[1], pose.q[2], pose.q[3]);
  const Eigen::Vector3d t(pose.t[0], pose.t[1], pose.t[2]);
  if (!q.coeffs().allFinite() || !(q.norm() > 1e-6) || !t.allFinite()) {
    throw input_error(file, field, "has no pose: a zero quaternion or values that are not finite",
                      "the file is damaged");
  }
  Camera camera = found->second;
  camera.cam_from_world.linear() = q.normalized().toRotationMatrix();
  camera.cam_from_world.translation() = t;
  const fs::path around = folder / "..", above = folder / "../..";
  camera.photo =
      find_photo(photos, {folder / "images", around / "images", above / "images", folder, around, above}, pose.photo)
          .string();
  collector.add(std::move(camera), pose.photo);
}

std::map<uint32_t, Camera> read_binary_cameras(const fs::path& path) {
  const std::string bytes = read_text(path);
  ByteReader in(bytes, path.string());
  const auto count = in.take<uint64_t>("number of cameras");
  in.expect(count, 4 + 4 + 8 + 8 + 3 * 8, "number of cameras");
  std::map<uint32_t, Camera> cameras;
  for (uint64_t i = 0; i < count; ++i) {
    const auto id = in.take<uint32_t>("camera id");
    const std::string field = "camera " + std::to_string(id);
    const auto model_id = in.take<int32_t>(field);
    const bool known = model_id >= 0 && model_id < static_cast<int>(std::size(kModels));
    const Model& model =
        checked_model(known ? &kModels[model_id] : nullptr, std::to_string(model_id), in.file(), field);
    const auto width = in.take<uint64_t>(field), height = in.take<uint64_t>(field);
    std::vector<double> parameters;
    for (int k = 0; k < model.parameters; ++k) parameters.push_back(in.take<double>(field));
    if (!cameras.emplace(id, camera_of(model, width, height, parameters, in.file(), field)).second) {
      throw input_error(in.file(), field, "occurs twice", "the file is damaged");
    }
  }
  return cameras;
}

/// Calls use(pose, field) for every image.
template <class Use>
void read_binary_images(const fs::path& path, Use&& use) {
  const std::string bytes = read_text(path);
  ByteReader in(bytes, path.string());
  const auto count = in.take<uint64_t>("number of images");
  in.expect(count, 4 + 7 * 8 + 4 + 1 + 8, "number of images");
  for (uint64_t i = 0; i < count; ++i) {
    const std::string field = "image " + std::to_string(in.take<uint32_t>("image id"));
    Pose pose;
    for (double& value : pose.q) value = in.take<double>(field);
    for (double& value : pose.t) value = in.take<double>(field);
    pose.camera = in.take<uint32_t>(field);
    pose.photo = std::string(in.take_text(field));
    const auto points = in.take<uint64_t>(field);
    in.expect(points, 24, field + ": number of points");
    in.take_bytes(points * 24, field);
    use(pose, field);
  }
}

/// The next line that is no comment; false at the end.
bool next_line(std::istringstream& in, std::string& line, int& number) {
  while (std::getline(in, line)) {
    ++number;
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (line.empty() || line[0] != '#') return true;
  }
  return false;
}

std::map<uint32_t, Camera> read_text_cameras(const fs::path& path) {
  std::istringstream in(read_text(path));
  std::map<uint32_t, Camera> cameras;
  std::string line;
  for (int number = 0; next_line(in, line, number);) {
    if (line.find_first_not_of(" \t") == std::string::npos) continue;
    std::istringstream words(line);
    const std::string field = "line " + std::to_string(number);
    uint32_t id;
    std::string name;
    uint64_t width, height;
    if (!(words >> id >> name >> width >> height)) {
      throw input_error(path.string(), field, "is '" + line.substr(0, 60) + "'",
                        "it must be: id, model, width, height, parameters");
    }
    const Model* found = nullptr;
    for (const Model& model : kModels) found = name == model.name ? &model : found;
    const Model& model = checked_model(found, name, path.string(), field);
    std::vector<double> parameters(static_cast<size_t>(model.parameters));
    for (double& value : parameters) {
      if (!(words >> value)) {
        throw input_error(path.string(), field, "has too few parameters",
                          name + " has " + std::to_string(model.parameters));
      }
    }
    if (!cameras.emplace(id, camera_of(model, width, height, parameters, path.string(), field)).second) {
      throw input_error(path.string(), field, "repeats the camera " + std::to_string(id), "the file is damaged");
    }
  }
  return cameras;
}

/// Calls use(pose, field) for every image; each has a second line with its points, which may be empty.
template <class Use>
void read_text_images(const fs::path& path, Use&& use) {
  std::istringstream in(read_text(path));
  std::string line, points;
  for (int number = 0; next_line(in, line, number);) {
    if (line.find_first_not_of(" \t") == std::string::npos) continue;
    std::istringstream words(line);
    const std::string field = "line " + std::to_string(number);
    Pose pose;
    uint32_t id;
    words >> id;
    for (double& value : pose.q) words >> value;
    for (double& value : pose.t) words >> value;
    if (!(words >> pose.camera >> std::ws) || !std::getline(words, pose.photo) || pose.photo.empty()) {
      throw input_error(path.string(), field, "is '" + line.substr(0, 60) + "'",
                        "it must be: id, qw, qx, qy, qz, tx, ty, tz, camera, name");
    }
    use(pose, field);
    next_line(in, points, number);
  }
}

bool has_pair(const fs::path& folder, const std::string& extension) {
  std::error_code ignored;
  return fs::is_regular_file(folder / ("cameras" + extension), ignored) &&
         fs::is_regular_file(folder / ("images" + extension), ignored);
}

}  // namespace

bool is_colmap(const fs::path& folder) { return has_pair(folder, ".bin") || has_pair(folder, ".txt"); }

CameraFile read_colmap(const fs::path& folder, const fs::path& photos) {
  const bool binary = has_pair(folder, ".bin");
  if (!binary && !has_pair(folder, ".txt")) {
    throw input_error(folder.string(), "", "holds no cameras.bin and images.bin (or .txt)",
                      "name a COLMAP model, for example sparse/0");
  }
  const std::string extension = binary ? ".bin" : ".txt";
  const fs::path cameras_file = folder / ("cameras" + extension), images_file = folder / ("images" + extension);
  const std::map<uint32_t, Camera> cameras =
      binary ? read_binary_cameras(cameras_file) : read_text_cameras(cameras_file);
  CameraCollector collector(images_file);
  bool any = false;
  const auto use = [&](const Pose& pose, const std::string& field) {
    add_frame(pose, cameras, folder, photos, images_file.string(), field, collector);
    any = true;
  };
  if (binary)
    read_binary_images(images_file, use);
  else
    read_text_images(images_file, use);
  if (!any) throw input_error(images_file.string(), "", "holds no image", "name a model with registered images");
  CameraFile result = collector.finish(binary ? "COLMAP binary" : "COLMAP text");
  result.files.push_back(cameras_file);
  return result;
}

}  // namespace pliant

#include "gaussians/io/cameras/colmap_records.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>

#include "gaussians/io/files/byte_reader.h"
#include "gaussians/io/files/files.h"

namespace fs = std::filesystem;

namespace pliant {
namespace {

constexpr uint64_t kImagePointBytes = 24;  // x, y as doubles and the id of the point in space
constexpr uint64_t kImageBytes =
    4 + 7 * 8 + 4 + 1 + 8;  // at least: id, pose, camera, end of the name, number of points

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
  camera.width = static_cast<int>(width);
  camera.height = static_cast<int>(height);
  const std::string name = model.name;
  const bool two_focals = name == "PINHOLE" || name == "OPENCV";
  size_t at = 0;
  camera.fx = p[at++];
  camera.fy = two_focals ? p[at++] : camera.fx;
  camera.cx = p[at++];
  camera.cy = p[at++];
  for (size_t k = 0; at < p.size(); ++k) camera.distortion[k] = p[at++];
  if (!(camera.fx > 0 && camera.fy > 0)) {
    throw input_error(file, field, "has the focal length " + std::to_string(std::min(camera.fx, camera.fy)),
                      "it must be positive");
  }
  return camera;
}

/// Refuses a model that is unknown, and one that is not read where the camera is `needed`.
const Model& checked_model(const Model* model, bool needed, const std::string& name, const std::string& file,
                           const std::string& field) {
  if (model && (model->supported || !needed)) return *model;
  throw input_error(
      file, field, "has the camera model " + (model ? std::string(model->name) : name),
      "SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL and OPENCV are read; undistort first: colmap image_undistorter");
}

std::map<uint32_t, Camera> read_binary_cameras(const fs::path& path, const std::set<uint32_t>& needed) {
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
    const Model& model = checked_model(known ? &kModels[model_id] : nullptr, needed.count(id) > 0,
                                       std::to_string(model_id), in.file(), field);
    const auto width = in.take<uint64_t>(field), height = in.take<uint64_t>(field);
    std::vector<double> parameters;
    for (int k = 0; k < model.parameters; ++k) parameters.push_back(in.take<double>(field));
    if (!model.supported) continue;
    if (!cameras.emplace(id, camera_of(model, width, height, parameters, in.file(), field)).second) {
      throw input_error(in.file(), field, "occurs twice", "the file is damaged");
    }
  }
  return cameras;
}

void read_binary_images(const fs::path& path, bool with_points, const UseColmapImage& use) {
  const std::string bytes = read_text(path);
  ByteReader in(bytes, path.string());
  const auto count = in.take<uint64_t>("number of images");
  in.expect(count, kImageBytes, "number of images");
  for (uint64_t i = 0; i < count; ++i) {
    ColmapImage image;
    image.id = in.take<uint32_t>("image id");
    const std::string field = "image " + std::to_string(image.id);
    for (double& value : image.q) value = in.take<double>(field);
    for (double& value : image.t) value = in.take<double>(field);
    image.camera = in.take<uint32_t>(field);
    image.photo = std::string(in.take_text(field));
    const auto points = in.take<uint64_t>(field);
    in.expect(points, kImagePointBytes, field + ": number of points");
    ByteReader rows(in.take_bytes(points * kImagePointBytes, field), in.file());
    for (uint64_t k = 0; with_points && k < points; ++k) {
      const auto x = rows.take<double>(field), y = rows.take<double>(field);
      image.points.emplace_back(x, y);
      rows.take<int64_t>(field);  // the point in space, which points3D tells too
    }
    use(image, field);
  }
}

std::map<uint32_t, Camera> read_text_cameras(const fs::path& path, const std::set<uint32_t>& needed) {
  std::istringstream in(read_text(path));
  std::map<uint32_t, Camera> cameras;
  std::string line;
  for (int number = 0; next_colmap_line(in, line, number);) {
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
    const Model& model = checked_model(found, needed.count(id) > 0, name, path.string(), field);
    if (!model.supported) continue;
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

/// x, y, id of every point of an image.  In a file without the lines of points the next image stands here, which must
/// not be lost without a word.
void read_text_points(const std::string& line, const std::string& file, const std::string& field, ColmapImage& image) {
  const std::string remedy =
      "an image takes two lines: its pose and name, then x, y, id of each of its points, which is an empty line where "
      "there are none";
  const char *at = line.data(), *const end = at + line.size();
  const auto skip_space = [&] {
    while (at != end && (*at == ' ' || *at == '\t')) ++at;
  };
  double point[3];
  int known = 0;
  for (skip_space(); at != end; skip_space()) {
    const auto [behind, failed] = std::from_chars(at + (*at == '+' ? 1 : 0), end, point[known]);
    if (failed == std::errc::invalid_argument || (behind != end && *behind != ' ' && *behind != '\t')) {
      const std::string word(at, std::find_if(at, end, [](char c) { return c == ' ' || c == '\t'; }));
      throw input_error(file, field, "holds '" + word.substr(0, 60) + "' where the points of an image are expected",
                        remedy);
    }
    at = behind;
    known = (known + 1) % 3;
    if (known == 0) image.points.emplace_back(point[0], point[1]);
  }
  if (known != 0) throw input_error(file, field, "ends inside a point", remedy);
}

/// Each image has a second line with its points, which may be empty.
void read_text_images(const fs::path& path, bool with_points, const UseColmapImage& use) {
  std::istringstream in(read_text(path));
  std::string line, points;
  for (int number = 0; next_colmap_line(in, line, number);) {
    if (line.find_first_not_of(" \t") == std::string::npos) continue;
    std::istringstream words(line);
    const std::string field = "line " + std::to_string(number);
    ColmapImage image;
    words >> image.id;
    for (double& value : image.q) words >> value;
    for (double& value : image.t) words >> value;
    if (!(words >> image.camera >> std::ws) || !std::getline(words, image.photo) || image.photo.empty()) {
      throw input_error(path.string(), field, "is '" + line.substr(0, 60) + "'",
                        "it must be: id, qw, qx, qy, qz, tx, ty, tz, camera, name");
    }
    points.clear();
    next_colmap_line(in, points, number);
    read_text_points(points, path.string(), "line " + std::to_string(number), image);
    if (!with_points) image.points.clear();
    use(image, field);
  }
}

bool has_pair(const fs::path& folder, const std::string& extension) {
  std::error_code ignored;
  return fs::is_regular_file(folder / ("cameras" + extension), ignored) &&
         fs::is_regular_file(folder / ("images" + extension), ignored);
}

}  // namespace

bool next_colmap_line(std::istringstream& in, std::string& line, int& number) {
  while (std::getline(in, line)) {
    ++number;
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (line.empty() || line[0] != '#') return true;
  }
  return false;
}

std::string colmap_extension(const fs::path& folder) {
  return has_pair(folder, ".bin") ? ".bin" : has_pair(folder, ".txt") ? ".txt" : "";
}

std::map<uint32_t, Camera> read_colmap_cameras(const fs::path& file, const std::set<uint32_t>& needed) {
  return file.extension() == ".bin" ? read_binary_cameras(file, needed) : read_text_cameras(file, needed);
}

uint64_t count_colmap_images(const fs::path& file) {
  uint64_t count = 0;
  if (file.extension() == ".bin") {
    std::ifstream(file, std::ios::binary).read(reinterpret_cast<char*>(&count), sizeof count);
    std::error_code failed;
    const uint64_t size = fs::file_size(file, failed);
    return failed || count > size / kImageBytes ? 0 : count;
  }
  std::istringstream in(read_text(file));
  std::string line;
  for (int number = 0; next_colmap_line(in, line, number);) {
    if (line.find_first_not_of(" \t") == std::string::npos) continue;
    ++count;
    next_colmap_line(in, line, number);  // its points
  }
  return count;
}

void for_each_colmap_image(const fs::path& file, bool with_points, const UseColmapImage& use) {
  if (file.extension() == ".bin")
    read_binary_images(file, with_points, use);
  else
    read_text_images(file, with_points, use);
}

}  // namespace pliant

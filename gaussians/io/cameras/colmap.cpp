#include "gaussians/io/cameras/colmap.h"

#include <Eigen/Geometry>
#include <charconv>

#include "gaussians/base/error.h"
#include "gaussians/io/cameras/colmap_records.h"

namespace fs = std::filesystem;

namespace pliant {
namespace {

void add_frame(const ColmapImage& image, const std::map<uint32_t, Camera>& cameras, const fs::path& folder,
               const fs::path& photos, PhotoFit fit, const std::string& file, const std::string& field,
               CameraCollector& collector) {
  const auto found = cameras.find(image.camera);
  if (found == cameras.end()) {
    throw input_error(file, field, "names the camera " + std::to_string(image.camera) + ", which does not exist",
                      "the files do not belong together");
  }
  Eigen::Quaterniond q(image.q[0], image.q[1], image.q[2], image.q[3]);
  const Eigen::Vector3d t(image.t[0], image.t[1], image.t[2]);
  if (!q.coeffs().allFinite() || !(q.norm() > 1e-6) || !t.allFinite()) {
    throw input_error(file, field, "has no pose: a zero quaternion or values that are not finite",
                      "the file is damaged");
  }
  Camera camera = found->second;
  camera.cam_from_world = image.cam_from_world();
  std::vector<fs::path> folders;
  for (const char* name : {"images", "", "images_2", "images_4", "images_8"})  // the last three: scaled photos alone
    for (const fs::path& at : {folder, folder / "..", folder / "../..", folder / "../../.."})
      folders.push_back(at / name);
  camera.photo = find_photo(photos, folders, image.photo, fit).string();
  collector.add(std::move(camera), image.photo);
}

}  // namespace

bool is_colmap(const fs::path& folder) { return !colmap_extension(folder).empty(); }

std::vector<NumberedModel> numbered_models_in(const fs::path& folder) {
  std::map<uint32_t, fs::path> numbered;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder, ignored)) {
    const std::string name = entry.path().filename().string();
    uint32_t number = 0;
    const auto [end, failed] = std::from_chars(name.data(), name.data() + name.size(), number);
    if (failed == std::errc() && end == name.data() + name.size() && is_colmap(entry.path()))
      numbered.emplace(number, entry.path());
  }
  std::vector<NumberedModel> models;
  for (const auto& [number, path] : numbered)
    models.push_back({path, count_colmap_images(path / ("images" + colmap_extension(path)))});
  return models;
}

CameraFile read_colmap(const fs::path& folder, const fs::path& photos, PhotoFit fit) {
  const std::string extension = colmap_extension(folder);
  if (extension.empty()) {
    throw input_error(folder.string(), "", "contains no cameras.bin and images.bin (or .txt)",
                      "give a COLMAP model, for example sparse/0");
  }
  const fs::path cameras_file = folder / ("cameras" + extension), images_file = folder / ("images" + extension);
  std::vector<std::pair<ColmapImage, std::string>> images;
  std::set<uint32_t> used;
  for_each_colmap_image(images_file, false, [&](const ColmapImage& image, const std::string& field) {
    images.emplace_back(image, field);
    used.insert(image.camera);
  });
  const std::map<uint32_t, Camera> cameras = read_colmap_cameras(cameras_file, used);
  CameraCollector collector(images_file, fit);
  for (const auto& [image, field] : images)
    add_frame(image, cameras, folder, photos, fit, images_file.string(), field, collector);
  if (images.empty())
    throw input_error(images_file.string(), "", "contains no images", "give a model with registered images");
  CameraFile result = collector.finish(extension == ".bin" ? "COLMAP binary" : "COLMAP text");
  result.files.push_back(cameras_file);
  return result;
}

}  // namespace pliant

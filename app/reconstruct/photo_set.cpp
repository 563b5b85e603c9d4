#include "app/reconstruct/photo_set.h"

#include <fmt/format.h>

#include <algorithm>

#include "gaussians/base/error.h"
#include "gaussians/io/cameras/cameras.h"
#include "gaussians/io/files/json_file.h"
#include "gaussians/io/images/image_files.h"
#include "gaussians/io/splats/ply.h"
#include "gaussians/io/splats/splats.h"

namespace pliant {
namespace fs = std::filesystem;

namespace {

size_t photos_in(const fs::path& folder) { return images_in(folder).size(); }

/// Where the photos of a folder without cameras are.
fs::path folder_of_photos(const fs::path& folder) {
  for (const char* name : {"images", "photos", "input"})
    if (photos_in(folder / name) > 0) return folder / name;
  return folder;
}

/// Photos in formats that are not read (HEIC and others) in a folder and where its photos may be.
std::vector<fs::path> unread_photos_of(const fs::path& folder) {
  std::vector<fs::path> found;
  std::error_code ignored;
  for (const char* name : {"", "images", "photos", "input"})
    for (const auto& entry : fs::directory_iterator(folder / name, ignored))
      if (is_unread_photo_file(entry.path())) found.push_back(entry.path());
  return found;
}

Error no_cameras(const fs::path& source) {
  const fs::path photos = folder_of_photos(source);
  const std::string folder = source.string();
  const size_t count = photos_in(photos);
  const std::vector<fs::path> unread = unread_photos_of(source);
  if (count == 0 && !unread.empty()) {
    const std::string extension = unread[0].extension().string();
    return input_error(folder, "",
                       fmt::format("contains {} photos in a format that is not read ({})", unread.size(), extension),
                       fmt::format("convert them, for example with `mogrify -auto-orient -format jpg {}/*{}` "
                                   "(apt install imagemagick), then repeat the command",
                                   unread[0].parent_path().string(), extension));
  }
  if (count == 0)
    return input_error(folder, "", "contains neither photos nor cameras", "check the name of the folder of the photos");
  return input_error(
      folder, "",
      fmt::format("contains {} photos but no cameras (transforms.json, COLMAP model, cameras.json, *_par.txt)", count),
      fmt::format("get them with `colmap automatic_reconstructor --workspace_path {} --image_path {} --dense 0 "
                  "--use_gpu 0` (apt install colmap), then repeat the command",
                  folder, photos.string()));
}

/// Where a photo was looked for that is missing.
std::string sought(const PhotoSet& set, const CameraFile& file) {
  std::error_code ignored;
  const bool model = fs::is_directory(set.cameras, ignored);
  return fmt::format("'{}' was looked for {}{} {}", file.missing_photo,
                     set.photos.empty() ? "" : fmt::format("in {} and ", set.photos.string()),
                     model ? "in the folders around" : "beside", set.cameras.string());
}

}  // namespace

PhotoSet find_photo_set(const fs::path& source, const fs::path& photos, const std::vector<fs::path>& splats) {
  PhotoSet set;
  set.source = source;
  std::error_code ignored;
  if (!fs::exists(source, ignored))
    throw input_error(source.string(), "", "does not exist", "check the name of the photos");
  const bool folder = fs::is_directory(source, ignored);
  const fs::path scene = folder ? source / "scene.json" : source.filename() == "scene.json" ? source : fs::path();
  if (!scene.empty() && fs::is_regular_file(scene, ignored)) {
    set.scene = read_json(scene);
    set.settings = read_scene_file(scene);
    set.cameras = set.settings.cameras;
    set.photos = set.settings.photos;
    if (set.cameras.empty()) set.cameras = cameras_in(scene.parent_path(), ColmapChoice::kLargest);
  } else {
    set.cameras = cameras_at(source);
    if (set.cameras.empty() && folder) set.cameras = cameras_in(source, ColmapChoice::kLargest);
  }
  const bool of_splats = set.cameras.empty() && !splats.empty();
  if (of_splats) set.cameras = cameras_of_splats(splats.front());
  if (!photos.empty()) {
    if (!fs::is_directory(photos, ignored))
      throw usage_error("--photos", photos.string(), "is not a folder", "give the folder of the photos");
    set.photos = photos;
  } else if (set.photos.empty() && folder && !of_splats) {
    set.photos = source;
  }
  if (!set.cameras.empty()) return set;
  if (folder || !scene.empty()) throw no_cameras(folder ? source : source.parent_path());
  throw input_error(
      source.string(), "", "contains no known cameras",
      "give a folder with photos and cameras, or a transforms.json, cameras.json, COLMAP model or *_par.txt");
}

bool lacks_splats(const fs::path& source) {
  std::error_code ignored;
  if (!fs::exists(source, ignored)) return false;
  if (source.filename() == "scene.json") return read_scene_file(source).splats.empty();
  if (!fs::is_directory(source, ignored)) return splats_at(source).empty() && !cameras_at(source).empty();
  if (fs::is_regular_file(source / "scene.json", ignored)) return read_scene_file(source / "scene.json").splats.empty();
  const fs::path splats = splats_of_folder(source);
  if (!splats.empty() && !is_point_cloud(splats)) return false;
  if (!cameras_at(source).empty() || !cameras_in(source).empty()) return true;
  return splat_files_in(source).empty() &&
         (photos_in(folder_of_photos(source)) > 0 || !unread_photos_of(source).empty());
}

CameraFile read_photo_cameras(const PhotoSet& set) {
  CameraFile file = read_cameras(set.cameras, set.photos, PhotoFit::kEachPhoto);
  if (file.photos_found == 0)
    throw input_error(set.cameras.string(), "",
                      fmt::format("lists {} photos, none of which was found: {}", file.frames, sought(set, file)),
                      "put them where the file names them, or give their folder with --photos");
  if (!file.missing_photo.empty())
    file.warnings.push_back(fmt::format("{}: {}", set.cameras.string(), sought(set, file)));
  if (const std::string sentence = other_models(set.cameras); !sentence.empty()) file.warnings.push_back(sentence);
  return file;
}

}  // namespace pliant

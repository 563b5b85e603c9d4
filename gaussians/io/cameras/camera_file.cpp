#include "gaussians/io/cameras/camera_file.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "gaussians/base/error.h"
#include "gaussians/base/polar.h"
#include "gaussians/io/files/paths.h"
#include "gaussians/io/images/image_io.h"
#include "gaussians/io/images/photo.h"

namespace fs = std::filesystem;

namespace pliant {

const std::array<const char*, 6> kDistortionNames = {"k1", "k2", "p1", "p2", "k3", "k4"};

namespace {

/// How well the folder of a photo fits that in its name: twice the number of last parts that are equal, and one where
/// they are all that the name has.
int likeness(const fs::path& folder, const fs::path& named) {
  const std::vector<fs::path> have(folder.begin(), folder.end()), wanted(named.begin(), named.end());
  const auto end = std::mismatch(wanted.rbegin(), wanted.rend(), have.rbegin(), have.rend()).first;
  return 2 * static_cast<int>(end - wanted.rbegin()) + (end == wanted.rend());
}

/// A name that stays in its folder when files are called by it.
std::string safe_name(std::string name) {
  for (char& c : name)
    if (c == '/' || c == '\\') c = '_';
  return name[0] == '.' ? "_" + name : name;
}

/// Whether the camera's photo has its shape; swaps the sides of the stored picture where only the one turned by its
/// EXIF orientation has it.
bool turn_to_shape(const Camera& camera, int& width, int& height) {
  if (same_shape(camera, width, height)) return true;
  if (!same_shape(camera, height, width) || read_photo_head(camera.photo).orientation < 5) return false;
  std::swap(width, height);
  return true;
}

}  // namespace

bool same_shape(const Camera& camera, int width, int height) {
  const double skew = std::abs(1.0 * width * camera.height - 1.0 * height * camera.width);
  return skew <= std::max({width, height, camera.width, camera.height});
}

bool read_photo_size(const std::string& photo, PhotoFit fit, int& width, int& height) {
  try {
    const ImageF picture = read_image(photo);
    width = picture.width;
    height = picture.height;
    return true;
  } catch (const Error&) {
    if (fit == PhotoFit::kFirstPhoto) throw;
    return false;
  }
}

bool make_rotation(Eigen::Matrix3d& matrix) {
  const double defect = (matrix.transpose() * matrix - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (!(defect < 1e-2) || matrix.determinant() < 0) return false;
  if (defect > 1e-9) matrix = polar_rotation<double>(matrix);
  return true;
}

const char* cam_from_opengl(const Eigen::Matrix4d& world_from_cam, Eigen::Isometry3d& cam_from_world) {
  if (!((world_from_cam.row(3) - Eigen::RowVector4d(0, 0, 0, 1)).norm() <= 1e-6)) return "has another last row";
  Eigen::Matrix3d rotation = world_from_cam.topLeftCorner<3, 3>();
  if (!make_rotation(rotation)) {
    const double volume = rotation.determinant();
    if (volume > 0) rotation /= std::cbrt(volume);
    if (!make_rotation(rotation)) return "does not begin with a rotation";
  }
  rotation.col(1) *= -1;
  rotation.col(2) *= -1;
  cam_from_world.setIdentity();
  cam_from_world.linear() = rotation.transpose();
  cam_from_world.translation() = -rotation.transpose() * world_from_cam.topRightCorner<3, 1>();
  return nullptr;
}

void CameraCollector::add(Camera camera, const std::string& photo_name) {
  if (camera.name.empty())
    camera.name = name_of_photo(photo_name);
  else
    camera.name = safe_name(std::move(camera.name));
  ++result_.frames;
  result_.photos_found += !camera.photo.empty();
  names_.push_back(photo_name);
  result_.cameras.push_back(std::move(camera));
}

CameraFile CameraCollector::finish(const std::string& format, bool sizes_are_of_photos) {
  result_.format = format;
  result_.files = {file_};
  give_each_photo_to_one_frame();
  for (size_t i = 0; i < names_.size() && result_.missing_photo.empty(); ++i)
    if (result_.cameras[i].photo.empty()) result_.missing_photo = names_[i];
  if (fit_ != PhotoFit::kView) keep_frames_with_photos();
  make_names_unique();
  if (fit_ != PhotoFit::kEachPhoto) {
    if (!sizes_are_of_photos) match_size_of_photos();
    warn_of_distortion();
  }
  return std::move(result_);
}

/// Where a file names cam0/0.png and cam1/0.png and its photos are those of cam0, both frames find the same one.  It is
/// that of the frame whose name is most like its path; what the others' folder holds besides is no photo of theirs.
void CameraCollector::give_each_photo_to_one_frame() {
  std::map<std::string, std::vector<size_t>> frames_of;
  for (size_t i = 0; i < names_.size(); ++i)
    if (const std::string& photo = result_.cameras[i].photo; !photo.empty()) frames_of[photo].push_back(i);
  const auto folder_in_name = [&](size_t i) { return with_slashes(names_[i]).lexically_normal().parent_path(); };
  std::set<std::pair<fs::path, fs::path>> apart;  // the folder of photos and that of names which do not belong to it
  for (const auto& [photo, frames] : frames_of) {
    const fs::path folder = fs::path(photo).parent_path();
    const fs::path whole = tidy_path(fs::absolute(photo)).parent_path();
    const auto fit = [&](size_t i) { return likeness(whole, folder_in_name(i)); };
    const size_t owner =
        *std::max_element(frames.begin(), frames.end(), [&](size_t a, size_t b) { return fit(a) < fit(b); });
    for (const size_t i : frames) {
      if (folder_in_name(i) == folder_in_name(owner)) continue;
      if (fit(i) == fit(owner))
        throw input_error(file_.string(), "file_path",
                          "'" + names_[owner] + "' and '" + names_[i] + "' both find the photo " + photo,
                          "keep the photos in the folders that the file names");
      apart.emplace(folder, folder_in_name(i));
    }
  }
  for (size_t i = 0; i < names_.size(); ++i) {
    std::string& photo = result_.cameras[i].photo;
    if (photo.empty() || !apart.count({fs::path(photo).parent_path(), folder_in_name(i)})) continue;
    photo.clear();
    --result_.photos_found;
  }
}

void CameraCollector::keep_frames_with_photos() {
  const int missing = result_.frames - result_.photos_found;
  if (missing == 0) return;
  if (result_.photos_found == 0) {
    result_.warnings.push_back(file_.string() + ": none of the " + std::to_string(missing) +
                               " photos exists, the first is '" + result_.missing_photo +
                               "'; the cameras are used without photos");
    return;
  }
  std::vector<Camera> cameras;
  std::vector<std::string> names;
  for (size_t i = 0; i < result_.cameras.size(); ++i) {
    if (result_.cameras[i].photo.empty()) continue;
    cameras.push_back(std::move(result_.cameras[i]));
    names.push_back(names_[i]);
  }
  result_.cameras = std::move(cameras);
  names_ = std::move(names);
  result_.warnings.push_back(file_.string() + ": " + std::to_string(missing) + " of " + std::to_string(result_.frames) +
                             " frames name photos that do not exist, the first is '" + result_.missing_photo +
                             "'; they are ignored");
}

/// Cameras are found by name, so equal names (train/r_0, test/r_0) take their folders into the name, then the suffixes
/// of their photos (r_0.jpg, r_0.png), and without folders and photos (cameras.json of 3DGS, which lists the views of
/// train and test) a number.
void CameraCollector::make_names_unique() {
  std::map<std::string, int> uses;
  for (const Camera& camera : result_.cameras) ++uses[camera.name];
  std::map<std::string, std::set<std::string>> photos_of;  // by long name
  for (size_t i = 0; i < result_.cameras.size(); ++i) {
    const Camera& camera = result_.cameras[i];
    if (uses[camera.name] > 1)
      photos_of[long_name_of_photo(names_[i])].insert(camera.photo.empty() ? full_name_of_photo(names_[i])
                                                                           : camera.photo);
  }
  std::set<std::string> taken;
  for (size_t i = 0; i < result_.cameras.size(); ++i) {
    std::string& name = result_.cameras[i].name;
    if (uses[name] > 1) {
      name = long_name_of_photo(names_[i]);
      if (photos_of[name].size() > 1) name = full_name_of_photo(names_[i]);
    }
    const bool bare = !with_slashes(names_[i]).has_parent_path() && result_.cameras[i].photo.empty();
    if (const std::string base = name; bare && !base.empty())
      for (int n = 2; taken.count(name); ++n) name = base + "_" + std::to_string(n);
    if (name.empty() || !taken.insert(name).second) {
      throw input_error(file_.string(), "file_path", "'" + names_[i] + "' names two frames",
                        "give each frame its own photo");
    }
  }
}

/// The cameras follow photos that were scaled after the camera file was written.  Who scaled them rounded their sizes
/// up or down, so cameras of one size take that of the first photo among them.
void CameraCollector::match_size_of_photos() {
  using Size = std::pair<int, int>;
  std::vector<Camera>& cameras = result_.cameras;
  const auto with_photo =
      std::find_if(cameras.begin(), cameras.end(), [](const Camera& camera) { return !camera.photo.empty(); });
  if (with_photo == cameras.end()) return;
  const Camera first = *with_photo;
  int width = 0, height = 0;
  if (!read_photo_size(first.photo, fit_, width, height)) return;
  const auto sizes = [](const Camera& camera, int w, int h) {
    return std::to_string(w) + " x " + std::to_string(h) + " pixels but the camera says " +
           std::to_string(camera.width) + " x " + std::to_string(camera.height);
  };
  if (!turn_to_shape(first, width, height))
    throw input_error(first.photo, "", "has " + sizes(first, width, height),
                      "use the photos that the cameras belong to");

  std::map<Size, Size> size_of;  // of photos, by the size of their cameras
  std::string warning;
  const auto found = [&](const Camera& camera, int w, int h) {
    size_of[{camera.width, camera.height}] = {w, h};
    if (warning.empty() && (w != camera.width || h != camera.height))
      warning = camera.photo + ": has " + sizes(camera, w, h) + "; the cameras are scaled to the photos";
  };
  found(first, width, height);
  for (const Camera& camera : cameras) {
    if (camera.photo.empty() || size_of.count({camera.width, camera.height})) continue;
    const PhotoHead head = read_photo_head(camera.photo);
    int w = head.width, h = head.height;
    const bool known = (w > 0 && h > 0) || read_photo_size(camera.photo, PhotoFit::kView, w, h);
    if (known && turn_to_shape(camera, w, h)) found(camera, w, h);
  }
  const double scale = static_cast<double>(width) / first.width;
  for (Camera& camera : cameras) {
    const auto known = size_of.find({camera.width, camera.height});
    camera = known != size_of.end() ? camera.resized(known->second.first, known->second.second) : camera.scaled(scale);
  }
  if (!warning.empty()) result_.warnings.push_back(warning);
}

void CameraCollector::warn_of_distortion() {
  std::string names;
  for (size_t k = 0; k < kDistortionNames.size(); ++k) {
    bool used = false;
    for (const Camera& camera : result_.cameras) used = used || camera.distortion[k] != 0;
    if (used) names += (names.empty() ? "" : ", ") + std::string(kDistortionNames[k]);
  }
  if (names.empty()) return;
  result_.warnings.push_back(file_.string() + ": lens distortion (" + names +
                             ") is removed by `reconstruct`; where splats are given it is ignored: undistort the "
                             "photos for exact results");
}

}  // namespace pliant

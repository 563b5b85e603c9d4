#include "app/import/physdreamer_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "gaussians/base/error.h"
#include "gaussians/base/nearest.h"
#include "gaussians/io/cameras/cameras.h"
#include "gaussians/io/cameras/ply_points.h"
#include "gaussians/io/images/image_io.h"

namespace fs = std::filesystem;

namespace pliant {
namespace {

constexpr double kDensity = 2000;
constexpr double kCubeSide = 1.8, kCubeMargin = 0.25;  // times the object's extent
constexpr double kFieldBox = 1.2;

bool present(const fs::path& file) {
  std::error_code ignored;
  return fs::exists(file, ignored);
}

std::vector<Vec3f> points_of(const fs::path& file, bool needed, std::vector<std::string>& warnings) {
  if (!present(file)) {
    if (!needed) return {};
    throw input_error(
        file.string(), "", "is missing",
        "a PhysDreamer scene lists in it the points of the object, and in moving_part_points.ply those that move");
  }
  SparsePoints read = read_ply_points(file);
  if (read.empty() && needed)
    throw input_error(file.string(), "", "has no points", "write the points of the object's part into it");
  warnings.insert(warnings.end(), read.warnings.begin(), read.warnings.end());
  return std::move(read.position);
}

std::vector<fs::path> sorted(const fs::path& folder, bool folders, const std::string& extension) {
  std::vector<fs::path> out;
  if (!present(folder)) return out;
  for (const auto& entry : fs::directory_iterator(folder))
    if (folders ? entry.is_directory() : entry.path().extension() == extension) out.push_back(entry.path());
  std::sort(out.begin(), out.end());
  return out;
}

/// The camera with the longest name that `name` begins with; a number may not go on behind it.
std::string camera_of(const std::string& name, const std::vector<Camera>& cameras) {
  std::string best;
  for (const Camera& camera : cameras) {
    const std::string& stem = camera.name;
    if (stem.size() <= best.size() || name.compare(0, stem.size(), stem) != 0) continue;
    const auto digit = [](char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; };
    if (name.size() > stem.size() && digit(name[stem.size()]) && digit(stem.back())) continue;
    best = stem;
  }
  return best;
}

void find_videos(const fs::path& folder, const std::vector<Camera>& cameras, PhysDreamerFolder& out) {
  const fs::path videos = folder / "videos";
  for (const fs::path& file : sorted(videos, false, ".mp4"))
    out.videos.push_back({file, camera_of(file.stem().string(), cameras)});
  for (const fs::path& frames : sorted(videos, true, ""))
    if (!sorted(frames, false, ".png").empty())
      out.videos.push_back({frames, camera_of(frames.filename().string(), cameras)});
  if (out.videos.empty() && !sorted(videos, false, ".png").empty())
    out.videos.push_back({videos, camera_of(fs::absolute(folder).filename().string(), cameras)});
  for (const PhysDreamerFolder::Video& video : out.videos)
    if (video.camera.empty())
      out.warnings.push_back(
          fmt::format("{} is not named after any of the {} cameras: name it after its camera, or give --video-camera",
                      video.file.string(), cameras.size()));
  if (out.videos.empty()) out.warnings.push_back(videos.string() + " contains no videos");
}

/// Which points are farther than `distance` from all of `near`.
std::vector<uint8_t> far_from(std::span<const Vec3f> points, std::span<const Vec3f> near, double distance) {
  std::vector<uint8_t> far(points.size(), 1);
  if (near.empty()) return far;
  const NearestPoints tree(near);
  std::vector<NearestPoints::Hit> hits;
  for (size_t i = 0; i < points.size(); ++i) {
    tree.query(points[i], 1, hits);
    far[i] = !hits.empty() && hits[0].distance > distance;
  }
  return far;
}

}  // namespace

const PhysDreamerFolder::Video* PhysDreamerFolder::find_video(const fs::path& file) const {
  for (const Video& video : videos)
    if (fs::weakly_canonical(video.file) == fs::weakly_canonical(file)) return &video;
  return nullptr;
}

bool is_physdreamer_folder(const fs::path& folder) {
  return present(folder / "point_cloud.ply") &&
         (present(folder / "clean_object_points.ply") || present(folder / "moving_part_points.ply"));
}

PhysDreamerFolder read_physdreamer_folder(const fs::path& folder) {
  PhysDreamerFolder out;
  SceneFile& settings = out.settings;
  settings.splats = folder / "point_cloud.ply";
  if (!present(settings.splats))
    throw input_error(settings.splats.string(), "", "is missing", "a PhysDreamer scene keeps its Gaussians there");
  settings.cameras = present(folder / "transforms_train.json") ? folder / "transforms_train.json" : cameras_in(folder);
  if (settings.cameras.empty())
    throw input_error(folder.string(), "", "has neither transforms_train.json nor sparse/0",
                      "a PhysDreamer scene keeps its cameras there");
  if (present(folder / "images")) settings.photos = folder / "images";
  settings.material.density = kDensity;

  out.object_points = points_of(folder / "clean_object_points.ply", true, out.warnings);
  out.moving_points = points_of(folder / "moving_part_points.ply", true, out.warnings);
  out.filled_points = points_of(folder / "internal_filled_points.ply", false, out.warnings);
  out.stem_points = points_of(folder / "stem_points.ply", false, out.warnings);

  CameraFile cameras = read_cameras(settings.cameras, settings.photos);
  out.warnings.insert(out.warnings.end(), cameras.warnings.begin(), cameras.warnings.end());
  find_videos(folder, cameras.cameras, out);
  for (const PhysDreamerFolder::Video& video : out.videos)
    if (!video.camera.empty()) {
      settings.video = VideoReference{video.file, video.camera, kPhysDreamerFps};
      break;
    }
  for (const Camera& camera : cameras.cameras)
    if (const fs::path mask = folder / "masks" / (camera.name + "_mask.png"); present(mask))
      out.masks[camera.name] = mask;
  if (present(folder / "sim_fields.pt")) out.material_field = folder / "sim_fields.pt";
  if (present(folder / "velo_fields.pt")) out.velocity_field = folder / "velo_fields.pt";
  return out;
}

PhysDreamerRoles physdreamer_roles(const PhysDreamerOptions& options, const PhysDreamerFolder& folder,
                                   std::span<const Vec3f> position) {
  PhysDreamerRoles roles;
  roles.object = far_from(position, folder.object_points, options.reach);
  float low = INFINITY, high = -INFINITY;
  size_t count = 0;
  for (size_t i = 0; i < position.size(); ++i) {
    roles.object[i] = !roles.object[i];
    if (!roles.object[i]) continue;
    low = std::min(low, position[i].minCoeff());
    high = std::max(high, position[i].maxCoeff());
    ++count;
  }
  if (count == 0) {
    throw input_error("clean_object_points.ply", "",
                      fmt::format("has no point within {} units of a Gaussian", options.reach),
                      "the points must be in the coordinates of point_cloud.ply");
  }
  // One smallest and one largest coordinate over all axes.
  PhysDreamerSpace& space = roles.space;
  space.scale = kCubeSide * (high - low);
  space.shift = kCubeMargin * (high - low) - low;

  const double distance = options.frozen_distance / options.grid * space.scale;
  roles.frozen = far_from(position, folder.moving_points, distance);
  for (size_t i = 0; i < position.size(); ++i) roles.frozen[i] = roles.frozen[i] && roles.object[i];
  roles.frozen_filled = far_from(folder.filled_points, folder.moving_points, distance);
  const auto held = std::count(roles.frozen.begin(), roles.frozen.end(), 1);
  if (held == static_cast<std::ptrdiff_t>(count))
    roles.warnings.push_back("the whole object is fixed: moving_part_points.ply lies elsewhere");
  if (held == 0) roles.warnings.push_back("no part of the object is fixed: moving_part_points.ply covers all of it");

  Eigen::AlignedBox3d box;
  for (size_t i = 0; i < position.size(); ++i)
    if (roles.object[i]) box.extend(space.inside(position[i].cast<double>()));
  for (const Vec3f& x : folder.filled_points) box.extend(space.inside(x.cast<double>()));
  space.field_low = box.center() - 0.5 * kFieldBox * box.sizes();
  space.field_high = box.center() + 0.5 * kFieldBox * box.sizes();
  return roles;
}

Camera physdreamer_camera(const Camera& camera, int width, int height) {
  CHECK(width > 0 && height > 0);
  const double scale = static_cast<double>(width) / camera.width;
  Camera out = camera;
  out.width = width;
  out.height = height;
  out.fx *= scale;
  out.fy *= scale;
  out.cx = 0.5 * width + scale * (camera.cx - 0.5 * camera.width);
  out.cy = 0.5 * height + scale * (camera.cy - 0.5 * camera.height);
  return out;
}

ImageF physdreamer_mask(const PhysDreamerFolder& folder, const Camera& camera) {
  const auto file = folder.masks.find(camera.name);
  if (file == folder.masks.end()) return {};
  const ImageF mask = read_image(file->second);
  const double scale = static_cast<double>(mask.width) / camera.width;
  ImageF out(camera.width, camera.height, 1);
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) {
      const int i = static_cast<int>(scale * (x + 0.5)),
                j = static_cast<int>(std::floor(0.5 * mask.height + scale * (y + 0.5 - 0.5 * out.height)));
      if (i < mask.width && j >= 0 && j < mask.height) out(x, y) = mask(i, j, 0) > 0.5f;
    }
  return out;
}

}  // namespace pliant

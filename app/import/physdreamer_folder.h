#pragma once

#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "gaussians/base/camera.h"
#include "gaussians/base/image.h"
#include "gaussians/io/scene/scene.h"

namespace pliant {

constexpr double kPhysDreamerFps = 30;  ///< of every video, whatever its file says

/// A scene folder of PhysDreamer (Zhang et al. 2024) as its released code reads it.
struct PhysDreamerFolder {
  SceneFile settings;  ///< splats, cameras, photos, the first video, density 2000 kg/m^3

  std::vector<Vec3f> object_points;  ///< clean_object_points.ply: what lies near one of them is simulated
  std::vector<Vec3f> filled_points;  ///< internal_filled_points.ply: simulated, never drawn; may be empty
  std::vector<Vec3f> moving_points;  ///< moving_part_points.ply: what is far from all of them is held fixed
  std::vector<Vec3f> stem_points;    ///< stem_points.ply: where the density may differ; may be empty

  struct Video {
    std::filesystem::path file;  ///< mp4, or a folder of PNG
    std::string camera;          ///< name; empty when none has it
  };
  std::vector<Video> videos;                                         ///< by name
  const Video* find_video(const std::filesystem::path& file) const;  ///< nullptr for one that is none of them
  std::map<std::string, std::filesystem::path> masks;                ///< by camera: masks/<name>_mask.png
  std::filesystem::path material_field, velocity_field;              ///< sim_fields.pt, velo_fields.pt; empty without
  std::vector<std::string> warnings;
};

/// Whether a folder looks like one: point_cloud.ply with clean_object_points.ply or moving_part_points.ply.
bool is_physdreamer_folder(const std::filesystem::path& folder);

/// Reads a folder: point clouds, cameras (transforms_train.json, else sparse/0), the videos/ of its cameras and masks/.
/// A video belongs to the camera whose photo's stem its name begins with (the longest such stem); PNG files right in
/// videos/ belong to the camera that the folder itself is named after.  PhysDreamer takes every frame for 1/30 s.
/// Throws Error{kInput} naming what is missing.
PhysDreamerFolder read_physdreamer_folder(const std::filesystem::path& folder);

/// The cube that PhysDreamer simulates in: x -> (x + shift) / scale, from the object's Gaussians alone.
struct PhysDreamerSpace {
  double scale = 1, shift = 0;
  Vec3d field_low = Vec3d::Zero(),
        field_high =
            Vec3d::Ones();  ///< box of the fields, in the cube: that of all simulated points, 1.2 times as large
  Vec3d inside(const Vec3d& world) const { return (world.array() + shift).matrix() / scale; }
  Vec3d world(const Vec3d& inside) const { return (inside * scale).array() - shift; }
};

/// What the point files make of a cloud.
struct PhysDreamerRoles {
  std::vector<uint8_t> object;         ///< [N] Gaussians that are simulated: within `reach` of an object point
  std::vector<uint8_t> frozen;         ///< [N] of them, held fixed
  std::vector<uint8_t> frozen_filled;  ///< [filled points] held fixed
  PhysDreamerSpace space;
  std::vector<std::string> warnings;
};

struct PhysDreamerOptions {
  double reach = 0.01;           ///< scene units, of the object points
  int grid = 64;                 ///< cells of the cube's edge
  double frozen_distance = 0.5;  ///< cells from the moving points: 0.5 for the material, 0.25 for the velocity
};

/// Throws Error{kInput} when no Gaussian is near an object point.
PhysDreamerRoles physdreamer_roles(const PhysDreamerOptions& options, const PhysDreamerFolder& folder,
                                   std::span<const Vec3f> position);

/// The camera of a video of another shape than the photos, as PhysDreamer takes it: the horizontal field of view stays.
Camera physdreamer_camera(const Camera& camera, int width, int height);

/// masks/<camera>_mask.png at the pixels of that camera or of one of its videos, [H, W, 1]: 1 where the first channel
/// is bright, the foreground.  A mask of another shape has the camera's horizontal field of view and the same middle; 0
/// beside it.  Empty when the camera has none.
ImageF physdreamer_mask(const PhysDreamerFolder& folder, const Camera& camera);

}  // namespace pliant

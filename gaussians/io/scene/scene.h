#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "gaussians/base/camera.h"
#include "gaussians/base/gaussian_cloud.h"
#include "gaussians/io/splats/ply.h"
#include "gaussians/io/splats/read_report.h"

namespace pliant {

/// Homogeneous material: Young's modulus [Pa], Poisson's ratio, density [kg/m^3]; the constitutive law's name and its
/// constants, whose names the physics knows.
struct MaterialValues {
  std::optional<double> young, poisson, density;
  std::string law;
  std::map<std::string, double> constants;
};

/// A reference video that shows the object moving.
struct VideoReference {
  std::filesystem::path file;
  std::string camera;  ///< name of the camera that took it
  double fps = 0;
};

/// Contents of scene.json; every path is resolved against the folder of the file.
/// Keys: splats, cameras, photos, masks, labels, video {file, camera, fps}, up [3] or an axis such as "-y",
/// metres_per_unit, support (name of an id), object (name of the id that `run` takes when none is given), pinned [{box:
/// [x0,y0,z0,x1,y1,z1]} | {sphere: [x,y,z,r]}], material {young, poisson, density, law, constants {name: value}},
/// antialiased (bool, of splats that carry no mark), background [3] in 0..1.
struct SceneFile {
  std::filesystem::path file, splats, cameras, photos, masks, labels;
  std::optional<VideoReference> video;
  std::optional<Eigen::Vector3d> up;
  std::optional<double> metres_per_unit;
  std::string support, object;
  struct Region {
    bool sphere = false;
    Vec3f low, high;  ///< box corners; for a sphere `low` is the centre and high.x() the radius
    bool contains(const Vec3f& x) const;
  };
  std::vector<Region> pinned;
  MaterialValues material;
  std::optional<bool> antialiased;        ///< the splats were trained with mip-splatting, whatever their file says
  std::optional<Vec3d> background;        ///< color in front of which the splats were trained, in 0..1
  std::filesystem::path background_file;  ///< cfg_args of the 3DGS model that says it; empty when scene.json does

  Vec3f background_color() const { return background.value_or(Vec3d::Zero()).cast<float>(); }
};

/// Parses scene.json; unknown keys are usage errors that name the nearest known key, impossible values (young <= 0,
/// poisson outside (-1, 0.5), density <= 0, metres_per_unit <= 0, background outside 0..1) name the key and the value.
SceneFile read_scene_file(const std::filesystem::path& file);

/// A scene as the stages see it.
struct Scene {
  std::filesystem::path source;  ///< what the user named
  SceneFile settings;
  GaussianCloud cloud;
  ReadReport report;
  std::vector<Camera> cameras;     ///< from files, or an orbit
  bool cameras_are_orbit = false;  ///< no cameras were found: the orbit's renders stand in for photos
  Eigen::Vector3d up = {0, 0, 1};  ///< unit
  std::string up_source;           ///< how `up` was found, a sentence
  double metres_per_unit = 1;
  double object_height = 0;       ///< [m], 0 = not given; metres_per_unit follows from it once the object is known
  bool scale_is_assumed = false;  ///< neither was given: a unit is taken for a meter
  std::vector<std::string> warnings;
};

/// The splats in a folder without scene.json: those of the last iteration of a 3DGS model folder, a SOG,
/// point_cloud.ply, or the only splat file.  Empty when there are none or several.
std::filesystem::path splats_of_folder(const std::filesystem::path& folder);
/// All splat files that lie in it themselves, by name; archives and point clouds do not count.
std::vector<std::filesystem::path> splat_files_in(const std::filesystem::path& folder);
/// Cameras beside the splats, or in the 3DGS model folder that they lie in; where there are none beside a link, those
/// of the file that it leads to.  Empty when there are none.
std::filesystem::path cameras_of_splats(const std::filesystem::path& splats);

/// Loads splats of any format (splats.h), a 3DGS model folder, a folder with one splat file, or one with scene.json.
/// Cameras: the scene file's, else those beside the splats or in the model folder (cameras.h), else an orbit of
/// `orbit_views` views.  Background: the scene file's, else white where cfg_args of the model folder says so.
struct LoadOptions {
  std::optional<int> level;  ///< of detail of a streamed SOG, 0 = finest; default: the finest that is there
  std::optional<Eigen::Vector3d> up;
  std::optional<double> metres_per_unit;
  double object_height = 0;        ///< [m], instead of metres_per_unit; 0 = not given
  bool antialiased = false;        ///< as settings.antialiased, which becomes true
  std::optional<int> orbit_views;  ///< default 24
  int orbit_width = 800, orbit_height = 600;
};
Scene load_scene(const std::filesystem::path& source, const LoadOptions& options = {});

}  // namespace pliant

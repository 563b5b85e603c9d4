#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "gaussians/base/camera.h"

namespace pliant {

/// One record of images.{bin,txt} of a COLMAP model.
struct ColmapImage {
  uint32_t id = 0, camera = 0;
  double q[4], t[3];  ///< cam_from_world; q = w, x, y, z, not checked
  std::string photo;
  std::vector<Eigen::Vector2d> points;  ///< features in pixels, the centre of the first pixel at (0.5, 0.5)

  /// Of q, scaled to length 1, and t; meaningless where q is zero or not finite.
  Eigen::Isometry3d cam_from_world() const {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear() = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix();
    pose.translation() = Eigen::Vector3d(t[0], t[1], t[2]);
    return pose;
  }
};

/// Whether the folder holds the records as binary (".bin") or as text (".txt"); binary wins, "" = neither.
std::string colmap_extension(const std::filesystem::path& folder);

/// cameras.{bin,txt}: id -> camera without a pose.  A camera with a lens that is not read is refused where it is among
/// `needed`, and left out elsewhere.  Throws Error{kInput} naming file, record and value.
std::map<uint32_t, Camera> read_colmap_cameras(const std::filesystem::path& file, const std::set<uint32_t>& needed);

/// `field` names the record in messages.
using UseColmapImage = std::function<void(const ColmapImage&, const std::string& field)>;

/// Calls `use` for the images of images.{bin,txt}; their features are read only `with_points`.
void for_each_colmap_image(const std::filesystem::path& file, bool with_points, const UseColmapImage& use);

/// How many images images.{bin,txt} says that it has, without reading them; 0 when its size contradicts that.
uint64_t count_colmap_images(const std::filesystem::path& file);

/// The next line of a text model that is no comment, which may be empty; false at the end.  Counts lines in `number`.
bool next_colmap_line(std::istringstream& in, std::string& line, int& number);

}  // namespace pliant

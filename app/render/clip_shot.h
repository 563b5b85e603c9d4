#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/store/trajectory.h"
#include "gaussians/io/scene/scene.h"

namespace pliant {

/// How a clip is filmed.
struct ShotOptions {
  std::string camera;         ///< name of the fixed camera; empty = one that sees the object well
  std::string path;           ///< camera path file instead; empty = fixed
  std::string size;           ///< "1920x1080"; empty = that of the camera or the path
  std::optional<double> fps;  ///< default: the path's, else the simulation's
};

/// The camera with a picture of `size` ("1920x1080"; empty = its own), of which nothing is cut.  A usage error says
/// what is wrong with a size.
Camera sized(const Camera& camera, const std::string& size);

/// The camera with a picture of even width and height, as videos have it, of which nothing is cut; one of a single row
/// or column stays as it is.
Camera evened(const Camera& camera);

/// Throws Error{kUsage} for options that exclude each other, a size that is none and a camera that `scene`, if it has
/// any, has not; Error{kInput} for a path that cannot be read.
void check_shot(const ShotOptions& options, const Scene& scene);

/// A moment of the motion and the camera that sees it, for every frame of a clip.
struct Shot {
  double fps = 0;
  std::vector<double> times;    ///< [T] s of the motion, which stands still after its last frame
  std::vector<Camera> cameras;  ///< [T]
  std::vector<std::string> warnings{};
};

/// The clip's shot, of even size: with a camera path it lasts as long as the longer of the path and the motion.  A
/// usage error names an option that is wrong.
Shot clip_shot(const ShotOptions& options, const Scene& scene, const TrajectoryFile& motion, const Box& object);

/// The same moments from a camera that turns around the object, once or (degrees < 360) to either side and back; it
/// begins at the shot's first camera.
Shot turning_shot(const Shot& shot, double degrees, const Box& object, const Vec3d& up);

}  // namespace pliant

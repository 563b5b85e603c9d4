#pragma once

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "app/render/clip_shot.h"
#include "gaussians/io/images/video.h"
#include "gaussians/render/render.h"

namespace pliant {

/// A distance [scene units] beyond which the shot shows nothing of the object: along the axes of its cameras, that of
/// the farthest driving particle and a diagonal of the object; at least two diagonals behind where it is at rest.
/// `object`: the box around it at rest, scene units.
double farthest_depth(const Shot& shot, const TrajectoryFile& motion, const Box& object);

/// The object alone, for compositing: frames with alpha (color/000000.png, not premultiplied), its depth along the
/// camera's axis (depth/000000.png, 16 bit, 0 = nothing), and layer.json with the cameras and the length [m] that one
/// step of the depth stands for.
class ObjectLayer {
 public:
  /// `folder` is new; `farthest`: see farthest_depth.
  ObjectLayer(const std::filesystem::path& folder, const std::filesystem::path& video, const Shot& shot,
              double farthest, double metres_per_unit);
  void write(size_t k, const GaussianCloud& object, const RenderOptions& options);
  void close();  ///< the video has its name only then

 private:
  std::filesystem::path folder_;
  const Shot& shot_;
  VideoWriter video_;
  double metres_per_unit_, farthest_;  ///< m, farthest = depth of the value 65535
  nlohmann::json frames_ = nlohmann::json::array();
};

}  // namespace pliant

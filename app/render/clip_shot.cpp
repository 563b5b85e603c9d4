#include "app/render/clip_shot.h"

#include <cmath>
#include <cstdio>
#include <optional>
#include <utility>

#include "app/simulate/clip_camera.h"
#include "gaussians/base/error.h"
#include "gaussians/base/orbit.h"
#include "gaussians/io/cameras/camera_path.h"

namespace pliant {

namespace {

/// Width and height of "1920x1080" [px].
std::pair<int, int> parse_size(const std::string& size) {
  constexpr int kLargest = 16384;
  int width = 0, height = 0, read = 0;
  const bool whole =
      std::sscanf(size.c_str(), "%dx%d%n", &width, &height, &read) == 2 && read == static_cast<int>(size.size());
  if (!whole || width < 2 || height < 2 || width > kLargest || height > kLargest)
    throw usage_error("--size", size, "is not a valid size", "give WIDTHxHEIGHT in pixels, such as 1920x1080");
  return {width, height};
}

}  // namespace

Camera sized(const Camera& camera, const std::string& size) {
  if (size.empty()) return camera;
  const auto [width, height] = parse_size(size);
  return camera.framed(width, height);
}

Camera evened(const Camera& camera) {
  const int width = camera.width & ~1, height = camera.height & ~1;
  const bool even = width == camera.width && height == camera.height;
  return even || width == 0 || height == 0 ? camera : camera.framed(width, height);
}

void check_shot(const ShotOptions& options, const Scene& scene) {
  if (!options.path.empty() && !options.camera.empty())
    throw usage_error("--cameras", options.path, "was given together with --camera", "leave one of them out");
  if (options.path == "orbit" || options.path == "scene")
    throw usage_error("--cameras", options.path, "is for images of a scene; a clip takes a camera path here",
                      "give its file, or --turntable for a camera that turns around the object");
  if (!options.size.empty()) parse_size(options.size);
  if (!options.path.empty()) read_camera_path(options.path);
  if (!options.camera.empty() && !scene.cameras.empty()) clip_camera(scene, options.camera, {});
}

Shot clip_shot(const ShotOptions& options, const Scene& scene, const TrajectoryFile& motion, const Box& object) {
  check_shot(options, scene);
  std::optional<CameraPath> path;
  if (!options.path.empty()) path = read_camera_path(options.path);
  Shot shot;
  if (path) shot.warnings = path->warnings;
  shot.fps = options.fps.value_or(path ? path->fps : motion.fps);
  const double end = std::max(motion.frames.back().time, path ? path->duration() : 0);
  const int frames = static_cast<int>(std::floor(end * shot.fps + 1e-6)) + 1;
  const Camera fixed = path ? Camera() : evened(sized(clip_camera(scene, options.camera, object), options.size));
  for (int k = 0; k < frames; ++k) {
    shot.times.push_back(k / shot.fps);
    shot.cameras.push_back(path ? evened(sized(path->at(shot.times.back()), options.size)) : fixed);
  }
  return shot;
}

Shot turning_shot(const Shot& shot, double degrees, const Box& object, const Vec3d& up) {
  OrbitPathOptions turn;
  turn.frames = static_cast<int>(shot.times.size());
  turn.degrees = degrees;
  return {shot.fps, shot.times, orbit_path(turn, shot.cameras[0], object.centre().cast<double>(), up)};
}

}  // namespace pliant

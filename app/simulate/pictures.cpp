#include "app/simulate/pictures.h"

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "app/simulate/clip_shot.h"
#include "gaussians/base/error.h"
#include "gaussians/base/orbit.h"
#include "gaussians/io/cameras/camera_path.h"
#include "gaussians/io/cameras/cameras.h"
#include "gaussians/io/images/image_io.h"
#include "gaussians/io/images/video.h"
#include "gaussians/render/render.h"

namespace pliant {
namespace fs = std::filesystem;

namespace {

CameraPath chosen_cameras(const Scene& scene, const PictureOptions& options) {
  const std::string& which = options.cameras;
  CameraPath path;
  path.cameras = scene.cameras;
  if (which.empty() || which == "scene") return path;
  if (which == "orbit" && !scene.cameras_are_orbit) {
    OrbitOptions orbit;
    orbit.views = options.orbit_views.value_or(orbit.views);
    path.cameras = orbit_cameras(orbit, scene.cloud, scene.up);
  } else if (which != "orbit") {
    if (is_camera_path(which)) return read_camera_path(which);
    path.cameras = read_cameras(which).cameras;
  }
  return path;
}

/// Mean depth mapped so that the nearest surface is white and the farthest dark; empty pixels are black.
ImageF depth_picture(const RenderResult& result) {
  ImageF picture(result.depth.width, result.depth.height, 1);
  float near = INFINITY, far = 0;
  for (size_t i = 0; i < picture.pixels(); ++i) {
    if (result.alpha.data[i] < 0.5f) continue;
    const float z = picture.data[i] = result.depth.data[i] / result.alpha.data[i];
    near = std::min(near, z);
    far = std::max(far, z);
  }
  for (float& z : picture.data) z = z > 0 ? 1.0f - 0.9f * (z - near) / std::max(far - near, 1e-9f) : 0.0f;
  return picture;
}

}  // namespace

nlohmann::json render_pictures(const Context& context, const Scene& scene, const PictureOptions& options,
                               const fs::path& out) {
  const CameraPath path = chosen_cameras(scene, options);
  std::vector<Camera> cameras;
  for (const Camera& camera : path.cameras) cameras.push_back(sized(camera, options.size));
  if (cameras.empty())
    throw usage_error("--cameras", options.cameras, "has no cameras", "give 'orbit' or a camera file");
  const bool video = out.extension() == ".mp4";
  if (video)  // frames have one size
    for (Camera& camera : cameras) camera = camera.framed(cameras[0].width, cameras[0].height);
  RenderOptions render_options;
  render_options.background = Vec3f(options.background[0], options.background[1], options.background[2]);
  render_options.antialiased = options.antialiased || scene.report.antialiased;

  if (out.has_parent_path()) fs::create_directories(out.parent_path());
  if (!video) fs::create_directories(out);
  std::unique_ptr<VideoWriter> writer;
  if (video) writer = std::make_unique<VideoWriter>(out, path.fps, cameras[0].width, cameras[0].height);

  nlohmann::json files = nlohmann::json::array();
  context.progress.begin("render", static_cast<int>(cameras.size()));
  for (size_t i = 0; i < cameras.size(); ++i) {
    if (context.interrupted())
      throw Error(Failure::kInterrupted, "render", "", "interrupted", "run the same command again");
    const RenderResult result = render(scene.cloud, cameras[i], render_options);
    if (video) {
      writer->write(result.color);
    } else {
      files.push_back((out / (cameras[i].name + ".png")).string());
      write_image(out / (cameras[i].name + ".png"), result.color);
      if (options.depth) write_image(out / (cameras[i].name + "_depth.png"), depth_picture(result));
    }
    context.progress.done(static_cast<int>(i) + 1);
  }
  context.progress.end();
  if (video) {
    writer->close();
    files.push_back(out.string());
  }
  context.progress.say("wrote " + std::to_string(cameras.size()) + (video ? " frames to " : " images to ") +
                       out.string());
  return {{"pictures", files}, {"cameras", cameras.size()}};
}

}  // namespace pliant

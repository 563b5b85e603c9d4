#include "app/render/pictures.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "app/render/clip_shot.h"
#include "app/simulate/clip_camera.h"
#include "gaussians/base/error.h"
#include "gaussians/base/orbit.h"
#include "gaussians/io/cameras/camera_path.h"
#include "gaussians/io/cameras/colmap.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/images/image_io.h"
#include "gaussians/io/images/video.h"
#include "gaussians/render/render.h"

namespace pliant {
namespace fs = std::filesystem;

namespace {

/// Beside the images: {"pictures": [names]} of those that `render` wrote.
constexpr const char* kPictures = "pictures.json";

/// Endings of other pictures and videos, which are no names of folders.
const std::set<std::string> kOtherMedia = {".avi", ".bmp", ".gif", ".jpeg", ".jpg",  ".m4v", ".mkv",
                                           ".mov", ".png", ".tif", ".tiff", ".webm", ".webp"};

CameraPath chosen_cameras(const Scene& scene, const PictureOptions& options, bool video) {
  const std::string& which = options.cameras;
  CameraPath path;
  path.cameras = scene.cameras;
  if (which.empty() || which == "scene") {
    if (video && is_colmap(scene.settings.cameras)) order_by_photo(path.cameras);
    return path;
  }
  if (which == "orbit" && !scene.cameras_are_orbit) {
    OrbitOptions orbit;
    orbit.views = options.orbit_views.value_or(orbit.views);
    path.cameras = orbit_cameras(orbit, scene.cloud, scene.up);
  } else if (which != "orbit") {
    return is_camera_path(which) ? read_camera_path(which) : read_views(which);
  }
  return path;
}

/// The path at another number of frames per second, of the same length in seconds.
void sample_anew(CameraPath& path, double fps) {
  std::vector<Camera> cameras;
  const int last = static_cast<int>(std::floor(path.duration() * fps + 1e-6));
  for (int k = 0; k <= last; ++k) cameras.push_back(path.at(k / fps));
  path.cameras = std::move(cameras);
  path.fps = fps;
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

/// Names of the images in a folder that earlier calls wrote.
std::set<std::string> written_before(const fs::path& folder) {
  std::set<std::string> names;
  if (!fs::exists(folder / kPictures)) return names;
  const nlohmann::json record = nlohmann::json::parse(read_text(folder / kPictures), nullptr, false);
  if (!record.is_object()) return names;
  for (const nlohmann::json& name : record.value("pictures", nlohmann::json::array())) {
    const fs::path file = name.is_string() ? fs::path(name.get<std::string>()).lexically_normal() : fs::path();
    if (file.extension() == ".png" && file.is_relative() && *file.begin() != "..")
      names.insert(name.get<std::string>());
  }
  return names;
}

/// As pictures.json has it, in which bytes that are not UTF-8 are U+FFFD.
std::string written(const nlohmann::json& record) {
  return record.dump(2, ' ', false, nlohmann::json::error_handler_t::replace);
}

void record_pictures(const fs::path& folder, const std::set<std::string>& names) {
  const nlohmann::json record = {{"pictures", names}};
  write_text(folder / kPictures, written(record) + "\n");
}

/// Throws where one of the images would replace a file that is none of those `before`.
void check_replaced(const fs::path& folder, const std::set<std::string>& names, const std::set<std::string>& before) {
  for (const std::string& name : names) {
    const std::string recorded = nlohmann::json::parse(written(name)).get<std::string>();
    std::error_code ignored;
    if (!before.count(recorded) && fs::exists(folder / name, ignored))
      throw usage_error("--out", folder.string(), "holds " + name + ", which an earlier `render` did not write",
                        "give another folder, or remove this file");
  }
}

/// Throws where the video would replace that of the scene.
void check_not_of_scene(const fs::path& out, const Scene& scene) {
  std::error_code ignored;
  if (scene.settings.video && fs::equivalent(out, scene.settings.video->file, ignored))
    throw usage_error("--out", out.string(), "is the scene's reference video", "give another name for the video");
}

}  // namespace

bool is_video_out(const fs::path& out) {
  std::string ending = out.extension().string();
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  const bool video = ending == ".mp4";
  const auto refuse = [&](const char* why, const char* remedy) {
    throw usage_error("--out", out.string(), why, remedy);
  };
  if (kOtherMedia.count(ending)) refuse("ends in the name of a format that is not written", "give a folder or an .mp4");
  std::error_code ignored;
  if (video && fs::is_directory(out, ignored)) refuse("is a folder", "give another name for the video");
  if (!video && fs::exists(out, ignored) && !fs::is_directory(out, ignored))
    refuse("is a file", "give a folder for the images, or an .mp4");
  return video;
}

nlohmann::json render_pictures(const Context& context, const Scene& scene, const PictureOptions& options,
                               const fs::path& out) {
  const bool video = is_video_out(out);
  CameraPath path = chosen_cameras(scene, options, video);
  for (const std::string& warning : path.warnings) context.progress.warn(warning);
  std::vector<Camera>& cameras = path.cameras;
  if (cameras.empty())
    throw usage_error("--cameras", options.cameras, "has no cameras", "give 'orbit' or a camera file");
  if (!options.camera.empty()) cameras = std::vector<Camera>{given_camera(cameras, options.camera)};
  for (Camera& camera : cameras) camera = sized(camera, options.size);
  if (video) {  // frames have one size
    const Camera first = evened(cameras[0]);
    for (Camera& camera : cameras) camera = camera.framed(first.width, first.height);
    if (options.fps) sample_anew(path, *options.fps);
  }
  RenderOptions render_options;
  render_options.background = scene.settings.background_color();
  if (const std::vector<double>& b = options.background; !b.empty())
    render_options.background = Vec3d(b[0], b[1], b[2]).cast<float>();
  render_options.antialiased = scene.report.antialiased;

  const fs::path folder = video ? out.parent_path() : out;
  std::error_code failed;
  if (!folder.empty()) fs::create_directories(folder, failed);
  if (failed)
    throw usage_error("--out", out.string(), "cannot be made: " + failed.message(),
                      "give a folder that can be written");
  if (video) check_not_of_scene(out, scene);
  std::unique_ptr<VideoWriter> writer;
  if (video) writer = std::make_unique<VideoWriter>(out, path.fps, cameras[0].width, cameras[0].height);

  std::set<std::string> now, all;  // images, and with those of earlier calls
  if (!video) {
    for (const Camera& camera : cameras) {
      now.insert(camera.name + ".png");
      if (options.depth) now.insert(camera.name + "_depth.png");
    }
    all = written_before(out);
    check_replaced(out, now, all);
    all.insert(now.begin(), now.end());
    record_pictures(out, all);
  }

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
  } else {
    for (const std::string& name : all)
      if (!now.count(name)) fs::remove(out / name, failed);
    record_pictures(out, now);
  }
  context.progress.say("wrote " + std::to_string(cameras.size()) + (video ? " frames to " : " images to ") +
                       out.string());
  return {{"pictures", files}, {"cameras", cameras.size()}};
}

}  // namespace pliant

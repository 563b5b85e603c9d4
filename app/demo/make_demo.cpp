#include "app/demo/make_demo.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>

#include "app/demo/raycast.h"
#include "app/demo/reference.h"
#include "app/demo/splats.h"
#include "app/demo/stage.h"
#include "app/demo/train_splats.h"
#include "app/demo/truth.h"
#include "gaussians/base/error.h"
#include "gaussians/io/cameras/transforms.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/images/image_io.h"
#include "gaussians/io/images/video.h"
#include "gaussians/io/splats/ply.h"

namespace pliant {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

/// The one Young's modulus that scene.json offers is this much too soft for the stem.
constexpr double kYoungError = 3.5;

double since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// Lengths in the files are rounded to 0.01 mm, so that they read well.
double rounded(double x) { return std::round(x * 1e5) / 1e5; }

void check(const DemoOptions& options) {
  auto require = [](bool good, const char* field, double value, const char* remedy) {
    if (!good) throw usage_error("demo", field, "is " + std::to_string(value), remedy);
  };
  require(options.width >= 16, "width", options.width, "use 16 pixels or more");
  require(options.height >= 16, "height", options.height, "use 16 pixels or more");
  require(options.photos >= 1 && options.photos <= 1000, "photos", options.photos, "use 1 to 1000");
  require(options.video_particles >= 1000, "video_particles", options.video_particles, "use 1000 or more");
  require(options.video_seconds > 0, "video_seconds", options.video_seconds, "use a positive time");
  require(options.video_fps > 0, "video_fps", options.video_fps, "use a positive rate");
  require(options.training >= 0, "training", options.training, "use 0 or more");
  require(options.gaussians >= 100, "gaussians", options.gaussians, "use 100 or more");
}

/// Writes photos and masks; returns what the photos' files hold.
std::vector<ImageU8> write_photos(const Stage& stage, const fs::path& out, const std::vector<Camera>& cameras) {
  fs::create_directories(out / "photos");
  fs::create_directories(out / "masks");
  std::vector<ImageU8> photos;
  for (const Camera& camera : cameras) {
    const DemoPhoto photo = take_photo(stage, camera);
    photos.push_back(to_8_bit(photo.color));
    write_image(camera.photo, photo.color);
    write_ids(out / "masks" / (camera.name + ".png"), photo.ids);
  }
  return photos;
}

void write_reference(const DemoOptions& options, const Stage& stage, const std::vector<Camera>& cameras,
                     DemoSummary& summary) {
  const std::string name = front_view_name(options.photos);
  const Camera& camera = *std::find_if(cameras.begin(), cameras.end(), [&](const Camera& c) { return c.name == name; });
  ReferenceOptions reference;
  reference.particles = options.video_particles;
  reference.seed = options.seed;
  reference.seconds = options.video_seconds;
  reference.fps = options.video_fps;
  auto start = std::chrono::steady_clock::now();
  const ReferenceMotion motion = simulate_reference(stage, reference);
  summary.simulate_seconds = since(start);
  summary.push_newtons = motion.interactions.back().vector.norm();

  start = std::chrono::steady_clock::now();
  const ReferenceFilm film = film_reference(stage, motion, camera);
  VideoWriter video(options.out / "reference.mp4", options.video_fps, camera.width, camera.height,
                    VideoCoding::kFaithful);
  for (const ImageF& frame : film.frames) video.write(frame);
  video.close();
  write_truth(options.out / "truth", motion, film, camera, options.seed);
  summary.peak_pixels = film.peak_pixels();
  summary.peak_metres = film.peak_metres();
  summary.film_seconds = since(start);
}

Json scene_json(const DemoOptions& options, const Stage& stage) {
  const auto [low, high] = stage.pinned_box();
  const ElasticSolid& stem = stage.flower().stem;
  Json scene;
  scene["splats"] = "splats.ply";
  scene["cameras"] = "transforms.json";
  scene["photos"] = "photos";
  scene["masks"] = "masks";
  scene["labels"] = "labels.json";
  if (options.video) {
    scene["video"] = {
        {"file", "reference.mp4"}, {"camera", front_view_name(options.photos)}, {"fps", options.video_fps}};
  }
  scene["up"] = {0, 0, 1};
  scene["metres_per_unit"] = 1.0;
  scene["support"] = "table";
  scene["object"] = "flower";
  scene["pinned"] = {{{"box",
                       {rounded(low.x()), rounded(low.y()), rounded(low.z()), rounded(high.x()), rounded(high.y()),
                        rounded(high.z())}}}};
  scene["material"] = {
      {"young", 100 * std::round(stem.young / kYoungError / 100)}, {"poisson", 0.3}, {"density", stem.density}};
  return scene;
}

}  // namespace

std::vector<std::string> demo_kinds() { return {"potted-flower"}; }

DemoSummary make_demo(const DemoOptions& options) {
  check(options);
  DemoSummary summary;
  const fs::path& out = options.out;
  fs::create_directories(out);
  const Stage stage(options.seed);
  std::vector<Camera> cameras = stage_cameras(stage, options.photos, options.width, options.height);
  for (Camera& camera : cameras) camera.photo = (out / "photos" / (camera.name + ".png")).string();

  auto start = std::chrono::steady_clock::now();
  const std::vector<ImageU8> photos = write_photos(stage, out, cameras);
  write_transforms(out / "transforms.json", cameras);
  summary.photos = static_cast<int>(cameras.size());
  summary.photo_seconds = since(start);

  start = std::chrono::steady_clock::now();
  StageSplats splats = make_splats(stage, cameras, options.gaussians, options.seed);
  splats.cloud = train_splats(splats.cloud, cameras, photos, options.training, options.seed);
  write_ply(out / "splats.ply", splats.cloud);
  Json labels;
  for (const auto& [id, name] : stage_names()) labels[std::to_string(id)] = name;
  write_text(out / "labels.json", labels.dump(2) + "\n");
  summary.gaussians = splats.cloud.size();
  summary.splat_seconds = since(start);
  for (const uint32_t id : splats.label) ++summary.gaussians_of[stage_names().at(id)];

  write_truth(out / "truth", stage, splats, options.seed);
  write_hidden_truth(out / "truth", stage, cameras);
  if (options.video) write_reference(options, stage, cameras, summary);

  // Last, so that a scene file stands only beside a whole scene.
  write_text(out / "scene.json", scene_json(options, stage).dump(2) + "\n");
  summary.mechanics = flower_mechanics(stage.flower());
  summary.flower_height = stage.flower().height;
  return summary;
}

}  // namespace pliant

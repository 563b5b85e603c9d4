#include "app/demo/make_demo.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "app/demo/kinds/flower.h"
#include "app/demo/kinds/kinds.h"
#include "app/demo/motion_cache.h"
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

/// The one Young's modulus that scene.json offers is this much too soft for the part that carries the others.
constexpr double kYoungError = 3.5;
/// Eight times the driving particles with which methods are compared, for half their grid spacing.
constexpr int kTruthParticles = 16000;
constexpr double kTruthSeconds = 2.5;
/// Of a simulation with more of them, in the truth; the video of other kinds than the flower is filmed from these.
constexpr size_t kFlowerStored = 2500, kStored = 4000;

/// Lengths in the files are rounded to 0.01 mm, so that they read well.
double rounded(double x) { return std::round(x * 1e5) / 1e5; }

void check(const DemoOptions& options) {
  auto require = [](bool good, const char* field, double value, const char* remedy) {
    if (!good) throw usage_error("demo", field, "is " + std::to_string(value), remedy);
  };
  require(options.width >= 16, "width", options.width, "use 16 pixels or more");
  require(options.height >= 16, "height", options.height, "use 16 pixels or more");
  require(options.photos >= 1 && options.photos <= 1000, "photos", options.photos, "use 1 to 1000");
  require(options.video_particles == 0 || options.video_particles >= 1000, "video_particles", options.video_particles,
          "use 1000 or more, or 0 for the kind's own number");
  require(options.video_seconds >= 0, "video_seconds", options.video_seconds,
          "use a positive time, or 0 for the kind's own");
  require(options.video_fps > 0, "video_fps", options.video_fps, "use a positive rate");
  require(options.training >= 0, "training", options.training, "use 0 or more");
  require(options.gaussians >= 100, "gaussians", options.gaussians, "use 100 or more");
}

/// Writes photos and masks; returns what the photos' files hold.
std::vector<ImageU8> write_photos(const Stage& stage, const fs::path& out, const std::vector<Camera>& cameras,
                                  const Interrupted& interrupted) {
  fs::create_directories(out / "photos");
  fs::create_directories(out / "masks");
  std::vector<ImageU8> photos;
  for (const Camera& camera : cameras) {
    stop_demo_if(is_interrupted(interrupted));
    const DemoPhoto photo = take_photo(stage, camera);
    photos.push_back(to_8_bit(photo.color));
    write_image(camera.photo, photo.color);
    write_ids(out / "masks" / (camera.name + ".png"), photo.ids);
  }
  return photos;
}

/// Films the motion and writes the video and the truth about it.
void write_film(const DemoOptions& options, const Stage& stage, const ReferenceMotion& motion, size_t every,
                const Camera& camera, const fs::path& video_file, const fs::path& truth) {
  const ReferenceFilm film = film_reference(stage, motion, camera, options.interrupted);
  VideoWriter video(video_file, options.video_fps, camera.width, camera.height, VideoCoding::kFaithful);
  for (const ImageF& frame : film.frames) video.write(frame);
  video.close();
  write_motion_truth(truth, motion, trajectory_of(motion, stage.object().name, every), film, camera, options.seed);
}

ReferenceOptions reference_options(const DemoOptions& options) {
  ReferenceOptions reference;
  if (options.kind != kPottedFlower) {
    reference.particles = kTruthParticles;
    reference.seconds = kTruthSeconds;
  }
  if (options.video_particles > 0) reference.particles = options.video_particles;
  if (options.video_seconds > 0) reference.seconds = options.video_seconds;
  reference.seed = options.seed;
  reference.fps = options.video_fps;
  reference.interrupted = options.interrupted;
  return reference;
}

/// The flower's one push.
void write_flower_reference(const DemoOptions& options, const Stage& stage, const Camera& camera) {
  const Flower flower = make_flower(options.seed);
  const ReferenceOptions reference = reference_options(options);
  const ReferenceBody body = flower_body(stage, flower, reference);
  const ReferenceScript script = flower_script(stage, flower, reference);
  const ReferenceMotion motion = simulate_reference(body, script.interactions, reference);
  const fs::path truth = options.out / "truth";
  write_film(options, stage, motion, std::max<size_t>(1, motion.particles / kFlowerStored), camera,
             options.out / "reference.mp4", truth);
  write_material_truth(truth, body, options.seed);
}

/// Four videos of an object, each with its script and motion.
void write_references(const DemoOptions& options, const Stage& stage, const ReferenceBody& body, const Camera& camera) {
  const ReferenceOptions reference = reference_options(options);
  const std::vector<ReferenceScript> scripts = reference_scripts(stage, body, reference);
  const fs::path truth = options.out / "truth";
  fs::create_directories(options.out / "videos");
  for (const ReferenceScript& script : scripts) {
    const ReferenceMotion motion = cached_reference(options.cache, body, script.interactions, reference, kStored);
    write_film(options, stage, motion, 1, camera, options.out / "videos" / (script.name + ".mp4"), truth / script.name);
  }
}

Json pin_json(const Region& pin) {
  const Vec3d &p = pin.point, &v = pin.vector;
  if (pin.kind == Region::Kind::kSphere)
    return {{"sphere", {rounded(p.x()), rounded(p.y()), rounded(p.z()), rounded(pin.radius)}}};
  return {{"box", {rounded(p.x()), rounded(p.y()), rounded(p.z()), rounded(v.x()), rounded(v.y()), rounded(v.z())}}};
}

Json scene_json(const DemoOptions& options, const Stage& stage) {
  const DemoObject& object = stage.object();
  const ElasticSolid& main = object.materials[object.main_material()].solid;
  Json scene;
  scene["splats"] = "splats.ply";
  scene["cameras"] = "transforms.json";
  scene["photos"] = "photos";
  scene["masks"] = "masks";
  scene["labels"] = "labels.json";
  if (options.video) {
    scene["video"] = {{"file", options.kind == kPottedFlower ? "reference.mp4" : "videos/poke.mp4"},
                      {"camera", front_view_name(options.photos)},
                      {"fps", options.video_fps}};
  }
  scene["up"] = {0, 0, 1};
  scene["metres_per_unit"] = 1.0;
  scene["support"] = "table";
  scene["object"] = object.name;
  for (const Region& pin : stage.pins()) scene["pinned"].push_back(pin_json(pin));
  scene["material"] = {
      {"young", 100 * std::round(main.young / kYoungError / 100)}, {"poisson", 0.3}, {"density", main.density}};
  return scene;
}

}  // namespace

DemoSummary make_demo(const DemoOptions& options) {
  check(options);
  DemoSummary summary;
  const fs::path& out = options.out;
  fs::create_directories(out);
  const bool flower = options.kind == kPottedFlower;
  const Stage stage(demo_kind(options.kind).make(options.seed), options.seed);
  std::vector<Camera> cameras = stage_cameras(stage, options.photos, options.width, options.height);
  for (Camera& camera : cameras) camera.photo = (out / "photos" / (camera.name + ".png")).string();

  const std::vector<ImageU8> photos = write_photos(stage, out, cameras, options.interrupted);
  write_transforms(out / "transforms.json", cameras);
  summary.photos = static_cast<int>(cameras.size());

  StageSplats splats = make_splats(stage, cameras, options.gaussians, options.seed);
  splats.cloud = train_splats(splats.cloud, cameras, photos, options.training, options.seed, options.interrupted);
  write_ply(out / "splats.ply", splats.cloud);
  Json labels;
  for (const auto& [id, name] : stage.names()) labels[std::to_string(id)] = name;
  write_text(out / "labels.json", labels.dump(2) + "\n");
  summary.gaussians = splats.cloud.size();

  const fs::path truth = out / "truth";
  write_label_truth(truth, flower ? "flower_parts.h5" : "parts.h5", stage, splats, options.seed);
  write_hidden_truth(truth, stage, cameras);
  const std::string front = front_view_name(options.photos);
  const Camera& camera =
      *std::find_if(cameras.begin(), cameras.end(), [&](const Camera& c) { return c.name == front; });
  if (flower) {
    write_flower_truth(truth, make_flower(options.seed), options.seed);
    if (options.video) write_flower_reference(options, stage, camera);
  } else {
    const ReferenceBody body = reference_body(stage, reference_options(options));
    write_material_truth(truth, body, options.seed);
    write_object_truth(truth, options.kind, stage.object(), body, options.seed);
    if (options.video) write_references(options, stage, body, camera);
  }

  // Last, so that a scene file stands only beside a whole scene.
  write_text(out / "scene.json", scene_json(options, stage).dump(2) + "\n");
  return summary;
}

}  // namespace pliant

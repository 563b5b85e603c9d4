#include "app/fit/fit_video.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/fit/named_video.h"
#include "app/run/attach_scene.h"
#include "app/run/physdreamer_scene.h"
#include "app/simulate/clip_camera.h"
#include "app/store/lenses.h"
#include "fitting/observe/find_camera.h"
#include "fitting/observe/frame_source.h"
#include "fitting/observe/generate_video.h"
#include "gaussians/base/error.h"
#include "gaussians/io/cameras/cameras.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/splats/ply.h"

namespace pliant {
namespace fs = std::filesystem;

namespace {

constexpr double kGeneratedFps = 24;
constexpr int kMostPixels = 1600;  // of the longer side, before a camera that is to be found
const char* const kGenerated = "fit/generated";

/// `otherwise`: what may stand there instead of the name of one of them.
const Camera& camera_named(const std::vector<Camera>& cameras, const std::string& name, const std::string& where,
                           const std::vector<std::string>& otherwise = {}) {
  for (const Camera& camera : cameras)
    if (camera.name == name) return camera;
  std::vector<std::string> names = otherwise;
  for (const Camera& camera : cameras) names.push_back(camera.name);
  throw usage_error("--video-camera", name, "is not a camera of " + where,
                    fmt::format("did you mean '{}'?", nearest_name(name, names)));
}

/// The camera of a pose file that has one, or the one of that name.
Camera camera_of_pose_file(const Context& context, const FitStage& stage) {
  if (stage.camera() == kFindCamera)
    throw usage_error("--video-camera", kFindCamera, "and --video-pose are both given",
                      "give one of them; --refine-camera refines a pose");
  const CameraFile file = read_cameras(stage.pose, {}, PhotoFit::kView);
  for (const std::string& warning : file.warnings) context.progress.warn(warning);
  const std::vector<Camera>& cameras = file.cameras;
  if (cameras.empty())
    throw input_error(stage.pose, "", "has no camera",
                      "give a transforms.json, cameras.json or COLMAP model with the video's camera");
  if (!stage.camera().empty()) return camera_named(cameras, stage.camera(), stage.pose);
  if (cameras.size() > 1)
    throw usage_error("--video-pose", stage.pose, fmt::format("has {} cameras", cameras.size()),
                      "choose the video's camera with --video-camera NAME");
  return cameras[0];
}

RenderOptions rendering_of(const Scene& scene) {
  RenderOptions rendering;
  rendering.antialiased = scene.report.antialiased;
  rendering.background = scene.settings.background_color();
  return rendering;
}

/// Which of several videos of a PhysDreamer folder is fitted, and how to fit others.
void tell_choice(const Context& context, const Scene& scene, const FitStage& stage, const fs::path& file) {
  const std::optional<PhysDreamerFolder> folder = physdreamer_folder(scene);
  if (!stage.video().empty() || !folder || folder->videos.size() < 2) return;
  std::string others;
  for (const PhysDreamerFolder::Video& video : folder->videos)
    if (video.file != file) others += (others.empty() ? "" : ", ") + video.file.filename().string();
  context.progress.warn(
      fmt::format("{} is fitted, and not {}: generated clips show different motions. --video FILE or --video-camera "
                  "NAME picks another; repeat --video FILE for videos that were filmed at the same time",
                  file.string(), others));
}

/// Also keeps it, after those `found` for videos before, under a name of its own.
void tell(const Context& context, const RunDirectory& run, const RefinedCamera& refined, std::vector<Camera>& found) {
  Camera camera = refined.camera;
  if (std::ranges::any_of(found, [&](const Camera& other) { return other.name == camera.name; }))
    camera.name += fmt::format("_{}", found.size() + 1);
  found.push_back(camera);
  fs::create_directories(run / "fit");
  write_cameras(run / "fit/transforms.json", found);
  context.progress.say(
      fmt::format("fit: the video's camera matches the scene with score {:.2f} (before: {:.2f}), offset {:.2f} px, "
                  "after {} renders",
                  refined.after.score, refined.before.score, refined.after.shift, refined.renders));
}

ImageF first_picture(const fs::path& file, double folder_fps) {
  const std::optional<TimedFrame> first = open_frames(file, folder_fps)->next();
  if (!first) throw input_error(file.string(), "", "has no frames", "give a video or a folder of frames");
  return first->picture;
}

/// Of the longer side of a video whose camera is to be found: what the scene is drawn with shows no more.
int most_pixels(const Scene& scene) {
  int most = 0;
  for (const Camera& camera : scene.cameras) most = std::max({most, camera.width, camera.height});
  return std::min(most, kMostPixels);
}

Camera find_in_scene(const Context& context, const RunDirectory& run, const Scene& scene, const fs::path& file,
                     const ImageF& first, std::vector<Camera>& cameras) {
  context.progress.say(
      fmt::format("fit: searching for the video's camera among {} known cameras", scene.cameras.size()));
  FoundCamera found = find_camera({}, scene.cloud, rendering_of(scene), scene.cameras, first);
  if (!found.found) throw input_error(file.string(), "camera", found.sentence, "");
  context.progress.say("fit: " + found.sentence);
  found.refined.camera.name = scene.cameras[found.nearest].name + "_found";
  tell(context, run, found.refined, cameras);
  return found.refined.camera;
}

/// Where the lenses of the scene's cameras are, if a training has removed them from the photos.
fs::path lens_file(const Scene& scene) {
  const fs::path& cameras = scene.settings.cameras;
  return cameras.empty() ? fs::path() : cameras.parent_path() / kLensFile;
}

ReferenceVideo tell_lens(const Context& context, ReferenceVideo video) {
  if (video.lens)
    context.progress.say(
        fmt::format("fit: the lens of camera '{}' is removed from the video, as from its photo", video.camera.name));
  return video;
}

ReferenceVideo generate(const Context& context, const RunDirectory& run, const FitInputs& in, const FitStage& stage) {
  const Scene& scene = in.scene;
  const Camera camera = unfilmed_camera(context, in.files.at("object"), scene, stage);
  GenerateOptions options;
  options.command = stage.generate.command;
  options.prompt = stage.generate.prompt;
  options.frames = stage.generate.frames;
  options.fps = stage.fps > 0 ? stage.fps : kGeneratedFps;
  options.seed = context.seed;
  options.interrupted = context.interrupted;
  options.made_for = record_of(key_of(in), context.seed).dump();
  const fs::path folder = run / kGenerated;
  context.progress.say(fmt::format("fit: `{}` {} {} frames from camera '{}'", options.command,
                                   has_generated(options, folder) ? "has generated" : "generates", options.frames,
                                   camera.name));
  return generate_video(options, render(scene.cloud, camera, rendering_of(scene)).color, camera, folder);
}

ReferenceVideo load_video(const Context& context, const RunDirectory& run, const FitInputs& in, const FitStage& stage,
                          const ReferenceVideo* beside, std::vector<Camera>& found) {
  const Scene& scene = in.scene;
  if (!stage.generate.command.empty()) return generate(context, run, in, stage);
  const NamedVideo named = named_video(scene, stage);
  const fs::path& file = named.file;
  const std::string& name = named.camera;
  tell_choice(context, scene, stage, file);
  VideoOptions options;
  options.fps = beside ? beside->fps : stage.compare_fps;
  options.declared_fps = named.fps;
  options.trust_declared = named.fps_holds;
  options.first = beside ? beside->start : stage.first;
  options.exact_start = beside != nullptr;
  options.last = stage.last;
  Camera camera;
  if (!stage.pose.empty())
    camera = camera_of_pose_file(context, stage);
  else if (!name.empty())
    camera = camera_named(scene.cameras, name, "the scene", {kFindCamera});
  const auto lenses = in.files.find("lenses");
  if (lenses != in.files.end() && stage.pose.empty() && camera.width > 0)
    options.lens = read_lens(lenses->second, camera);
  if (camera.width > 0 && named.physdreamer) {
    const ImageF first = first_picture(file, options.declared_fps);
    camera = physdreamer_camera(camera, first.width, first.height);
  }
  if (camera.width > 0 && !stage.refine_camera) return tell_lens(context, load_reference_video(options, file, camera));

  // The first frame says where its camera is.
  Camera any = camera;
  if (any.width == 0) {
    const ImageF first = first_picture(file, options.declared_fps);
    any.name = "video";
    const double scale = std::min(1.0, most_pixels(scene) / static_cast<double>(std::max(first.width, first.height)));
    any.width = std::max(1, static_cast<int>(std::lround(scale * first.width)));
    any.height = std::max(1, static_cast<int>(std::lround(scale * first.height)));
  }
  ReferenceVideo video = load_reference_video(options, file, any);
  if (camera.width == 0) {
    video.camera = find_in_scene(context, run, scene, file, video.frames[0], found);
  } else {
    const RefinedCamera refined = refine_camera({}, scene.cloud, rendering_of(scene), camera, video.frames[0]);
    tell(context, run, refined, found);
    video.camera = refined.camera;
  }
  return tell_lens(context, std::move(video));
}

}  // namespace

FitStage further_video(const FitStage& stage, size_t i) {
  const size_t k = i + 1;
  if (k >= stage.videos.size()) {
    const bool camera = k < stage.cameras.size();
    const std::string option = stage.typed(camera ? "video-camera" : "video-mask");
    throw usage_error(option, camera ? stage.cameras[k] : stage.masks[k], "has no video",
                      fmt::format("give --video FILE as often as {}, in the same order", option));
  }
  const auto only = [k](std::vector<std::string>& all) {
    all = k < all.size() ? std::vector<std::string>{all[k]} : std::vector<std::string>{};
  };
  FitStage one = stage;
  one.beside = true;
  one.generate = {};
  one.pose.clear();
  only(one.videos);
  only(one.cameras);
  only(one.masks);
  return one;
}

Camera unfilmed_camera(const Context& context, const fs::path& object, const Scene& scene, const FitStage& stage) {
  const std::string name = known_camera(scene, stage);
  if (!stage.pose.empty()) return camera_of_pose_file(context, stage);
  if (!name.empty()) return camera_named(scene.cameras, name, "the scene");
  return clip_camera(scene, "", robust_bounds(read_ply(object)));
}

ReferenceVideo load_fit_video(const Context& context, const RunDirectory& run, const FitInputs& in,
                              const FitStage& stage, const ReferenceVideo* beside, std::vector<Camera>* found) {
  std::vector<Camera> alone;
  ReferenceVideo video = load_video(context, run, in, stage, beside, found ? *found : alone);
  if (has_mask(stage)) check_mask(context, in, stage, video);
  return video;
}

ImageF load_object_mask(const Scene& scene, const Camera& camera) {
  const std::optional<PhysDreamerFolder> folder = physdreamer_folder(scene);
  return folder ? physdreamer_mask(*folder, camera) : ImageF();
}

bool has_video(const Scene& scene, const FitStage& stage) {
  return !stage.video().empty() || !stage.generate.command.empty() || scene.settings.video;
}

InputFiles video_files(const Scene& scene, const FitStage& stage) {
  InputFiles files;
  if (stage.generate.command.empty()) files["video"] = named_video(scene, stage).file;
  std::error_code ignored;
  if (fs::is_regular_file(lens_file(scene), ignored)) files["lenses"] = lens_file(scene);
  if (has_mask(stage)) files["video_mask"] = stage.video_mask();
  for (size_t i = 0; i < stage.further_videos(); ++i) {
    const FitStage one = further_video(stage, i);
    files["video_" + std::to_string(i + 2)] = one.video();
    if (has_mask(one)) files["video_mask_" + std::to_string(i + 2)] = one.video_mask();
  }
  return files;
}

nlohmann::json video_records(const Scene& scene, const FitStage& stage) {
  nlohmann::json records = nlohmann::json::array();
  const auto add = [&](const FitStage& one) {
    const NamedVideo video = named_video(scene, one);
    records.push_back({{"camera", video.camera}, {"fps", video.fps}, {"fps_holds", video.fps_holds}});
  };
  if (stage.generate.command.empty()) add(stage);
  for (size_t i = 0; i < stage.further_videos(); ++i) add(further_video(stage, i));
  return records;
}

bool knows_cameras(const Scene& scene, const FitStage& stage) {
  bool known = !stage.pose.empty() || !stage.generate.command.empty() || !named_video(scene, stage).camera.empty();
  for (size_t i = 0; i < stage.further_videos(); ++i)
    known = known && !named_video(scene, further_video(stage, i)).camera.empty();
  return known;
}

std::string with_video(const RunDirectory& run, const FitStage& stage, const std::string& provenance) {
  if (stage.generate.command.empty()) return provenance;
  nlohmann::json with = nlohmann::json::parse(provenance);
  with["inputs"]["video"] = hash_of_input(run / kGenerated / "frames");
  return with.dump();
}

std::string video_name(const Scene& scene, const FitStage& stage) {
  return stage.generate.command.empty() ? named_video(scene, stage).file.string()
                                        : "the video of `" + stage.generate.command + "`";
}

}  // namespace pliant

#include "app/fit/fit_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "app/fit/fit_video.h"
#include "app/run/attach_scene.h"
#include "app/simulate/moving_scene.h"
#include "app/simulate/simulate_stage.h"
#include "app/simulate/simulation_plan.h"
#include "app/store/particles.h"
#include "fitting/observe/check_video.h"
#include "fitting/observe/track_pixels.h"
#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/splats/ply.h"

namespace pliant {
namespace {

constexpr double kLeastForeground = 0.5;  // of what can move: less says that a mask is of something else

/// A video that no motion of the object can explain is refused; what is doubtful is said.
void check(const Context& context, FitView& view, const std::string& file) {
  const VideoChecks checks = check_video({}, view.video, view.still, view.mask, view.compared);
  require_usable(checks, file);
  for (const VideoFinding& finding : checks.findings) context.progress.warn(finding.sentence);
  if (checks.find(VideoProblem::kNotAtRest)) view.displaced = checks.displaced;
}

/// Gaussians of the object that follow a driver and are not held.
std::vector<uint8_t> free_gaussians(const CloudOf<float>& object, const Binding& binding) {
  std::vector<uint8_t> free(object.size());
  for (size_t i = 0; i < free.size(); ++i) free[i] = binding.driver[i * Binding::kCount] >= 0;
  return free;
}

/// Surface points on a grid over the pixels in which mostly free Gaussians are seen.
void choose_points(FitView& fit, const ImageF& depth, int wanted) {
  size_t inside = 0;
  for (const float share : fit.moving.data) inside += share > 0.8f;
  if (inside < 30)
    throw input_error("fit", "object",
                      fmt::format("covers only {} movable pixels of camera '{}'", inside, fit.video.camera.name),
                      "check the camera of the video, and what is pinned");
  const double step = std::max(1.0, std::sqrt(static_cast<double>(inside) / wanted));
  const Camera& camera = fit.video.camera;
  const Eigen::Isometry3d world_from_cam = camera.cam_from_world.inverse();
  for (double y = step / 2; y < fit.moving.height; y += step)
    for (double x = step / 2; x < fit.moving.width; x += step) {
      const int i = static_cast<int>(x), j = static_cast<int>(y);
      if (!(fit.moving(i, j) > 0.8f) || !is_compared(fit, 0, i, j)) continue;
      const Eigen::Vector2d pixel(i + 0.5, j + 0.5);
      const double z = depth(i, j);
      fit.pixel.push_back(pixel);
      fit.points.push_back(
          (world_from_cam * Vec3d((pixel.x() - camera.cx) / camera.fx * z, (pixel.y() - camera.cy) / camera.fy * z, z))
              .cast<float>());
    }
}

/// The body and its Gaussians in front of the repaired background.
FitScene load_body(const Context& context, const FitInputs& in) {
  FitScene fit;
  const Scene& scene = in.scene;
  ParticleFile particles = read_particles(in.files.at("particles"));
  fit.start = start_material(in, particles, &context.progress);
  fit.body = make_body(std::move(particles), scene, fit.start.solid, fit.start.law);
  fit.pins = pins_of(fit.body.file.pinned_json, scene);
  GaussianCloud object = read_ply(in.files.at("object")), background = read_ply(in.files.at("background"));
  const int degree = std::max(object.sh_degree, background.sh_degree);
  object = with_sh_degree(object, degree);
  background = with_sh_degree(background, degree);
  fit.drawn = std::make_shared<DrawnObject<float>>();
  DrawnObject<float>& drawn = *fit.drawn;
  drawn.metres_per_unit = scene.metres_per_unit;
  drawn.drivers = fit.body.file.driving_position;
  drawn.render.antialiased = scene.report.antialiased;
  drawn.render.background = scene.settings.background_color();
  drawn.binding = bind_object(scene, fit.body.file, object);
  drawn.object = object;
  drawn.background = background;
  return fit;
}

/// What the view's camera sees of it at rest; returns the depth [H, W, 1] of what can move.
ImageF look(const FitScene& fit, FitView& view) {
  const DrawnObject<float>& drawn = *fit.drawn;
  const std::vector<uint8_t> free = free_gaussians(drawn.object, drawn.binding);
  const CloudOf<float> all = drawn.at(initial_state(fit.body.particles));
  std::vector<float> features(2 * all.size(), 0.0f);
  for (size_t i = 0; i < free.size(); ++i)
    if (free[i]) {
      const size_t g = drawn.background.size() + i;
      features[2 * g] = 1;
      features[2 * g + 1] = static_cast<float>((view.video.camera.cam_from_world * all.position[g].cast<double>()).z());
    }
  const RenderResult picture = render(all, view.video.camera, drawn.render, features, 2);
  view.still = picture.color;
  view.moving = ImageF(picture.color.width, picture.color.height, 1);
  ImageF depth = view.moving;
  for (size_t i = 0; i < view.moving.data.size(); ++i) {
    view.moving.data[i] = picture.features.data[2 * i];
    depth.data[i] = picture.features.data[2 * i + 1] / std::max(picture.features.data[2 * i], 1e-6f);
  }
  view.mask = ImageU8(view.moving.width, view.moving.height, 1);
  for (size_t i = 0; i < view.mask.data.size(); ++i) view.mask.data[i] = view.moving.data[i] > 0.5f;
  return depth;
}

/// Only what the mask [H, W, 1] has as foreground can move in the view.
void keep_foreground(const Context& context, FitView& view, const ImageF& mask) {
  double before = 0, kept = 0;
  for (size_t i = 0; i < mask.data.size(); ++i) {
    before += view.moving.data[i];
    kept += view.moving.data[i] *= mask.data[i];
    view.mask.data[i] = view.moving.data[i] > 0.5f;
  }
  const std::string sentence = fmt::format("the mask of camera '{}' covers {:.0f} % of the movable pixels there",
                                           view.video.camera.name, 100 * kept / std::max(before, 1e-12));
  if (kept < kLeastForeground * before)
    context.progress.warn(sentence + ": check that it is bright where the object is");
  else
    context.progress.say("fit: " + sentence);
}

/// What `stage`, the whole one or that of a further video `beside` the first, shows; `found`: cameras of videos before.
FitView load_view(const Context& context, const RunDirectory& run, const FitInputs& in, const FitStage& stage,
                  const FitScene& fit, std::vector<Camera>& found, const ReferenceVideo* beside = nullptr) {
  FitView view;
  const Scene& scene = in.scene;
  view.video = load_fit_video(context, run, in, stage, beside, &found);
  for (const std::string& warning : view.video.warnings) context.progress.warn(warning);
  view.compared = load_compared(stage, view.video);
  const ImageF depth = look(fit, view);
  if (const ImageF mask = load_object_mask(scene, view.video.camera); mask.width > 0)
    keep_foreground(context, view, mask);
  check(context, view, video_name(scene, stage));
  choose_points(view, depth, stage.points);
  return view;
}

/// For an option whose time is not within the first `frames` frames of the used part.
Error not_within(const ReferenceVideo& video, int frames, const std::string& option, double time, const char* where) {
  return usage_error("fit", option,
                     fmt::format("is {:g} s, but the frames to fit last from {:.3f} s to {:.3f} s of the video", time,
                                 video.start, video.start + frames / video.fps),
                     std::string("give seconds from the start of the file, at least ") + where);
}

/// Frames of the used part up to `until`.
int frames_until(const FitStage& stage, const ReferenceVideo& video) {
  constexpr long kFewest = 3;
  const int frames = static_cast<int>(video.frames.size());
  if (!(stage.until > 0)) return frames;
  const long used = std::lround((stage.until - video.start) * video.fps) + 1;
  if (used < kFewest || stage.until > video.start + frames / video.fps + 1e-9)
    throw not_within(video, frames, stage.typed("end"), stage.until, "3 frames after the first of these");
  return static_cast<int>(std::min<long>(used, frames));
}

/// `from` on the clock of the used part, which begins with the frame nearest to `first`.
double free_after(const FitStage& stage, const ReferenceVideo& video, int used) {
  if (stage.from < 0) return -1;
  if (stage.from < std::min(stage.first, video.start) - 1e-9 ||
      std::lround((stage.from - video.start) * video.fps) > used - 2)
    throw not_within(video, used, stage.typed("start"), stage.from, "2 frames before the last of these");
  return std::max(0.0, stage.from - video.start);
}

}  // namespace

std::vector<const FitView*> FitScene::views() const {
  std::vector<const FitView*> all = {this};
  for (const FitView& view : further) all.push_back(&view);
  return all;
}

FitScene load_fit_scene(const Context& context, const RunDirectory& run, const FitInputs& in) {
  const FitStage& stage = in.options;
  FitScene fit = load_body(context, in);
  std::vector<Camera> found;
  static_cast<FitView&>(fit) = load_view(context, run, in, stage, fit, found);
  for (size_t i = 0; i < stage.further_videos(); ++i)
    fit.further.push_back(load_view(context, run, in, further_video(stage, i), fit, found, &fit.video));
  const std::optional<Interaction> floor = floor_of(in.found, {}, in.scene);
  if (floor && fit.pins.empty()) {
    context.progress.say("fit: nothing holds the object: the plane of '" +
                         in.found["contact"]["support"].get<std::string>() + "' is a floor, as in `simulate`");
    fit.pins.push_back(*floor);
  }
  fit.used = frames_until(stage, fit.video);
  for (const FitView& view : fit.further) fit.used = std::min(fit.used, static_cast<int>(view.video.frames.size()));
  fit.free_after = free_after(stage, fit.video, fit.used);
  return fit;
}

FitScene load_still_scene(const Context& context, const FitInputs& in, const Camera& camera) {
  FitScene fit = load_body(context, in);
  fit.video.camera = camera;
  look(fit, fit);
  return fit;
}

PointTracks follow_points(const Context& context, const FitScene& fit) {
  PointTracks tracks;
  tracks.camera = fit.video.camera;
  tracks.place.resize(fit.used);
  tracks.weight.resize(fit.used);
  int number = 0;
  for (const FitView* view : fit.views()) {
    // Where the first frame does not show the object at rest, the rendered scene does.
    const bool displaced = view->displaced > 0;
    std::vector<ImageF> with_rest;
    std::span<const ImageF> seen = std::span(view->video.frames).first(fit.used);
    if (displaced) {
      with_rest = {view->still};
      with_rest.insert(with_rest.end(), seen.begin(), seen.end());
      seen = with_rest;
    }
    PixelTracks followed = track_pixels({}, seen, view->pixel, view->mask);
    if (displaced) {
      followed.pixel.erase(followed.pixel.begin());
      followed.weight.erase(followed.weight.begin());
    }
    context.progress.say(fmt::format("fit: {} points tracked through {} frames of camera '{}', mean weight {:.2f}",
                                     view->pixel.size(), fit.used, view->video.camera.name, followed.kept));
    if (followed.kept < 0.05)
      throw input_error("fit", "video", "does not allow the object's points to be tracked",
                        "check that it shows this object from camera '" + view->video.camera.name + "'");
    for (int f = 0; f < fit.used && !view->compared.empty(); ++f)
      for (size_t k = 0; k < view->pixel.size(); ++k)
        if (!is_compared(*view, f, followed.pixel[f][k].x(), followed.pixel[f][k].y())) followed.weight[f][k] = 0;
    tracks.rest.insert(tracks.rest.end(), view->points.begin(), view->points.end());
    tracks.camera_of.insert(tracks.camera_of.end(), view->points.size(), number);
    if (number++ > 0) tracks.further.push_back(view->video.camera);
    for (int f = 0; f < fit.used; ++f) {
      for (const Eigen::Vector2d& x : followed.pixel[f]) tracks.place[f].push_back({x.x(), x.y(), 0});
      tracks.weight[f].insert(tracks.weight[f].end(), followed.weight[f].begin(), followed.weight[f].end());
    }
  }
  return tracks;
}

bool is_compared(const FitView& view, int frame, double x, double y) {
  if (!(x >= 0 && y >= 0 && x < view.moving.width && y < view.moving.height)) return false;
  if (view.compared.empty()) return true;
  return view.compared[view.compared.size() == 1 ? 0 : frame](static_cast<int>(x), static_cast<int>(y)) > 0;
}

void leave_out(ImageF& mask, const FitView& view, int frame) {
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x)
      if (!is_compared(view, frame, x, y)) mask(x, y) = 0;
}

ImageF motion_mask(const FitView& fit, int frames, int grow) {
  cv::Mat mask(fit.moving.height, fit.moving.width, CV_8U, cv::Scalar(0)), unknown = mask.clone();
  const ImageF& first = fit.video.frames[0];
  for (int y = 0; y < mask.rows; ++y)
    for (int x = 0; x < mask.cols; ++x) {
      float change = -1;  // in no frame yet
      for (int f = std::min(1, frames - 1); f < frames && is_compared(fit, 0, x, y); ++f)
        for (int c = 0; c < 3 && is_compared(fit, f, x, y); ++c)
          change = std::max(change, std::abs(fit.video.frames[f](x, y, c) - first(x, y, c)));
      mask.at<uint8_t>(y, x) = change > 0.08f || fit.moving(x, y) > 0.5f;
      unknown.at<uint8_t>(y, x) = change < 0;
    }
  // What is narrow because something hides the rest of it stays.
  cv::Mat opened, grown;
  cv::morphologyEx(mask | unknown, opened, cv::MORPH_OPEN, cv::getStructuringElement(cv::MORPH_RECT, {3, 3}));
  cv::dilate(opened & mask, grown, cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * grow + 1, 2 * grow + 1}));
  ImageF out(mask.cols, mask.rows, 1);
  for (size_t i = 0; i < out.data.size(); ++i) out.data[i] = grown.data[i] ? 1.0f : 0.0f;
  return out;
}

}  // namespace pliant

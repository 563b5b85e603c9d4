#include "app/pipeline/fit_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "app/pipeline/fit_video.h"
#include "app/pipeline/moving_scene.h"
#include "app/store/particles.h"
#include "fitting/fit/check_video.h"
#include "fitting/fit/parts.h"
#include "fitting/fit/track_pixels.h"
#include "gaussians/base/error.h"
#include "gaussians/base/nearest.h"
#include "gaussians/io/files.h"
#include "gaussians/io/ply.h"

namespace pliant {
namespace {

/// A video that no motion of the object can explain is refused; what is doubtful is said.
void check(const Context& context, const FitScene& fit, const std::string& file) {
  const VideoChecks checks = check_video({}, fit.video, fit.still, fit.mask);
  require_usable(checks, file);
  for (const VideoFinding& finding : checks.findings) context.progress.warn(finding.sentence);
}

/// Gaussians of the object that follow a driver and are not held.
std::vector<uint8_t> free_gaussians(const GaussianCloud& object, const Binding& binding) {
  std::vector<uint8_t> free(object.size());
  for (size_t i = 0; i < free.size(); ++i) free[i] = binding.driver[i * Binding::kCount] >= 0;
  return free;
}

/// Surface points on a grid over the pixels in which mostly free Gaussians are seen.
void choose_points(FitScene& fit, const ImageF& depth, int wanted) {
  size_t inside = 0;
  for (const float share : fit.moving.data) inside += share > 0.8f;
  if (inside < 30)
    throw input_error("fit", "object", fmt::format("shows only {} pixels that can move to camera '{}'", inside, fit.video.camera.name),
                      "check the camera of the video, and what is pinned");
  const double step = std::max(1.0, std::sqrt(static_cast<double>(inside) / wanted));
  const Camera& camera = fit.video.camera;
  const Eigen::Isometry3d world_from_cam = camera.cam_from_world.inverse();
  for (double y = step / 2; y < fit.moving.height; y += step)
    for (double x = step / 2; x < fit.moving.width; x += step) {
      const int i = static_cast<int>(x), j = static_cast<int>(y);
      if (!(fit.moving(i, j) > 0.8f)) continue;
      const Eigen::Vector2d pixel(i + 0.5, j + 0.5);
      const double z = depth(i, j);
      fit.pixel.push_back(pixel);
      fit.points.push_back((world_from_cam * Vec3d((pixel.x() - camera.cx) / camera.fx * z, (pixel.y() - camera.cy) / camera.fy * z, z)).cast<float>());
    }
}

}  // namespace

FitScene load_fit_scene(const Context& context, const RunDirectory& run, const Scene& scene, const FitStage& stage) {
  FitScene fit;
  fit.video = load_fit_video(context, run, scene, stage);
  for (const std::string& warning : fit.video.warnings) context.progress.warn(warning);
  const int frames = static_cast<int>(fit.video.frames.size());
  fit.used = stage.until > 0 ? std::clamp(static_cast<int>(std::lround(stage.until * fit.video.fps)) + 1, 3, frames) : frames;

  const std::string folder = object_folder(run);
  ParticleFile particles = read_particles(run / (folder + "/particles.h5"));
  const ObjectMaterial material = check_material(scene, stage.material, true);
  fit.solid = solid_material(particles, material);
  fit.body = make_body(std::move(particles), scene, fit.solid, material.material);
  fit.pins = pins_of(fit.body.file, scene);

  // The object in front of the repaired background, as far as this camera sees it.
  GaussianCloud object = read_ply(run / (folder + "/object.ply")), background = read_ply(run / "background_repaired.ply");
  const int degree = std::max(object.sh_degree, background.sh_degree);
  object = with_sh_degree(object, degree), background = with_sh_degree(background, degree);
  fit.drawn = std::make_shared<DrawnObject<float>>();
  DrawnObject<float>& drawn = *fit.drawn;
  drawn.metres_per_unit = scene.metres_per_unit;
  drawn.drivers = fit.body.file.driving_position;
  drawn.render.antialiased = scene.report.antialiased;
  drawn.binding = bind_object(scene, fit.body.file, object);
  drawn.object = object, drawn.background = background;

  const std::vector<uint8_t> free = free_gaussians(object, drawn.binding);
  const CloudOf<float> all = drawn.at(initial_state(fit.body.particles));
  std::vector<float> features(2 * all.size(), 0.0f);
  for (size_t i = 0; i < free.size(); ++i)
    if (free[i]) {
      const size_t g = background.size() + i;
      features[2 * g] = 1;
      features[2 * g + 1] = static_cast<float>((fit.video.camera.cam_from_world * all.position[g].cast<double>()).z());
    }
  const RenderResult picture = render(all, fit.video.camera, drawn.render, features, 2);
  fit.still = picture.color;
  fit.moving = ImageF(picture.color.width, picture.color.height, 1);
  ImageF depth = fit.moving;
  for (size_t i = 0; i < fit.moving.data.size(); ++i) {
    fit.moving.data[i] = picture.features.data[2 * i];
    depth.data[i] = picture.features.data[2 * i + 1] / std::max(picture.features.data[2 * i], 1e-6f);
  }
  fit.mask = ImageU8(fit.moving.width, fit.moving.height, 1);
  for (size_t i = 0; i < fit.mask.data.size(); ++i) fit.mask.data[i] = fit.moving.data[i] > 0.5f;
  check(context, fit, video_name(scene, stage));
  choose_points(fit, depth, stage.points);
  return fit;
}

PointTracks follow_points(const Context& context, const FitScene& fit) {
  ReferenceVideo seen = fit.video;
  seen.frames.resize(fit.used);
  const PixelTracks followed = track_pixels({}, seen, fit.pixel, fit.mask);
  context.progress.say(fmt::format("fit: {} points followed through {} frames, mean weight {:.2f}", fit.pixel.size(), fit.used, followed.kept));
  if (followed.kept < 0.05)
    throw input_error("fit", "video", "does not let the object's points be followed", "check that it shows this object from this camera");
  PointTracks tracks;
  tracks.rest = fit.points, tracks.camera = fit.video.camera, tracks.weight = followed.weight;
  for (const auto& frame : followed.pixel) {
    tracks.place.emplace_back();
    for (const Eigen::Vector2d& x : frame) tracks.place.back().push_back({x.x(), x.y(), 0});
  }
  return tracks;
}

std::vector<uint32_t> parts_of(const FitScene& fit, int count) {
  // A driver's colour is the mean of the Gaussians that it moves; one without any takes its nearest neighbour's.
  const DrawnObject<float>& drawn = *fit.drawn;
  const size_t drivers = drawn.drivers.size();
  std::vector<Vec3f> color(drivers, Vec3f::Zero());
  std::vector<float> weight(drivers, 0.0f);
  for (size_t g = 0; g < drawn.object.size(); ++g)
    for (int k = 0; k < Binding::kCount; ++k) {
      const size_t slot = g * Binding::kCount + k;
      const int d = drawn.binding.driver[slot];
      if (d < 0) break;
      const float* sh = drawn.object.sh_of(g);
      const float w = drawn.binding.weight[slot] * sigmoid(drawn.object.opacity_logit[g]);
      color[d] += w * (Vec3f::Constant(0.5f) + kSh0 * Vec3f(sh[0], sh[1], sh[2])).cwiseMax(0).cwiseMin(1), weight[d] += w;
    }
  std::vector<Vec3f> colored;
  std::vector<int> which;
  for (size_t d = 0; d < drivers; ++d)
    if (weight[d] > 0.05f) color[d] /= weight[d], colored.push_back(drawn.drivers[d]), which.push_back(static_cast<int>(d));
  if (!colored.empty()) {
    const std::vector<int> nearest = k_nearest(colored, drawn.drivers, 1);
    for (size_t d = 0; d < drivers; ++d)
      if (!(weight[d] > 0.05f)) color[d] = color[which[nearest[d]]];
  }
  PartsOptions options;
  options.count = count;
  return find_parts(options, drawn.drivers, color);
}

ImageF motion_mask(const FitScene& fit, int grow) {
  cv::Mat mask(fit.moving.height, fit.moving.width, CV_8U, cv::Scalar(0));
  const ImageF& first = fit.video.frames[0];
  for (int y = 0; y < mask.rows; ++y)
    for (int x = 0; x < mask.cols; ++x) {
      float change = 0;
      for (const ImageF& frame : fit.video.frames)
        for (int c = 0; c < 3; ++c) change = std::max(change, std::abs(frame(x, y, c) - first(x, y, c)));
      mask.at<uint8_t>(y, x) = change > 0.08f || fit.moving(x, y) > 0.5f;
    }
  cv::Mat opened, grown;
  cv::morphologyEx(mask, opened, cv::MORPH_OPEN, cv::getStructuringElement(cv::MORPH_RECT, {3, 3}));
  cv::dilate(opened, grown, cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * grow + 1, 2 * grow + 1}));
  ImageF out(mask.cols, mask.rows, 1);
  for (size_t i = 0; i < out.data.size(); ++i) out.data[i] = grown.data[i] ? 1.0f : 0.0f;
  return out;
}

}  // namespace pliant

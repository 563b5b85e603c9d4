#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/photo.hpp>

#include "app/evaluate/evaluate.h"
#include "app/evaluate/metrics.h"
#include "gaussians/base/error.h"
#include "gaussians/io/cameras/cameras.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/files/json_file.h"
#include "gaussians/io/images/image_io.h"
#include "gaussians/io/splats/ply.h"
#include "gaussians/render/render.h"

namespace fs = std::filesystem;
using nlohmann::json;

namespace pliant {
namespace {

constexpr uint32_t kSeenElsewhere = 1, kNeverSeen = 2;  // ids of truth/hidden
constexpr int kEdge = 2;                                // pixels around a mask that belong to its soft edge
constexpr double kSameDepth = 0.01;                     // relative difference below which two views look at one surface

/// Squared error over pixels, R, G and B.
struct SquaredError {
  double sum = 0;
  size_t count = 0;

  void add(const float* a, const float* b) {
    for (int k = 0; k < 3; ++k, ++count) sum += (static_cast<double>(a[k]) - b[k]) * (static_cast<double>(a[k]) - b[k]);
  }
  void add(const SquaredError& other) {
    sum += other.sum;
    count += other.count;
  }
  /// Null without pixels.
  json psnr() const { return count == 0 ? json(nullptr) : json(capped_psnr(sum / static_cast<double>(count))); }
};

/// One view of everything that is compared.
struct HiddenView {
  Camera camera;
  ImageF truth;  ///< photo without the object
  IdImage hidden;
  RenderResult before, after;  ///< background without and with the repair
  std::vector<ImageF> alone;   ///< the view inpainted by itself, by every baseline
};

cv::Mat mask_of(const IdImage& ids, uint32_t least, int grow) {
  cv::Mat mask(ids.height, ids.width, CV_8U);
  for (int y = 0; y < ids.height; ++y)
    for (int x = 0; x < ids.width; ++x) mask.at<uint8_t>(y, x) = ids(x, y) >= least ? 255 : 0;
  if (grow > 0) cv::dilate(mask, mask, cv::Mat::ones(2 * grow + 1, 2 * grow + 1, CV_8U));
  return mask;
}

/// OpenCV's inpainting of 8-bit pixels under the mask.
ImageF inpainted(const ImageF& picture, const cv::Mat& mask, int method) {
  cv::Mat bytes(picture.height, picture.width, CV_8UC3), filled;
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x)
      for (int k = 0; k < 3; ++k) bytes.at<cv::Vec3b>(y, x)[k] = cv::saturate_cast<uint8_t>(255 * picture(x, y, k));
  cv::inpaint(bytes, mask, filled, 5, method);
  ImageF out(picture.width, picture.height, 3);
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x)
      for (int k = 0; k < 3; ++k) out(x, y, k) = static_cast<float>(filled.at<cv::Vec3b>(y, x)[k]) / 255;
  return out;
}

/// Baselines: the photo without what the object covers, and the picture of the background without what nobody saw
/// (all that other views know is given to it), each by Telea's method and by Navier-Stokes.
const char* const kBaselines[] = {"photo_telea", "photo_navier_stokes", "background_telea", "background_navier_stokes"};
std::vector<ImageF> inpainted_alone(const HiddenView& view) {
  const ImageF photo = read_image(view.camera.photo);
  const cv::Mat object = mask_of(view.hidden, kSeenElsewhere, kEdge);
  cv::Mat unseen = mask_of(view.hidden, kNeverSeen, kEdge), open(unseen.size(), CV_8U);
  for (int y = 0; y < open.rows; ++y)
    for (int x = 0; x < open.cols; ++x)
      open.at<uint8_t>(y, x) = view.hidden(x, y) && view.before.alpha(x, y) < 0.9f ? 255 : 0;
  unseen |= open;
  return {inpainted(photo, object, cv::INPAINT_TELEA), inpainted(photo, object, cv::INPAINT_NS),
          inpainted(view.before.color, unseen, cv::INPAINT_TELEA),
          inpainted(view.before.color, unseen, cv::INPAINT_NS)};
}

void bilinear(const ImageF& image, double u, double v, float* out) {
  const double x = std::clamp(u - 0.5, 0.0, image.width - 1.001), y = std::clamp(v - 0.5, 0.0, image.height - 1.001);
  const int i = static_cast<int>(x), j = static_cast<int>(y);
  const float a = static_cast<float>(x - i), b = static_cast<float>(y - j);
  for (int k = 0; k < 3; ++k)
    out[k] = (1 - b) * ((1 - a) * image(i, j, k) + a * image(i + 1, j, k)) +
             b * ((1 - a) * image(i, j + 1, k) + a * image(i + 1, j + 1, k));
}

/// Never seen pixels of `from`, carried by its depth into `to` where they are never seen too and lie on the same
/// surface: the repair against itself and every baseline against itself.
void compare_views(const HiddenView& from, const HiddenView& to, SquaredError& repair,
                   std::vector<SquaredError>& alone) {
  const Eigen::Isometry3d to_from_camera = to.camera.cam_from_world * from.camera.cam_from_world.inverse();
  for (int y = 0; y < from.hidden.height; ++y)
    for (int x = 0; x < from.hidden.width; ++x) {
      if (from.hidden(x, y) != kNeverSeen || from.after.alpha(x, y) < 0.9f) continue;
      const double z = from.after.depth(x, y) / from.after.alpha(x, y);
      const Camera &a = from.camera, &b = to.camera;
      const Vec3d at = to_from_camera * Vec3d((x + 0.5 - a.cx) / a.fx * z, (y + 0.5 - a.cy) / a.fy * z, z);
      if (at.z() <= 0) continue;
      const double u = b.fx * at.x() / at.z() + b.cx, v = b.fy * at.y() / at.z() + b.cy;
      if (u < 0 || v < 0 || u >= b.width || v >= b.height) continue;
      const int px = static_cast<int>(u), py = static_cast<int>(v);
      if (to.hidden(px, py) != kNeverSeen || to.after.alpha(px, py) < 0.9f) continue;
      if (std::abs(to.after.depth(px, py) / to.after.alpha(px, py) - at.z()) > kSameDepth * at.z()) continue;
      float there[3];
      bilinear(to.after.color, u, v, there);
      repair.add(from.after.color.at(x, y), there);
      for (size_t k = 0; k < alone.size(); ++k) {
        bilinear(to.alone[k], u, v, there);
        alone[k].add(from.alone[k].at(x, y), there);
      }
    }
}

/// Refuses a run of another scene than this one or a copy of it, which has the same photos.  Unknown where run.json is
/// missing or names a scene that is no longer there.
void check_scene_of(const fs::path& run, const fs::path& scene) {
  std::error_code ignored;
  if (!fs::is_regular_file(run / "run.json", ignored)) return;
  const json manifest = read_json(run / "run.json");
  const json* recorded = find_value(manifest, "scene.source");
  if (!recorded || !recorded->is_string()) return;
  fs::path source = run / recorded->get<std::string>();
  if (fs::is_regular_file(source, ignored)) source = source.parent_path();
  if (!fs::is_directory(source, ignored) || fs::equivalent(source, scene, ignored)) return;
  const fs::path photo = pictures_of(scene / "photos").begin()->second, other = source / "photos" / photo.filename();
  if (fs::is_regular_file(other, ignored) && read_text(other) == read_text(photo)) return;
  throw input_error((run / "run.json").string(), "scene.source",
                    "is " + source.string() + ", which is not the scene " + scene.string(),
                    "give the scene that the run was made from");
}

std::vector<HiddenView> read_views(const fs::path& run, const fs::path& scene) {
  const fs::path truth = scene / "truth";
  for (const char* folder : {"without_object", "hidden"}) {
    std::error_code ignored;
    if (!fs::is_directory(truth / folder, ignored))
      throw input_error(scene.string(), std::string("truth/") + folder, "does not exist",
                        "give a scene made by `pliant demo`");
  }
  check_scene_of(run, scene);
  ReadReport report;
  const GaussianCloud before = read_ply(run / "background.ply", &report);
  const GaussianCloud after = read_ply(run / "background_repaired.ply");
  RenderOptions options;
  options.antialiased = report.antialiased;
  std::vector<HiddenView> views;
  for (const Camera& camera : read_cameras(cameras_in(scene), scene / "photos").cameras) {
    HiddenView view{camera,
                    read_image(truth / "without_object" / (camera.name + ".png")),
                    read_ids(truth / "hidden" / (camera.name + ".png")),
                    render(before, camera, options),
                    render(after, camera, options),
                    {}};
    if (view.truth.width != camera.width || view.hidden.width != camera.width || view.truth.height != camera.height ||
        view.hidden.height != camera.height)
      throw input_error((truth / "hidden" / (camera.name + ".png")).string(), "", "does not have the camera's size",
                        "make the scene again");
    view.alone = inpainted_alone(view);
    views.push_back(std::move(view));
  }
  return views;
}

}  // namespace

json evaluate_repair(const fs::path& run, const fs::path& scene) {
  const std::vector<HiddenView> views = read_views(run, scene);
  const size_t baselines = std::size(kBaselines);
  SquaredError never, never_before, elsewhere, elsewhere_before, outside, consistent;
  std::vector<SquaredError> alone(baselines), alone_consistent(baselines);
  json per_view = json::object();
  for (const HiddenView& view : views) {
    const cv::Mat near = mask_of(view.hidden, kSeenElsewhere, kEdge);
    SquaredError here, here_before;
    std::vector<SquaredError> here_alone(baselines);
    for (int y = 0; y < view.hidden.height; ++y)
      for (int x = 0; x < view.hidden.width; ++x) {
        const float* truth = view.truth.at(x, y);
        if (!near.at<uint8_t>(y, x)) outside.add(view.after.color.at(x, y), view.before.color.at(x, y));
        if (view.hidden(x, y) == kSeenElsewhere) {
          elsewhere.add(view.after.color.at(x, y), truth);
          elsewhere_before.add(view.before.color.at(x, y), truth);
        }
        if (view.hidden(x, y) != kNeverSeen) continue;
        here.add(view.after.color.at(x, y), truth);
        here_before.add(view.before.color.at(x, y), truth);
        for (size_t k = 0; k < baselines; ++k) here_alone[k].add(view.alone[k].at(x, y), truth);
      }
    never.add(here);
    never_before.add(here_before);
    for (size_t k = 0; k < baselines; ++k) alone[k].add(here_alone[k]);
    if (here.count) per_view[view.camera.name] = {{"pixels", here.count / 3}, {"psnr", here.psnr()}};
  }
  if (never.count == 0)
    throw input_error((scene / "truth/hidden").string(), "", "has no pixel hidden in all photos",
                      "there was nothing to fill in");
  for (const HiddenView& from : views)
    for (const HiddenView& to : views)
      if (&from != &to) compare_views(from, to, consistent, alone_consistent);

  size_t best = 0;
  json opencv = json::object();
  for (size_t k = 0; k < baselines; ++k) {
    if (alone[k].sum < alone[best].sum) best = k;
    opencv[kBaselines[k]] = {{"psnr", alone[k].psnr()}, {"consistency_psnr", alone_consistent[k].psnr()}};
  }
  const double gain = never.psnr().get<double>() - alone[best].psnr().get<double>();
  return {{"kind", "repair"},
          {"views", views.size()},
          {"pixels", never.count / 3},
          {"psnr", never.psnr()},
          {"psnr_before", never_before.psnr()},
          {"opencv", std::move(opencv)},
          {"opencv_best", kBaselines[best]},
          {"psnr_opencv", alone[best].psnr()},
          {"gain_over_opencv", gain},
          {"consistency_pixels", consistent.count / 3},
          {"consistency_psnr", consistent.psnr()},
          {"consistency_psnr_opencv", alone_consistent[best].psnr()},
          {"seen_elsewhere_psnr", elsewhere.psnr()},
          {"seen_elsewhere_psnr_before", elsewhere_before.psnr()},
          {"outside", {{"psnr", outside.psnr()}, {"identical", outside.sum == 0}}},
          {"per_view", std::move(per_view)}};
}

}  // namespace pliant

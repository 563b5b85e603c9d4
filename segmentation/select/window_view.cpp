#include "segmentation/select/window_view.h"

#include <algorithm>
#include <cmath>

#include "gaussians/base/error.h"
#include "gaussians/base/portable.h"
#include "gaussians/render/blend_weights.h"
#include "gaussians/render/project_input.h"

namespace pliant {

WindowView::WindowView(const std::vector<Camera>& cameras, int camera_index, const PictureRect& rect, int longest)
    : source(camera_index), camera(cameras[camera_index]), x0(rect.x0), y0(rect.y0) {
  const Camera& whole = cameras[camera_index];
  CHECK(!rect.empty() && longest > 0);
  const double width = rect.x1 - rect.x0, height = rect.y1 - rect.y0;
  scale = longest / std::max(width, height);
  frame = {x0 * scale, y0 * scale, whole.width * scale, whole.height * scale};
  camera.photo.clear();
  camera.width = std::max(8, static_cast<int>(std::lround(width * scale)));
  camera.height = std::max(8, static_cast<int>(std::lround(height * scale)));
  camera.fx *= scale;
  camera.fy *= scale;
  camera.cx = (camera.cx - x0) * scale;
  camera.cy = (camera.cy - y0) * scale;
}

bool project_point(const Camera& camera, const Vec3f& x, Eigen::Vector2d& pixel) {
  const Vec3d p = camera.cam_from_world * x.cast<double>();
  if (!(p.z() > splat::kNear)) return false;
  pixel = {camera.fx * p.x() / p.z() + camera.cx, camera.fy * p.y() / p.z() + camera.cy};
  return true;
}

std::vector<int> may_show(const GaussianCloud& cloud, const Camera& camera, const std::optional<PictureFrame>& frame) {
  constexpr double kReach = 3.5, kFilter = 2;  // standard deviations of a splat, and px for the low-pass filter
  // The Jacobian of the projection stretches by at most this, see View.
  const View<double> view = make_view<double>(camera, splat::kScreenVariance, frame);
  const double x = std::max(std::abs(view.low_x), std::abs(view.high_x)),
               y = std::max(std::abs(view.low_y), std::abs(view.high_y));
  const double stretch = kReach * std::sqrt(1 + x * x + y * y) * std::max(camera.fx, camera.fy);
  std::vector<uint8_t> shows(cloud.size(), 0);
  parallel_for(
      static_cast<std::ptrdiff_t>(cloud.size()),
      [&](std::ptrdiff_t p) {
        Eigen::Vector2d at;
        if (!project_point(camera, cloud.position[p], at)) return;
        const double depth = (camera.cam_from_world * cloud.position[p].cast<double>()).z();
        const double reach = kFilter + stretch * std::exp(static_cast<double>(cloud.log_scale[p].maxCoeff())) / depth;
        shows[p] =
            at.x() > -reach && at.y() > -reach && at.x() < camera.width + reach && at.y() < camera.height + reach;
      },
      4096);
  std::vector<int> out;
  for (size_t p = 0; p < shows.size(); ++p)
    if (shows[p]) out.push_back(static_cast<int>(p));
  return out;
}

std::vector<uint8_t> stroke_pixels(const WindowView& window, const StrokePrompt& stroke) {
  std::vector<uint8_t> mask(static_cast<size_t>(window.camera.width) * window.camera.height, 0);
  const float radius = std::max(0.75f, 0.5f * stroke.width * static_cast<float>(window.scale));
  for (size_t k = 0; k < stroke.points.size(); ++k) {
    const Vec2f a = window.to_window(stroke.points[k].x(), stroke.points[k].y());
    const Vec2f& next = stroke.points[std::min(k + 1, stroke.points.size() - 1)];
    const Vec2f d = window.to_window(next.x(), next.y()) - a;
    const Vec2f low = a.cwiseMin(a + d).array() - radius - 1, high = a.cwiseMax(a + d).array() + radius + 1;
    for (int y = std::max(0, static_cast<int>(low.y()));
         y < std::min<int>(window.camera.height, static_cast<int>(high.y()) + 1); ++y)
      for (int x = std::max(0, static_cast<int>(low.x()));
           x < std::min<int>(window.camera.width, static_cast<int>(high.x()) + 1); ++x) {
        const Vec2f p(x + 0.5f, y + 0.5f);
        const float t = std::clamp((p - a).dot(d) / std::max(d.squaredNorm(), 1e-12f), 0.0f, 1.0f);
        if ((p - a - t * d).norm() <= radius) mask[static_cast<size_t>(y) * window.camera.width + x] = 1;
      }
  }
  return mask;
}

void Lift::add(const GaussianCloud& cloud, const Camera& camera, const RenderOptions& options,
               const std::vector<uint8_t>& mask) {
  CHECK(inside.size() == cloud.size());
  const std::vector<int> shows = may_show(cloud, camera, options.frame);
  const BlendWeights weights = blend_weights(cloud.select(shows), camera, options);
  CHECK(mask.size() == weights.pixels());
  for (size_t pixel = 0; pixel < weights.pixels(); ++pixel)
    for (uint32_t e = weights.row_start[pixel]; e < weights.row_start[pixel + 1]; ++e) {
      const int p = shows[weights.gaussian[e]];
      total[p] += weights.weight[e];
      if (mask[pixel]) inside[p] += weights.weight[e];
    }
}

void Lift::add(const Lift& other, float weight) {
  for (size_t p = 0; p < total.size(); ++p) {
    inside[p] += weight * other.inside[p];
    total[p] += weight * other.total[p];
  }
}

}  // namespace pliant

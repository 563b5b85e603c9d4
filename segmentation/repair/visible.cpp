#include "segmentation/repair/visible.h"

#include <cmath>
#include <opencv2/imgproc.hpp>

namespace pliant {
namespace {

constexpr int kSoftEdge = 2;      // pixels around a hole that belong to its blurred border
constexpr double kSlack = 0.02;   // of the depth of what is there
constexpr float kBeside = 0.01f;  // blend weight of the object below which a pixel is beside it ...
constexpr int kFarBeside = 4;     // ... if it is so in as many pixels around

/// Where views see points: 1 = in front of what is there, in the hole; 2 = outside it, in front of what is there, or
/// less than `depth_beside` times as far beside the object.  What a view shows behind the object, where there is
/// nothing, it did not see.
std::vector<uint8_t> where_seen(const std::vector<Vec3f>& points, double depth_beside,
                                const std::vector<HoleView>& views, const Observation& observation,
                                const std::vector<Camera>& cameras) {
  std::vector<uint8_t> seen(points.size(), 0);
  for (size_t v = 0; v < views.size(); ++v) {
    const HoleView& view = views[v];
    const Camera& camera = cameras[observation.view[v]];
    cv::Mat near, hole(view.hole.height, view.hole.width, CV_8U, const_cast<uint8_t*>(view.hole.data.data()));
    cv::dilate(hole, near, cv::Mat::ones(2 * kSoftEdge + 1, 2 * kSoftEdge + 1, CV_8U));
    const ImageF& object = observation.object[v];
    cv::Mat cover, weight(object.height, object.width, CV_32F, const_cast<float*>(object.data.data()));
    cv::dilate(weight, cover, cv::Mat::ones(2 * kFarBeside + 1, 2 * kFarBeside + 1, CV_8U));
    for (size_t i = 0; i < points.size(); ++i) {
      const Eigen::Vector3d x = camera.cam_from_world * points[i].cast<double>();
      if (x.z() <= 0) continue;
      const double u = camera.fx * x.x() / x.z() + camera.cx, w = camera.fy * x.y() / x.z() + camera.cy;
      if (u < 0 || w < 0 || u >= camera.width || w >= camera.height) continue;
      const int px = static_cast<int>(u), py = static_cast<int>(w);
      const float alpha = view.picture.alpha(px, py);
      const double there = alpha > 0.5f ? view.picture.depth(px, py) / alpha : INFINITY;
      if (near.at<uint8_t>(py, px))
        seen[i] |= x.z() <= (1 + kSlack) * there ? 1 : 0;
      else if (std::isfinite(there) || object(px, py) < 0.5f)
        seen[i] |= x.z() <= (cover.at<float>(py, px) < kBeside ? depth_beside : 1 - kSlack) * there ? 2 : 0;
    }
  }
  return seen;
}

}  // namespace

GaussianCloud inside_holes(const GaussianCloud& patch, const std::vector<HoleView>& views,
                           const Observation& observation, const std::vector<Camera>& cameras) {
  const std::vector<uint8_t> seen = where_seen(patch.position, 1 + kSlack, views, observation, cameras);
  std::vector<int> kept;
  for (size_t i = 0; i < patch.size(); ++i)
    if (!(seen[i] & 2)) kept.push_back(static_cast<int>(i));
  return patch.select(kept);
}

std::vector<int> uncovered_guesses(const GaussianCloud& background, const Observation& observation,
                                   const std::vector<HoleView>& views, const std::vector<Camera>& cameras) {
  std::vector<int> guesses, out;
  std::vector<Vec3f> points;
  for (size_t p = 0; p < background.size(); ++p)
    if (observation.unobserved[p] > 0) {
      guesses.push_back(static_cast<int>(p));
      points.push_back(background.position[p]);
    }
  const std::vector<uint8_t> seen = where_seen(points, 1 - kSlack, views, observation, cameras);
  for (size_t i = 0; i < guesses.size(); ++i)
    if (seen[i] == 1) out.push_back(guesses[i]);
  return out;
}

}  // namespace pliant

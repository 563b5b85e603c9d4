#include "segmentation/repair/hole.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "gaussians/base/error.h"
#include "gaussians/render/blend_weights.h"

namespace pliant {
namespace {

/// Raises `total` [background] to the blend weight [pixels] that a camera's picture puts on each Gaussian; large
/// pictures are drawn small.
void add_camera(const GaussianCloud& scene, const Camera& camera, const RenderOptions& options,
                std::vector<double>& total) {
  constexpr double kLongestSide = 200;  // px
  const Camera small = camera.scaled(std::min(1.0, kLongestSide / std::max(camera.width, camera.height)));
  const double area = (1.0 * camera.width * camera.height) / (1.0 * small.width * small.height);
  const BlendWeights W = blend_weights(scene, small, options);
  std::vector<double> here(total.size(), 0.0);
  for (size_t e = 0; e < W.weight.size(); ++e)
    if (W.gaussian[e] < here.size()) here[W.gaussian[e]] += area * W.weight[e];
  for (size_t p = 0; p < here.size(); ++p) total[p] = std::max(total[p], here[p]);
}

}  // namespace

Observation observe(const HoleOptions& options, const GaussianCloud& background, const GaussianCloud& object,
                    const std::vector<Camera>& cameras, const std::vector<int>& views,
                    const RenderOptions& render_options) {
  GaussianCloud scene = background;
  scene.append(object);
  Observation observation;
  observation.view = views;
  std::vector<double> total(background.size(), 0.0);
  for (int camera : views) {
    const BlendWeights W = blend_weights(scene, cameras[camera], render_options);
    ImageF seen(W.width, W.height, 1), depth(W.width, W.height, 1);
    std::vector<float> z(object.size());
    for (size_t p = 0; p < z.size(); ++p)
      z[p] = static_cast<float>((cameras[camera].cam_from_world * object.position[p].cast<double>()).z());
    ImageU8 outside(W.width, W.height, 1);
    for (size_t pixel = 0; pixel < W.pixels(); ++pixel) {
      float alpha = 0;
      for (uint32_t e = W.row_start[pixel]; e < W.row_start[pixel + 1]; ++e) {
        alpha += W.weight[e];
        if (W.gaussian[e] < background.size()) {
          total[W.gaussian[e]] += W.weight[e];
        } else {
          seen.data[pixel] += W.weight[e];
          depth.data[pixel] += W.weight[e] * z[W.gaussian[e] - background.size()];
        }
      }
      outside.data[pixel] = alpha < 0.5f;
    }
    observation.object.push_back(std::move(seen));
    observation.depth.push_back(std::move(depth));
    observation.outside.push_back(std::move(outside));
    observation.ignored.push_back(ImageU8(W.width, W.height, 1));
  }
  for (int camera = 0; camera < static_cast<int>(cameras.size()); ++camera)
    if (std::find(views.begin(), views.end(), camera) == views.end())
      add_camera(scene, cameras[camera], render_options, total);
  observation.unobserved.resize(background.size());
  for (size_t p = 0; p < total.size(); ++p) observation.unobserved[p] = total[p] < options.min_observed ? 1.0f : 0.0f;
  return observation;
}

HoleView find_hole(const HoleOptions& options, const Observation& observation, size_t view,
                   const GaussianCloud& background, const std::vector<Camera>& cameras,
                   const RenderOptions& render_options) {
  std::vector<float> unobserved = observation.unobserved;
  CHECK(unobserved.size() <= background.size());
  unobserved.resize(background.size(), 0.0f);
  HoleView result;
  result.picture = render(background, cameras[observation.view[view]], render_options, unobserved, 1);
  const ImageF& object = observation.object[view];
  const ImageU8& outside = observation.outside[view];
  const int width = object.width, height = object.height;
  result.hole = result.open = ImageU8(width, height, 1);
  for (size_t i = 0; i < object.data.size(); ++i)
    result.hole.data[i] =
        !observation.ignored[view].data[i] && object.data[i] >= options.min_object &&
        (result.picture.alpha.data[i] < options.min_alpha || result.picture.features.data[i] > options.max_unobserved);

  // What is thinner than three pixels is the soft edge of a splat, not a hole.
  cv::Mat hole(height, width, CV_8U, result.hole.data.data()), part;
  cv::morphologyEx(hole, hole, cv::MORPH_OPEN, cv::Mat::ones(3, 3, CV_8U));
  // Parts of the hole that reach the void beside the object: there the nearest pixel beside the object decides.
  const int parts = cv::connectedComponents(hole, part, 8);
  std::vector<uint8_t> part_open(parts, 0);
  cv::Mat covered(height, width, CV_8U), distance, label;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      covered.at<uint8_t>(y, x) = object(x, y) >= options.min_object;
      if (!result.hole(x, y)) continue;
      for (int j = std::max(0, y - 1); j <= std::min(height - 1, y + 1); ++j)
        for (int i = std::max(0, x - 1); i <= std::min(width - 1, x + 1); ++i)
          if (outside(i, j)) part_open[part.at<int>(y, x)] = 1;
    }
  cv::distanceTransform(covered, distance, label, cv::DIST_L2, 5, cv::DIST_LABEL_PIXEL);
  std::vector<uint8_t> label_outside(static_cast<size_t>(width) * height + 1, 0);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      if (!covered.at<uint8_t>(y, x)) label_outside[label.at<int>(y, x)] = outside(x, y);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      if (result.hole(x, y) && part_open[part.at<int>(y, x)]) {
        result.open(x, y) = 1;
        if (label_outside[label.at<int>(y, x)]) result.hole(x, y) = result.open(x, y) = 0;
      }
  for (uint8_t h : result.hole.data) result.pixels += h;
  return result;
}

}  // namespace pliant

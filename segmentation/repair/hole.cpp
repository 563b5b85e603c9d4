#include "segmentation/repair/hole.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "gaussians/base/error.h"
#include "gaussians/render/blend_weights.h"
#include "segmentation/repair/chosen_views.h"

namespace pliant {
namespace {

/// How much of the background cameras saw while the object was there.
class Sight {
 public:
  Sight(const HoleOptions& options, const GaussianCloud& background, const RenderOptions& render_options)
      : options_(options),
        background_(background),
        render_options_(render_options),
        total_(background.size(), 0.0),
        largest_share_(background.size(), -1.0) {}

  /// A camera that is looked at; its blend weights with the object.
  void add_view(const BlendWeights& W, const Camera& camera) {
    const std::vector<double> here = by_gaussian(W);
    for (size_t p = 0; p < here.size(); ++p) total_[p] += here[p];
    add_shares(here, camera, 1);
  }
  /// Another camera.
  void add_camera(const GaussianCloud& scene, const Camera& camera) {
    const Camera small = scaled_down(camera, kSmallSide);
    const double area = (1.0 * camera.width * camera.height) / (1.0 * small.width * small.height);
    const std::vector<double> here = by_gaussian(blend_weights(scene, small, render_options_));
    for (size_t p = 0; p < here.size(); ++p) total_[p] = std::max(total_[p], area * here[p]);
    add_shares(here, small, area);
  }
  /// [background] 1 = never observed.
  std::vector<float> unobserved() const {
    std::vector<float> out(total_.size());
    for (size_t p = 0; p < out.size(); ++p)
      out[p] = total_[p] < options_.min_observed || (largest_share_[p] >= 0 && largest_share_[p] < options_.min_share);
    return out;
  }

 private:
  std::vector<double> by_gaussian(const BlendWeights& W) const {
    std::vector<double> here(background_.size(), 0.0);
    for (size_t e = 0; e < W.weight.size(); ++e)
      if (W.gaussian[e] < here.size()) here[W.gaussian[e]] += W.weight[e];
    return here;
  }
  void add_shares(const std::vector<double>& before, const Camera& camera, double area) {
    const std::vector<double> after = by_gaussian(blend_weights(background_, camera, render_options_));
    for (size_t p = 0; p < after.size(); ++p)
      if (area * after[p] >= options_.min_observed)
        largest_share_[p] = std::max(largest_share_[p], before[p] / after[p]);
  }

  const HoleOptions& options_;
  const GaussianCloud& background_;
  const RenderOptions& render_options_;
  std::vector<double> total_, largest_share_;  // pixels; of the weight without the object, -1 = shows nowhere
};

}  // namespace

Observation observe(const HoleOptions& options, const GaussianCloud& background, const GaussianCloud& object,
                    const std::vector<Camera>& cameras, const std::vector<int>& views,
                    const RenderOptions& render_options, const std::function<void()>& under_way) {
  GaussianCloud scene = background;
  scene.append(object);
  Observation observation;
  observation.view = views;
  Sight sight(options, background, render_options);
  for (int camera : views) {
    if (under_way) under_way();
    const BlendWeights W = blend_weights(scene, cameras[camera], render_options);
    sight.add_view(W, cameras[camera]);
    ImageF seen(W.width, W.height, 1), depth(W.width, W.height, 1);
    std::vector<float> z(object.size());
    for (size_t p = 0; p < z.size(); ++p)
      z[p] = static_cast<float>((cameras[camera].cam_from_world * object.position[p].cast<double>()).z());
    ImageU8 outside(W.width, W.height, 1);
    for (size_t pixel = 0; pixel < W.pixels(); ++pixel) {
      float alpha = 0;
      for (uint32_t e = W.row_start[pixel]; e < W.row_start[pixel + 1]; ++e) {
        alpha += W.weight[e];
        if (W.gaussian[e] >= background.size()) {
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
  for (int camera = 0; camera < static_cast<int>(cameras.size()); ++camera) {
    if (std::find(views.begin(), views.end(), camera) != views.end()) continue;
    if (under_way) under_way();
    sight.add_camera(scene, cameras[camera]);
  }
  observation.unobserved = sight.unobserved();
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

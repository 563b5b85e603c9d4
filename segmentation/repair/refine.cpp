#include "segmentation/repair/refine.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/imgproc.hpp>

#include "gaussians/base/adam.h"
#include "gaussians/render/blend_weights.h"
#include "gaussians/render/image_loss.h"

namespace pliant {
namespace {

/// The part of a view around its hole, with the Gaussians that matter there: fixed ones first, then all new ones.
struct Crop {
  PicturePart view;
  ImageF color, weight;  ///< weight 1 in the hole and its ring
  ImageF inside;         ///< 1 in the hole
  GaussianCloud cloud;
  size_t first_new = 0;
};

std::vector<size_t> largest(const std::vector<FilledView>& views, int most) {
  std::vector<size_t> area, order(views.size());
  for (const FilledView& view : views)
    area.push_back(static_cast<size_t>(std::count(view.mask.data.begin(), view.mask.data.end(), 1)));
  std::iota(order.begin(), order.end(), size_t(0));
  std::erase_if(order, [&](size_t v) { return area[v] == 0; });
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return area[a] > area[b]; });
  if (order.size() > static_cast<size_t>(most)) order.resize(most);
  return order;
}

Crop crop(const FilledView& view, int ring, size_t first_new, const GaussianCloud& cloud,
          const RenderOptions& render_options) {
  constexpr int kBorder = 4;
  const int width = view.mask.width, height = view.mask.height;
  cv::Mat mask(height, width, CV_8U, const_cast<uint8_t*>(view.mask.data.data())), grown;
  cv::dilate(mask, grown, cv::Mat::ones(2 * ring + 1, 2 * ring + 1, CV_8U));
  cv::Rect box = cv::boundingRect(grown);
  box = cv::Rect(box.x - kBorder, box.y - kBorder, box.width + 2 * kBorder, box.height + 2 * kBorder) &
        cv::Rect(0, 0, width, height);
  Crop part{cropped(view.camera, box.x, box.y, box.width, box.height),
            ImageF(box.width, box.height, 3),
            ImageF(box.width, box.height, 1),
            ImageF(box.width, box.height, 1),
            {},
            0};
  for (int y = 0; y < box.height; ++y)
    for (int x = 0; x < box.width; ++x) {
      std::copy_n(view.color.at(box.x + x, box.y + y), 3, part.color.at(x, y));
      part.inside(x, y) = view.mask(box.x + x, box.y + y);
      part.weight(x, y) = grown.at<uint8_t>(box.y + y, box.x + x);
    }
  const BlendWeights W = blend_weights(cloud, part.view.camera, render_options.within(part.view.frame));
  std::vector<uint8_t> used(cloud.size(), 0);
  for (const uint32_t p : W.gaussian) used[p] = 1;
  std::vector<int> kept;
  for (size_t p = 0; p < first_new; ++p)
    if (used[p]) kept.push_back(static_cast<int>(p));
  part.first_new = kept.size();
  for (size_t p = first_new; p < cloud.size(); ++p) kept.push_back(static_cast<int>(p));
  part.cloud = cloud.select(kept);
  return part;
}

/// The new Gaussians' parameters side by side.
struct Parameters {
  std::vector<float> color, opacity, scale;  ///< [n, 3], [n], [n, 3]
};

Parameters take(const CloudOf<float>& cloud, size_t first) {
  Parameters out;
  for (size_t p = first; p < cloud.size(); ++p) {
    out.color.insert(out.color.end(), cloud.sh_of(p), cloud.sh_of(p) + 3);
    out.opacity.push_back(cloud.opacity_logit[p]);
    out.scale.insert(out.scale.end(), cloud.log_scale[p].data(), cloud.log_scale[p].data() + 3);
  }
  return out;
}

void put(const Parameters& parameters, size_t first, GaussianCloud& cloud) {
  for (size_t p = first, i = 0; p < cloud.size(); ++p, ++i) {
    std::copy_n(parameters.color.data() + 3 * i, 3, cloud.sh_of(p));
    cloud.opacity_logit[p] = parameters.opacity[i];
    cloud.log_scale[p] = Vec3f(parameters.scale[3 * i], parameters.scale[3 * i + 1], parameters.scale[3 * i + 2]);
  }
}

double error_inside(const std::vector<Crop>& crops, const RenderOptions& render_options) {
  double sum = 0, pixels = 0;
  for (const Crop& part : crops) {
    const double n = std::accumulate(part.inside.data.begin(), part.inside.data.end(), 0.0);
    const RenderOptions options = render_options.within(part.view.frame);
    sum += n * mse_loss(render(part.cloud, part.view.camera, options).color, part.color, part.inside);
    pixels += n;
  }
  return sum / pixels;
}

}  // namespace

RefineSummary refine(const RefineOptions& options, const std::vector<FilledView>& views, size_t first_new,
                     GaussianCloud& cloud, const RenderOptions& render_options,
                     const std::function<void()>& under_way) {
  RefineSummary summary;
  std::vector<Crop> crops;
  if (options.rounds > 0 && first_new < cloud.size())
    for (const size_t v : largest(views, options.max_views))
      crops.push_back(crop(views[v], options.ring, first_new, cloud, render_options));
  summary.views = crops.size();
  if (crops.empty()) return summary;
  summary.mse_before = error_inside(crops, render_options);

  const Parameters start = take(cloud, first_new);
  Parameters now = start;
  Adam<float> color(now.color.size()), opacity(now.opacity.size()), scale(now.scale.size());
  for (int round = 0; round < options.rounds; ++round) {
    // Rates fall to a tenth, so that the last views do not pull alone.
    const float rate = std::pow(0.1f, static_cast<float>(round) / static_cast<float>(options.rounds));
    for (Crop& part : crops) {
      if (under_way) under_way();
      put(now, part.first_new, part.cloud);
      const RenderOptions of_part = render_options.within(part.view.frame);
      RenderTape<float> tape;
      const RenderResult picture = render(part.cloud, part.view.camera, of_part, {}, 0, &tape);
      RenderResult adj;
      mse_loss_adjoint(picture.color, part.color, part.weight, 1.0, adj.color);
      const RenderGradient<float> gradient =
          render_adjoint(part.cloud, part.view.camera, of_part, {}, 0, picture, adj, &tape);
      const Parameters g = take(gradient.cloud, part.first_new);
      color.step(now.color, g.color, rate * options.color_rate / kSh0);
      opacity.step(now.opacity, g.opacity, rate * options.opacity_rate);
      scale.step(now.scale, g.scale, rate * options.scale_rate);
      for (size_t i = 0; i < now.scale.size(); ++i)
        now.scale[i] =
            std::clamp(now.scale[i], start.scale[i] - options.most_scale, start.scale[i] + options.most_scale);
    }
  }
  for (Crop& part : crops) put(now, part.first_new, part.cloud);
  summary.mse_after = error_inside(crops, render_options);
  // A descent that did not get there changes nothing.
  summary.kept = summary.mse_after < summary.mse_before;
  if (summary.kept) put(now, first_new, cloud);
  return summary;
}

}  // namespace pliant

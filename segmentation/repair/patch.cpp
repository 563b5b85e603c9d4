#include "segmentation/repair/patch.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "segmentation/repair/shift_fill.h"

namespace pliant {
namespace {

float median(std::vector<float> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Opaque disc of spacing `size`, its short axis along `normal`.
void add_disc(GaussianCloud& cloud, const Vec3f& x, const Vec4f& rotation, float size, float thickness, float opacity,
              const float* color) {
  const size_t i = cloud.size();
  cloud.resize(i + 1);
  cloud.position[i] = x;
  cloud.rotation[i] = rotation;
  const float sigma = 0.65f * size;
  cloud.log_scale[i] = Vec3f(std::log(sigma), std::log(sigma), std::log(std::min(thickness, 0.5f * sigma)));
  cloud.opacity_logit[i] = logit(opacity);
  for (int k = 0; k < 3; ++k) cloud.sh_of(i)[k] = (std::clamp(color[k], 0.0f, 1.0f) - 0.5f) / kSh0;
}

/// Opacity and thickness for new discs from the Gaussians around them.
struct Neighbourhood {
  float opacity = 0.95f, thickness = 0;
};
Neighbourhood neighbourhood(const GaussianCloud& cloud, const std::vector<int>& members) {
  std::vector<float> opacity, thickness;
  for (int p : members) {
    opacity.push_back(sigmoid(cloud.opacity_logit[p]));
    thickness.push_back(std::exp(cloud.log_scale[p].minCoeff()));
  }
  return {std::clamp(median(opacity), 0.9f, 0.99f), median(thickness)};
}

}  // namespace

GaussianCloud plane_patch(const PlanePicture& picture, const GaussianCloud& background, const ExemplarOptions& options) {
  // Where the texture repeats it is carried over whole, else pieced together.
  const std::optional<ImageF> shifted = shift_fill({}, picture.color, picture.known, picture.target);
  const ImageF filled = shifted ? *shifted : exemplar_fill(options, picture.color, picture.known, picture.target);
  GaussianCloud patch;
  const Neighbourhood around = neighbourhood(background, picture.members);
  Eigen::Matrix3f frame;
  frame.col(0) = picture.u, frame.col(1) = picture.normal.cross(picture.u), frame.col(2) = picture.normal;
  const Vec4f rotation = quaternion_wxyz(frame);
  for (int y = 0; y < filled.height; ++y)
    for (int x = 0; x < filled.width; ++x)
      if (picture.target(x, y) && !picture.covered(x, y))
        add_disc(patch, picture.point(x + 0.5f, y + 0.5f), rotation, picture.texel, around.thickness, around.opacity, filled.at(x, y));
  return patch;
}

GaussianCloud view_patch(const HoleView& view, const Camera& camera, const ExemplarOptions& options) {
  const int width = view.hole.width, height = view.hole.height;
  // Colour: the picture itself is the source.
  const ImageU8 known = source_mask(view.picture, view.hole);
  const ImageF filled = exemplar_fill(options, divided_by_alpha(view.picture), known, view.hole);

  // Depth: the surroundings' inverse depths weighted by inverse squared distance in the picture.
  std::vector<std::pair<Vec2f, float>> ring;
  cv::Mat hole(height, width, CV_8U, const_cast<uint8_t*>(view.hole.data.data())), near;
  cv::dilate(hole, near, cv::Mat::ones(9, 9, CV_8U));
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      if (near.at<uint8_t>(y, x) && known(x, y))
        ring.push_back({Vec2f(x, y), view.picture.alpha(x, y) / view.picture.depth(x, y)});
  GaussianCloud patch;
  if (ring.empty()) return patch;
  const size_t step = std::max<size_t>(1, ring.size() / 800);
  const Vec3f forward = camera.forward().cast<float>();
  const Vec4f rotation = quaternion_wxyz(Eigen::Quaternionf::FromTwoVectors(Vec3f::UnitZ(), -forward).toRotationMatrix());
  const Eigen::Isometry3d world_from_cam = camera.cam_from_world.inverse();
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      if (!view.hole(x, y)) continue;
      // Weighted quantile on the far side: what an object hid is behind it, and a mean between two surfaces is neither.
      std::vector<std::pair<float, double>> candidates;  // inverse depth, weight
      double total = 0, below = 0;
      for (size_t i = 0; i < ring.size(); i += step) {
        const double d2 = (ring[i].first - Vec2f(x, y)).squaredNorm();
        candidates.emplace_back(ring[i].second, 1 / (d2 * d2)), total += 1 / (d2 * d2);
      }
      std::sort(candidates.begin(), candidates.end());
      size_t pick = 0;
      while (pick + 1 < candidates.size() && (below += candidates[pick].second) < 0.35 * total) ++pick;
      double z = 1 / candidates[pick].first;
      if (view.picture.features(x, y) > 0.5f * view.picture.alpha(x, y) && view.picture.alpha(x, y) > 0.1f)
        z = std::min(z, 0.98 * view.picture.depth(x, y) / view.picture.alpha(x, y));
      const Vec3d at((x + 0.5 - camera.cx) / camera.fx * z, (y + 0.5 - camera.cy) / camera.fy * z, z);
      const float size = static_cast<float>(z / camera.fx);
      add_disc(patch, (world_from_cam * at).cast<float>(), rotation, size, 0.2f * size, 0.95f, filled.at(x, y));
    }
  return patch;
}

}  // namespace pliant

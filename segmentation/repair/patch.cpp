#include "segmentation/repair/patch.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "gaussians/base/error.h"
#include "gaussians/base/linear_algebra.h"
#include "gaussians/base/quantile.h"
#include "segmentation/repair/shift_fill.h"

namespace pliant {
namespace {

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
  for (int k = 0; k < 3; ++k) cloud.sh_of(i)[k] = sh_of_color(std::clamp(color[k], 0.0f, 1.0f));
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
  return {std::clamp(quantile(opacity, 0.5), 0.9f, 0.99f), quantile(thickness, 0.5)};
}

/// Colour at image point (u, v), whose pixel (i, j) has its centre at (i + 0.5, j + 0.5).
void bilinear(const ImageF& image, float u, float v, float* out) {
  const float x = std::clamp(u - 0.5f, 0.0f, static_cast<float>(image.width - 1)),
              y = std::clamp(v - 0.5f, 0.0f, static_cast<float>(image.height - 1));
  const int i = std::min(static_cast<int>(x), std::max(0, image.width - 2)),
            j = std::min(static_cast<int>(y), std::max(0, image.height - 2));
  const int i1 = std::min(i + 1, image.width - 1), j1 = std::min(j + 1, image.height - 1);
  const float a = x - static_cast<float>(i), b = y - static_cast<float>(j);
  for (int k = 0; k < 3; ++k)
    out[k] = (1 - b) * ((1 - a) * image(i, j, k) + a * image(i1, j, k)) +
             b * ((1 - a) * image(i, j1, k) + a * image(i1, j1, k));
}

}  // namespace

PlaneFill::PlaneFill(PlanePicture of)
    : picture(std::move(of)), color(picture.color), colored(picture.target.width, picture.target.height, 1) {}

void fill_from_texture(PlaneFill& plane, const ExemplarOptions& options) {
  const PlanePicture& p = plane.picture;
  if (const std::optional<ShiftFill> shifted = shift_fill({}, p.color, p.known, p.target)) {
    ImageU8 known = p.known;
    for (size_t i = 0; i < known.data.size(); ++i) known.data[i] |= p.target.data[i] && !shifted->left.data[i];
    plane.color = exemplar_fill(options, shifted->picture, known, shifted->left);
  } else {
    plane.color = exemplar_fill(options, p.color, p.known, p.target);
  }
  plane.colored = p.target;
}

ImageU8 fill_from_view(PlaneFill& plane, int index, const ViewFill& view, const HoleGeometry& geometry,
                       const Camera& camera) {
  ImageU8 here(view.mask.width, view.mask.height, 1), now(plane.colored.width, plane.colored.height, 1);
  for (size_t i = 0; i < here.data.size(); ++i) here.data[i] = geometry.plane[i] == index;
  cv::Mat wide(here.height, here.width, CV_8U, here.data.data());
  cv::dilate(wide, wide, cv::Mat::ones(3, 3, CV_8U));
  for (int y = 0; y < now.height; ++y)
    for (int x = 0; x < now.width; ++x) {
      if (!plane.picture.target(x, y) || plane.colored(x, y)) continue;
      const Vec3d at = camera.cam_from_world * plane.picture.point(x + 0.5f, y + 0.5f).cast<double>();
      if (at.z() <= 0.2) continue;
      const double u = camera.fx * at.x() / at.z() + camera.cx, v = camera.fy * at.y() / at.z() + camera.cy;
      if (u < 0 || v < 0 || u >= camera.width || v >= camera.height) continue;
      const int px = static_cast<int>(u), py = static_cast<int>(v);
      if (!here(px, py) || !view.mask(px, py)) continue;
      bilinear(view.color, static_cast<float>(u), static_cast<float>(v), plane.color.at(x, y));
      plane.colored(x, y) = now(x, y) = 1;
    }
  return now;
}

GaussianCloud plane_patch(const PlaneFill& plane, const ImageU8& which, const GaussianCloud& background) {
  const PlanePicture& picture = plane.picture;
  GaussianCloud patch;
  const Neighbourhood around = neighbourhood(background, picture.members);
  Eigen::Matrix3f frame;
  frame.col(0) = picture.u;
  frame.col(1) = picture.normal.cross(picture.u);
  frame.col(2) = picture.normal;
  const Vec4f rotation = quaternion_wxyz(frame);
  for (int y = 0; y < which.height; ++y)
    for (int x = 0; x < which.width; ++x)
      if (which(x, y) && !picture.covered(x, y))
        add_disc(patch, picture.point(x + 0.5f, y + 0.5f), rotation, picture.texel, around.thickness, around.opacity,
                 plane.color.at(x, y));
  return patch;
}

ViewFill fill_view(const HoleView& view, const ExemplarOptions& options, Inpainter* inpainter) {
  ViewFill fill{surface_color(view.picture), view.hole};
  if (!inpainter) {
    fill.color = exemplar_fill(options, fill.color, source_mask(view.picture, view.hole), view.hole);
    return fill;
  }
  // The hole's rim shows the black behind it.
  cv::Mat mask(fill.mask.height, fill.mask.width, CV_8U, fill.mask.data.data());
  cv::dilate(mask, mask, cv::Mat::ones(3, 3, CV_8U));
  for (float& value : fill.color.data) value = std::clamp(value, 0.0f, 1.0f);
  ImageF filled = inpainter->inpaint(fill.color, fill.mask);
  CHECK(filled.width == fill.color.width && filled.height == fill.color.height && filled.channels == 3);
  fill.color = std::move(filled);
  return fill;
}

GaussianCloud view_patch(const HoleView& view, const Camera& camera, const ImageF& filled, const ImageU8& which) {
  const int width = view.hole.width, height = view.hole.height;
  const ImageU8 known = source_mask(view.picture, view.hole);

  // Depth: the surroundings' inverse depths weighted by inverse squared distance in the picture.  Transparent lines
  // have none.
  std::vector<std::pair<Vec2f, float>> ring;
  cv::Mat hole(height, width, CV_8U, const_cast<uint8_t*>(view.hole.data.data())), near;
  cv::dilate(hole, near, cv::Mat::ones(9, 9, CV_8U));
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      if (near.at<uint8_t>(y, x) && known(x, y) && view.picture.alpha(x, y) > 0.5f)
        ring.push_back({Vec2f(x, y), view.picture.alpha(x, y) / view.picture.depth(x, y)});
  GaussianCloud patch;
  if (ring.empty()) return patch;
  const size_t step = std::max<size_t>(1, ring.size() / 800);
  const Vec3f forward = camera.forward().cast<float>();
  const Vec4f rotation = quaternion_wxyz(shortest_rotation<float>(Vec3f::UnitZ(), -forward));
  const Eigen::Isometry3d world_from_cam = camera.cam_from_world.inverse();
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      if (!which(x, y)) continue;
      // Weighted quantile on the far side: what an object hid is behind it, and a mean between two surfaces is neither.
      std::vector<std::pair<float, double>> candidates;  // inverse depth, weight
      double total = 0, below = 0;
      for (size_t i = 0; i < ring.size(); i += step) {
        const double d2 = (ring[i].first - Vec2f(x, y)).squaredNorm();
        candidates.emplace_back(ring[i].second, 1 / (d2 * d2));
        total += 1 / (d2 * d2);
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

FilledView show_planes(const std::vector<PlaneFill>& planes, const ImageF& picture, const ImageU8& hole,
                       const HoleGeometry& geometry, const Camera& camera) {
  FilledView out{camera, picture, ImageU8(hole.width, hole.height, 1)};
  for (size_t i = 0; i < geometry.plane.size(); ++i) {
    const int k = geometry.plane[i];
    if (k < 0 || !hole.data[i] || planes[k].picture.empty()) continue;
    const PlaneFill& plane = planes[k];
    const Vec2f at = plane.picture.coordinates(geometry.point[i]);
    const int x = static_cast<int>(std::floor(at[0])), y = static_cast<int>(std::floor(at[1]));
    if (x < 0 || y < 0 || x >= plane.colored.width || y >= plane.colored.height) continue;
    if (!plane.colored(x, y) && !plane.picture.covered(x, y)) continue;
    bilinear(plane.color, at[0], at[1], out.color.data.data() + 3 * i);
    out.mask.data[i] = 1;
  }
  return out;
}

}  // namespace pliant

#include "segmentation/repair/patch.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "gaussians/render/spherical_harmonics.h"

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

/// A copy without view dependence: the colour towards `eye`.
GaussianCloud flat_colored(const GaussianCloud& cloud, const std::vector<int>& members, const Vec3f& eye) {
  GaussianCloud out = cloud.select(members);
  std::vector<float> dc(out.size() * 3);
  for (size_t i = 0; i < out.size(); ++i) {
    const Vec3f color = sh_color<float>(out.sh_degree, out.sh_of(i), (out.position[i] - eye).normalized());
    for (int k = 0; k < 3; ++k) dc[3 * i + k] = (color[k] - 0.5f) / kSh0;
  }
  out.sh = std::move(dc), out.sh_degree = 0;
  return out;
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

ImageF divided_by_alpha(const RenderResult& picture) {
  ImageF color = picture.color;
  for (size_t i = 0; i < color.pixels(); ++i)
    for (int k = 0; k < 3; ++k) color.data[3 * i + k] /= std::max(picture.alpha.data[i], 0.1f);
  return color;
}

/// What may be copied: opaque enough for its colour to be known, and not at the fading rim of the hole.
ImageU8 source_mask(const RenderResult& picture, const ImageU8& target) {
  const int width = target.width, height = target.height;
  ImageU8 known(width, height, 1);
  for (size_t i = 0; i < known.data.size(); ++i) known.data[i] = picture.alpha.data[i] > 0.8f;
  cv::Mat mask(height, width, CV_8U, known.data.data()), rim;
  cv::dilate(cv::Mat(height, width, CV_8U, const_cast<uint8_t*>(target.data.data())), rim, cv::Mat::ones(3, 3, CV_8U));
  mask.setTo(0, rim);
  return known;
}

}  // namespace

GaussianCloud plane_patch(const Surfaces& surfaces, int index, const std::vector<HoleView>& views,
                          const std::vector<HoleGeometry>& geometry, const Observation& observation,
                          const GaussianCloud& background, const std::vector<Camera>& cameras,
                          const ExemplarOptions& options) {
  const Plane& plane = surfaces.plane[index].plane;
  // Axes of the plane: u to the right, v down as the view with most of the hole sees it.
  size_t widest = 0, most = 0;
  std::vector<float> footprint;
  std::vector<Vec3f> points;
  for (size_t v = 0; v < views.size(); ++v) {
    const Camera& camera = cameras[observation.view[v]];
    size_t here = 0;
    for (size_t i = 0; i < geometry[v].plane.size(); ++i) {
      if (geometry[v].plane[i] != index) continue;
      ++here;
      points.push_back(geometry[v].point[i]);
      const Vec3d in_camera = camera.cam_from_world * geometry[v].point[i].cast<double>();
      footprint.push_back(static_cast<float>(in_camera.z() / camera.fx));
    }
    if (here > most) most = here, widest = v;
  }
  if (points.size() < 4) return {};
  const Camera& front = cameras[observation.view[widest]];
  const Vec3f right = front.cam_from_world.linear().row(0).transpose().cast<float>();
  Vec3f u = right - plane.normal * plane.normal.dot(right);
  if (u.norm() < 1e-3f) u = plane.normal.unitOrthogonal();
  u.normalize();
  const Vec3f v_axis = (-plane.normal).cross(u);  // u, v, forward = -normal is a camera frame

  // Texels of about one pixel; the picture spans the hole, outliers of grazing rays left out, and its surroundings.
  auto coordinates = [&](const Vec3f& x) { return Vec2f(u.dot(x - plane.point), v_axis.dot(x - plane.point)); };
  std::vector<float> us, vs;
  for (const Vec3f& x : points) us.push_back(coordinates(x)[0]), vs.push_back(coordinates(x)[1]);
  auto range = [](std::vector<float>& values) {
    std::sort(values.begin(), values.end());
    const size_t cut = values.size() / 500;
    return Vec2f(values[cut], values[values.size() - 1 - cut]);
  };
  const Vec2f ru = range(us), rv = range(vs);
  float texel = 0.9f * median(footprint);
  const float span = std::max(ru[1] - ru[0], rv[1] - rv[0]);
  constexpr int kLargest = 320;  // texels across hole and surroundings
  const float margin = std::max(1.2f * span, 40 * texel);
  texel = std::max(texel, (span + 2 * margin) / kLargest);
  const Vec2f low(ru[0] - margin, rv[0] - margin);
  const int width = static_cast<int>((ru[1] - ru[0] + 2 * margin) / texel) + 1;
  const int height = static_cast<int>((rv[1] - rv[0] + 2 * margin) / texel) + 1;
  auto on_plane = [&](int x, int y) -> Vec3f {
    return plane.point + u * (low[0] + (x + 0.5f) * texel) + v_axis * (low[1] + (y + 0.5f) * texel);
  };

  // The plane's own Gaussians, pictured from the front and from far away.  Those that nobody observed say nothing; the
  // discs go a texel in front of them.
  std::vector<int> members;
  float lift = 0;
  for (size_t p = 0; p < background.size(); ++p) {
    const Vec2f at = coordinates(background.position[p]) - low;
    if (std::abs(plane.normal.dot(background.position[p] - plane.point)) <= 2 * surfaces.tolerance &&
        at.minCoeff() > -20 * texel && at[0] < (width + 20) * texel && at[1] < (height + 20) * texel) {
      if (p < observation.unobserved.size() && observation.unobserved[p] > 0) lift = texel;
      else members.push_back(static_cast<int>(p));
    }
  }
  if (members.empty()) return {};
  Camera camera;
  camera.width = width, camera.height = height;
  const double distance = 30.0 * texel * std::max(width, height);
  camera.fx = camera.fy = distance / texel;
  camera.cx = 0.5 * width, camera.cy = 0.5 * height;
  const Vec3f centre = plane.point + u * (low[0] + 0.5f * width * texel) + v_axis * (low[1] + 0.5f * height * texel);
  Eigen::Matrix3d axes;
  axes.row(0) = u.cast<double>(), axes.row(1) = v_axis.cast<double>(), axes.row(2) = -plane.normal.cast<double>();
  const Vec3d eye = (centre + plane.normal * static_cast<float>(distance)).cast<double>();
  camera.cam_from_world.linear() = axes;
  camera.cam_from_world.translation() = -axes * eye;
  const RenderResult picture = render(flat_colored(background, members, front.centre().cast<float>()), camera);

  // Texels that a view sees through its hole.
  ImageU8 target(width, height, 1);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      if (picture.alpha(x, y) > 0.97f || !surfaces.plane[index].holds(on_plane(x, y))) continue;
      const Vec3d world = on_plane(x, y).cast<double>();
      for (size_t v = 0; v < views.size() && !target(x, y); ++v) {
        const Camera& c = cameras[observation.view[v]];
        const Vec3d at = c.cam_from_world * world;
        if (at.z() <= 0.2) continue;
        const int px = static_cast<int>(std::floor(c.fx * at.x() / at.z() + c.cx));
        const int py = static_cast<int>(std::floor(c.fy * at.y() / at.z() + c.cy));
        if (px < 0 || py < 0 || px >= c.width || py >= c.height) continue;
        target(x, y) = geometry[v].plane[static_cast<size_t>(py) * c.width + px] == index;
      }
    }
  cv::Mat mask(height, width, CV_8U, target.data.data());
  cv::morphologyEx(mask, mask, cv::MORPH_CLOSE, cv::Mat::ones(3, 3, CV_8U));
  cv::dilate(mask, mask, cv::Mat::ones(3, 3, CV_8U));
  const ImageF filled = exemplar_fill(options, divided_by_alpha(picture), source_mask(picture, target), target);

  GaussianCloud patch;
  const Neighbourhood around = neighbourhood(background, members);
  Eigen::Matrix3f frame;
  frame.col(0) = u, frame.col(1) = (plane.normal).cross(u), frame.col(2) = plane.normal;
  const Vec4f rotation = quaternion_wxyz(frame);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      if (target(x, y) && picture.alpha(x, y) <= 0.97f)
        add_disc(patch, on_plane(x, y) + lift * plane.normal, rotation, texel, around.thickness, around.opacity, filled.at(x, y));
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

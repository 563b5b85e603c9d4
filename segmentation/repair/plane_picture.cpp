#include "segmentation/repair/plane_picture.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "gaussians/base/quantile.h"
#include "gaussians/render/spherical_harmonics.h"

namespace pliant {
namespace {

constexpr int kLine = 5;  // px, wider than lines between parts of a surface

/// A copy without view dependence: the colour towards `eye`.
GaussianCloud flat_colored(const GaussianCloud& cloud, const std::vector<int>& members, const Vec3f& eye) {
  GaussianCloud out = cloud.select(members);
  std::vector<float> dc(out.size() * 3);
  for (size_t i = 0; i < out.size(); ++i) {
    const Vec3f color = sh_color<float>(out.sh_degree, out.sh_of(i), (out.position[i] - eye).normalized());
    for (int k = 0; k < 3; ++k) dc[3 * i + k] = sh_of_color(color[k]);
  }
  out.sh = std::move(dc);
  out.sh_degree = 0;
  return out;
}

/// Points of a plane that views see through their holes, without thin lines.
struct Opening {
  std::vector<Vec3f> point;
  float footprint = 0;  ///< median size of a pixel there (scene units)
  size_t widest = 0;    ///< the view with most of them
};
Opening find_opening(int plane, const std::vector<HoleView>& views, const std::vector<HoleGeometry>& geometry,
                     const Observation& observation, const std::vector<Camera>& cameras) {
  Opening opening;
  std::vector<float> footprint;
  size_t most = 0;
  for (size_t v = 0; v < views.size(); ++v) {
    const Camera& camera = cameras[observation.view[v]];
    cv::Mat wide(camera.height, camera.width, CV_8U, const_cast<uint8_t*>(views[v].hole.data.data())), kept;
    cv::morphologyEx(wide, kept, cv::MORPH_OPEN, cv::Mat::ones(kLine, kLine, CV_8U));
    cv::dilate(kept, kept, cv::Mat::ones(kLine, kLine, CV_8U));
    size_t here = 0;
    for (size_t i = 0; i < geometry[v].plane.size(); ++i) {
      if (geometry[v].plane[i] != plane || !kept.data[i]) continue;
      ++here;
      opening.point.push_back(geometry[v].point[i]);
      const Vec3d in_camera = camera.cam_from_world * geometry[v].point[i].cast<double>();
      footprint.push_back(static_cast<float>(in_camera.z() / camera.fx));
    }
    if (here > most) {
      most = here;
      opening.widest = v;
    }
  }
  if (!footprint.empty()) opening.footprint = quantile(footprint, 0.5);
  return opening;
}

/// Range of values without their outliers, which grazing rays make.
Vec2f inner_range(std::vector<float> values) {
  std::sort(values.begin(), values.end());
  const size_t cut = values.size() / 500;
  return {values[cut], values[values.size() - 1 - cut]};
}

/// Camera far in front of the picture, whose pixels are its texels.
Camera front_camera(const PlanePicture& picture, int width, int height) {
  Camera camera;
  camera.width = width;
  camera.height = height;
  const double distance = 30.0 * picture.texel * std::max(width, height);
  camera.fx = camera.fy = distance / picture.texel;
  camera.cx = 0.5 * width;
  camera.cy = 0.5 * height;
  Eigen::Matrix3d axes;
  axes.row(0) = picture.u.cast<double>();
  axes.row(1) = picture.v.cast<double>();
  axes.row(2) = -picture.normal.cast<double>();
  const Vec3d eye =
      (picture.point(0.5f * width, 0.5f * height) + picture.normal * static_cast<float>(distance)).cast<double>();
  camera.cam_from_world.linear() = axes;
  camera.cam_from_world.translation() = -axes * eye;
  return camera;
}

/// Whether some view sees a point of the plane through its hole.
bool seen_through_hole(int plane, const Vec3d& x, const std::vector<HoleGeometry>& geometry,
                       const Observation& observation, const std::vector<Camera>& cameras) {
  for (size_t v = 0; v < geometry.size(); ++v) {
    const Camera& c = cameras[observation.view[v]];
    const Vec3d at = c.cam_from_world * x;
    if (at.z() <= 0.2) continue;
    const int px = static_cast<int>(std::floor(c.fx * at.x() / at.z() + c.cx));
    const int py = static_cast<int>(std::floor(c.fy * at.y() / at.z() + c.cy));
    if (px < 0 || py < 0 || px >= c.width || py >= c.height) continue;
    if (geometry[v].plane[static_cast<size_t>(py) * c.width + px] == plane) return true;
  }
  return false;
}

/// Opacity of surfaces: thin dark lines, which training leaves transparent before the black, are as opaque as what is
/// beside them.
cv::Mat surface_opacity(const RenderResult& picture) {
  cv::Mat closed;
  const cv::Mat alpha(picture.alpha.height, picture.alpha.width, CV_32F, const_cast<float*>(picture.alpha.data.data()));
  cv::morphologyEx(alpha, closed, cv::MORPH_CLOSE, cv::Mat::ones(kLine, kLine, CV_8U));
  return closed;
}

}  // namespace

ImageF surface_color(const RenderResult& picture) {
  const cv::Mat opacity = surface_opacity(picture);
  ImageF color = picture.color;
  for (int y = 0; y < color.height; ++y)
    for (int x = 0; x < color.width; ++x)
      for (int k = 0; k < 3; ++k) color(x, y, k) /= std::max(opacity.at<float>(y, x), 0.1f);
  return color;
}

ImageU8 source_mask(const RenderResult& picture, const ImageU8& target) {
  constexpr float kOpaque = 0.8f;
  const int width = target.width, height = target.height;
  ImageU8 known(width, height, 1);
  const cv::Mat opaque = surface_opacity(picture) > kOpaque;
  cv::Mat rim;
  cv::dilate(cv::Mat(height, width, CV_8U, const_cast<uint8_t*>(target.data.data())), rim, cv::Mat::ones(3, 3, CV_8U));
  for (size_t i = 0; i < known.data.size(); ++i) known.data[i] = opaque.data[i] && !rim.data[i];
  return known;
}

PlanePicture picture_plane(const PlanePictureOptions& options, const Surfaces& surfaces, int index,
                           const std::vector<HoleView>& views, const std::vector<HoleGeometry>& geometry,
                           const Observation& observation, const GaussianCloud& background,
                           const std::vector<Camera>& cameras, const RenderOptions& render_options) {
  constexpr float kOpaque = 0.97f;
  const Opening opening = find_opening(index, views, geometry, observation, cameras);
  if (opening.point.size() < 4) return {};
  // Axes as the view with most of the hole sees the plane.
  PlanePicture picture;
  const Plane& plane = surfaces.plane[index].plane;
  const Camera& front = cameras[observation.view[opening.widest]];
  const Vec3f right = front.cam_from_world.linear().row(0).transpose().cast<float>();
  Vec3f u = right - plane.normal * plane.normal.dot(right);
  if (u.norm() < 1e-3f) u = plane.normal.unitOrthogonal();
  picture.normal = plane.normal;
  picture.u = u.normalized();
  picture.v = (-plane.normal).cross(picture.u);

  // The picture spans the hole and its surroundings.
  std::vector<float> us, vs;
  for (const Vec3f& x : opening.point) {
    us.push_back(picture.u.dot(x - plane.point));
    vs.push_back(picture.v.dot(x - plane.point));
  }
  const Vec2f ru = inner_range(std::move(us)), rv = inner_range(std::move(vs));
  const float span = std::max(ru[1] - ru[0], rv[1] - rv[0]);
  float texel = 0.9f * opening.footprint;
  const float margin = std::max(options.margin * span, 40 * texel);
  picture.texel = texel = std::max(texel, (span + 2 * margin) / static_cast<float>(options.most_texels));
  picture.corner = plane.point + picture.u * (ru[0] - margin) + picture.v * (rv[0] - margin);
  const int width = static_cast<int>((ru[1] - ru[0] + 2 * margin) / texel) + 1;
  const int height = static_cast<int>((rv[1] - rv[0] + 2 * margin) / texel) + 1;

  // The plane's own Gaussians.  Those that nobody observed say nothing.
  for (size_t p = 0; p < background.size(); ++p) {
    const Vec2f at = picture.coordinates(background.position[p]);
    if (std::abs(plane.normal.dot(background.position[p] - plane.point)) <= 2 * surfaces.tolerance &&
        at.minCoeff() > -20 && at[0] < static_cast<float>(width + 20) && at[1] < static_cast<float>(height + 20) &&
        !(p < observation.unobserved.size() && observation.unobserved[p] > 0))
      picture.members.push_back(static_cast<int>(p));
  }
  if (picture.members.empty()) return {};
  const RenderResult seen = render(flat_colored(background, picture.members, front.centre().cast<float>()),
                                   front_camera(picture, width, height), render_options);

  // Texels that a view sees through its hole.
  picture.covered = picture.target = ImageU8(width, height, 1);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      picture.covered(x, y) = seen.alpha(x, y) > kOpaque;
      const Vec3f at = picture.point(x + 0.5f, y + 0.5f);
      picture.target(x, y) = !picture.covered(x, y) && surfaces.plane[index].holds(at) &&
                             seen_through_hole(index, at.cast<double>(), geometry, observation, cameras);
    }
  cv::Mat mask(height, width, CV_8U, picture.target.data.data());
  cv::morphologyEx(mask, mask, cv::MORPH_CLOSE, cv::Mat::ones(3, 3, CV_8U));
  cv::dilate(mask, mask, cv::Mat::ones(3, 3, CV_8U));
  picture.color = surface_color(seen);
  picture.known = source_mask(seen, picture.target);
  return picture;
}

}  // namespace pliant

#include "gaussians/reconstruct/undistort.h"

#include <algorithm>
#include <cmath>

#include "gaussians/base/error.h"
#include "gaussians/base/lens.h"

namespace pliant {
namespace {

constexpr double kSmallestShare = 0.1;  // of the photo's width and height that the rectangle must keep

/// Rectangle of the plane z = 1 whose points all lie between the centres of the photo's border pixels.
struct Rectangle {
  double left = -INFINITY, right = INFINITY, top = -INFINITY, bottom = INFINITY;
};

Rectangle inner_rectangle(const Camera& camera) {
  Rectangle r;
  for (int j = 0; j < camera.height; ++j) {
    if (const auto x = unproject(camera, {0.5, j + 0.5})) r.left = std::max(r.left, x->x());
    if (const auto x = unproject(camera, {camera.width - 0.5, j + 0.5})) r.right = std::min(r.right, x->x());
  }
  for (int i = 0; i < camera.width; ++i) {
    if (const auto x = unproject(camera, {i + 0.5, 0.5})) r.top = std::max(r.top, x->y());
    if (const auto x = unproject(camera, {i + 0.5, camera.height - 0.5})) r.bottom = std::min(r.bottom, x->y());
  }
  return r;
}

/// Weights of the four neighbours of a point that lies `t` behind the second one (Catmull and Rom 1974).
Vec4f catmull_rom(float t) {
  return 0.5f * Vec4f(t * (-1 + t * (2 - t)), 2 + t * t * (-5 + 3 * t), t * (1 + t * (4 - 3 * t)), t * t * (t - 1));
}

/// `round` makes a value of the picture from a sum.
template <class T, class Round>
Image<T> interpolated(const Undistortion& lens, const Image<T>& photo, Round&& round) {
  const int channels = photo.channels;
  Image<T> out(lens.pinhole.width, lens.pinhole.height, channels);
  std::vector<float> sum(channels);
  for (size_t i = 0; i < lens.seen.size(); ++i) {
    const Vec2f at = lens.seen[i] - Vec2f::Constant(0.5f);
    if (!at.allFinite()) continue;
    const Vec2f corner = at.array().floor();
    const Vec4f across = catmull_rom(at.x() - corner.x()), down = catmull_rom(at.y() - corner.y());
    std::fill(sum.begin(), sum.end(), 0.0f);
    for (int dy = 0; dy < 4; ++dy) {
      const int y = std::clamp(static_cast<int>(corner.y()) - 1 + dy, 0, photo.height - 1);
      for (int dx = 0; dx < 4; ++dx) {
        const T* pixel = photo.at(std::clamp(static_cast<int>(corner.x()) - 1 + dx, 0, photo.width - 1), y);
        for (int c = 0; c < channels; ++c) sum[c] += across[dx] * down[dy] * pixel[c];
      }
    }
    for (int c = 0; c < channels; ++c) out.data[channels * i + c] = round(sum[c]);
  }
  return out;
}

}  // namespace

Undistortion make_undistortion(const Camera& camera) {
  const Rectangle r = inner_rectangle(camera);
  const double across = (r.right - r.left) * camera.fx, down = (r.bottom - r.top) * camera.fy;
  if (!(across > kSmallestShare * camera.width && down > kSmallestShare * camera.height) ||
      !std::isfinite(across + down)) {
    throw input_error(camera.photo.empty() ? camera.name : camera.photo, "distortion",
                      "is so strong that no undistorted image is left", "check k1, k2, p1, p2, k3, k4");
  }
  const double shrink = std::min({1.0, (camera.width - 1) / across, (camera.height - 1) / down});
  Camera pinhole = camera;
  pinhole.distortion = {};
  pinhole.fx *= shrink;
  pinhole.fy *= shrink;
  // The centre of the first pixel lies on the corner of the rectangle, that of the last one inside it.
  pinhole.cx = 0.5 - r.left * pinhole.fx;
  pinhole.cy = 0.5 - r.top * pinhole.fy;
  pinhole.width = static_cast<int>(across * shrink + 1e-6) + 1;
  pinhole.height = static_cast<int>(down * shrink + 1e-6) + 1;
  return undistortion_onto(pinhole, camera);
}

Undistortion undistortion_onto(const Camera& pinhole, const Camera& camera) {
  Undistortion result;
  result.pinhole = pinhole;
  result.seen.reserve(static_cast<size_t>(pinhole.width) * pinhole.height);
  for (int j = 0; j < pinhole.height; ++j) {
    for (int i = 0; i < pinhole.width; ++i) {
      const Eigen::Vector2d x((i + 0.5 - pinhole.cx) / pinhole.fx, (j + 0.5 - pinhole.cy) / pinhole.fy);
      Eigen::Matrix2d derivative;
      const Eigen::Vector2d bent = distort(camera.distortion, x, &derivative);
      const double u = bent.x() * camera.fx + camera.cx, v = bent.y() * camera.fy + camera.cy;
      const bool inside = derivative.determinant() > 0 && u > 0 && v > 0 && u < camera.width && v < camera.height;
      result.all_inside = result.all_inside && inside;
      result.seen.push_back(inside ? Vec2f(static_cast<float>(u), static_cast<float>(v)) : Vec2f::Constant(NAN));
    }
  }
  return result;
}

ImageU8 undistorted(const Undistortion& lens, const ImageU8& photo) {
  return interpolated(lens, photo,
                      [](float sum) { return static_cast<uint8_t>(std::clamp(sum, 0.0f, 255.0f) + 0.5f); });
}

ImageF undistorted(const Undistortion& lens, const ImageF& photo) {
  return interpolated(lens, photo, [](float sum) { return std::clamp(sum, 0.0f, 1.0f); });
}

}  // namespace pliant

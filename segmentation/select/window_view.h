#pragma once

#include <functional>
#include <vector>

#include "gaussians/base/camera.h"
#include "gaussians/base/gaussian_cloud.h"
#include "gaussians/render/render.h"
#include "segmentation/select/gesture_prompts.h"

namespace pliant {

/// A rectangle of a picture (px); it may reach beyond the picture.
struct PictureRect {
  double x0 = INFINITY, y0 = INFINITY, x1 = -INFINITY, y1 = -INFINITY;

  bool empty() const { return !(x0 < x1 && y0 < y1); }
  void add(double x, double y) {
    x0 = std::min(x0, x);
    x1 = std::max(x1, x);
    y0 = std::min(y0, y);
    y1 = std::max(y1, y);
  }
  PictureRect grown(double share) const {
    const double dx = share * (x1 - x0), dy = share * (y1 - y0);
    return {x0 - dx, y0 - dy, x1 + dx, y1 + dy};
  }
};

/// A part of a camera's picture at a resolution of its own: selection looks at objects at the same size in pixels
/// whatever share of the pictures they fill.
struct WindowView {
  int source = -1;                   ///< camera of the scene
  Camera camera;                     ///< of the window
  PictureFrame frame;                ///< the whole picture, in px of the window
  double x0 = 0, y0 = 0, scale = 1;  ///< window px = (picture px - (x0, y0)) * scale

  /// Longer side of the window: `longest` px.
  WindowView(const std::vector<Camera>& cameras, int source, const PictureRect& rect, int longest);
  Vec2f to_window(double x, double y) const { return Vec2f((x - x0) * scale, (y - y0) * scale); }
};

/// Where the centre of a Gaussian lies in a camera's picture; false behind the near plane.
bool project_point(const Camera& camera, const Vec3f& x, Eigen::Vector2d& pixel);

/// The Gaussians that can show in a camera's picture, ascending, and some more; `frame`: the whole picture, if it
/// draws a part of one.
std::vector<int> may_show(const GaussianCloud& cloud, const Camera& camera,
                          const std::optional<PictureFrame>& frame = {});

/// Pixels of a window under a stroke [H * W].
std::vector<uint8_t> stroke_pixels(const WindowView& window, const StrokePrompt& stroke);

/// What the pixels of a mask say about Gaussians, summed over views.
struct Lift {
  std::vector<float> inside, total;  ///< [N] blend weight on pixels of the mask, on all pixels (px)

  explicit Lift(size_t gaussians) : inside(gaussians, 0.0f), total(gaussians, 0.0f) {}
  void add(const GaussianCloud& cloud, const Camera& camera, const RenderOptions& options,
           const std::vector<uint8_t>& mask);
  void add(const Lift& other, float weight = 1);
};

}  // namespace pliant

#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "gaussians/base/error.h"
#include "segmentation/select/gesture.h"
#include "tests/segmentation/made_scene.h"

namespace pliant {

/// Two balls on a table, and what boxes, clicks and strokes over them select.
struct GestureTest : ::testing::Test {
  MadeScene scene = made_scene(two_balls());
  GestureOptions options;
  PrepareOptions prepare;

  GestureTest() {
    options.window = options.refine_window = 120;
    options.refine_views = 6;
    prepare.view_pixels = 120;
    prepare.view.area = 9;
    options.up = Vec3f::UnitZ();
  }

  /// Rectangle of an id in a view, grown by a share of its size.
  BoxPrompt box_of(uint32_t id, int camera, float loosen) const {
    const IdImage ids = cast_ids(scene, scene.cameras[camera]);
    BoxPrompt box{camera, INFINITY, INFINITY, 0, 0};
    for (int y = 0; y < ids.height; ++y)
      for (int x = 0; x < ids.width; ++x)
        if (ids(x, y) == id) {
          box.x0 = std::min<float>(box.x0, x);
          box.x1 = std::max<float>(box.x1, x + 1);
          box.y0 = std::min<float>(box.y0, y);
          box.y1 = std::max<float>(box.y1, y + 1);
        }
    const float dx = loosen * (box.x1 - box.x0), dy = loosen * (box.y1 - box.y0);
    return {camera, box.x0 - dx, box.y0 - dy, box.x1 + dx, box.y1 + dy};
  }

  /// Pixel where the ball's centre is seen.
  Vec2f centre_of(int ball, int camera) const {
    Eigen::Vector2d x;
    project_point(scene.cameras[camera], scene.balls[ball].centre, x);
    return x.cast<float>();
  }

  /// The `count` Gaussians of a ball's near side whose centres lie nearest to a pixel.
  std::vector<size_t> nearest_to(const Vec2f& pixel, int camera, uint32_t id, size_t count) const {
    const Vec3f eye = scene.cameras[camera].centre().cast<float>();
    std::vector<std::pair<float, size_t>> found;
    for (size_t p = 0; p < scene.truth.size(); ++p) {
      const Vec3f& x = scene.cloud.position[p];
      Eigen::Vector2d at;
      if (scene.truth[p] != id || !project_point(scene.cameras[camera], x, at)) continue;
      const Vec3f outwards = rotation_matrix<float>(scene.cloud.rotation[p]).col(2);
      if (outwards.dot(eye - x) > 0) found.emplace_back((at.cast<float>() - pixel).norm(), p);
    }
    std::sort(found.begin(), found.end());
    std::vector<size_t> out;
    for (size_t k = 0; k < std::min(count, found.size()); ++k) out.push_back(found[k].second);
    return out;
  }

  double iou(const GestureResult& result, uint32_t id) const {
    size_t both = 0, either = 0;
    for (size_t p = 0; p < scene.truth.size(); ++p) {
      both += result.selected(p) && scene.truth[p] == id;
      either += result.selected(p) || scene.truth[p] == id;
    }
    return static_cast<double>(both) / static_cast<double>(either);
  }

  GestureResult select(const Gesture& gesture, const std::optional<SelectionShape>& shape = {}) const {
    return select_by_gesture(options, gesture, shape, scene.cloud, scene.cameras,
                             prepare_scene(prepare, scene.cloud, scene.cameras));
  }

  /// Stripes of three colours, one of them the table's.
  void paint_stripes(uint32_t id) {
    const Vec3f colours[3] = {{0.8f, 0.1f, 0.1f}, {0.7f, 0.5f, 0.3f}, {0.1f, 0.3f, 0.8f}};
    for (size_t p = 0; p < scene.truth.size(); ++p) {
      if (scene.truth[p] != id) continue;
      const Vec3f& colour =
          colours[std::clamp(static_cast<int>(std::floor((scene.cloud.position[p].x() + 0.6f) / 0.2f)), 0, 2)];
      for (int k = 0; k < 3; ++k) scene.cloud.sh_of(p)[k] = (colour[k] - 0.5f) / kSh0;
    }
  }

  static std::string complaint(const std::function<void()>& action) {
    try {
      action();
    } catch (const Error& error) {
      EXPECT_EQ(error.failure, Failure::kUsage);
      EXPECT_FALSE(error.remedy.empty());
      return error.what();
    }
    return "";
  }
};

}  // namespace pliant

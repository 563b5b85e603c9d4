#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <vector>

#include "gaussians/base/camera.h"
#include "gaussians/base/gaussian_cloud.h"
#include "gaussians/base/linear_algebra.h"
#include "gaussians/base/portable.h"
#include "gaussians/base/random.h"
#include "segmentation/labels/mask_set.h"

namespace pliant {

/// Small scenes with known truth: flat discs on a table z = 0 and on balls sunk into it, and cameras around them.
struct MadeScene {
  struct Ball {
    Vec3f centre;
    float radius;
    uint32_t id;
    Vec3f colour;
  };
  static constexpr uint32_t kTable = 3;
  static constexpr float kHalf = 1.0f;  ///< the table spans [-kHalf, kHalf]^2

  GaussianCloud cloud;
  std::vector<uint32_t> truth;  ///< id of every Gaussian
  std::vector<Ball> balls;
  std::vector<Camera> cameras;
};

/// Appends a disc of standard deviation `sigma` with its short axis along `normal`.
inline void add_disc(GaussianCloud& cloud, const Vec3f& x, const Vec3f& normal, float sigma, const Vec3f& colour) {
  const size_t i = cloud.size();
  cloud.resize(i + 1);
  cloud.position[i] = x;
  cloud.rotation[i] = quaternion_wxyz(shortest_rotation<float>(Vec3f::UnitZ(), normal));
  cloud.log_scale[i] = Vec3f(std::log(sigma), std::log(sigma), std::log(0.1f * sigma));
  cloud.opacity_logit[i] = logit(0.95f);
  for (int k = 0; k < 3; ++k) cloud.sh_of(i)[k] = (colour[k] - 0.5f) / kSh0;
}

/// Table colour at (x, y): planks along y, 0.25 wide.
inline Vec3f plank_colour(float x, float) {
  const float phase = x / 0.25f - std::floor(x / 0.25f);
  return phase < 0.12f ? Vec3f(0.2f, 0.12f, 0.08f) : Vec3f(0.7f, 0.5f, 0.3f);
}

/// A table with balls; Gaussians that no camera sees (inside and under a ball) are left out, as in a real capture.
/// Steps are the distances between Gaussians of the table and of a ball.
inline MadeScene made_scene(const std::vector<MadeScene::Ball>& balls, int views = 10, int width = 120, int height = 90,
                            float step = 0.03f, float ball_step = 0.03f) {
  MadeScene scene;
  scene.balls = balls;
  for (float x = -MadeScene::kHalf; x <= MadeScene::kHalf; x += step)
    for (float y = -MadeScene::kHalf; y <= MadeScene::kHalf; y += step) {
      bool hidden = false;
      for (const auto& ball : balls) hidden = hidden || (Vec3f(x, y, 0) - ball.centre).norm() < ball.radius - step;
      if (hidden) continue;
      add_disc(scene.cloud, Vec3f(x, y, 0), Vec3f::UnitZ(), 0.6f * step, plank_colour(x, y));
      scene.truth.push_back(MadeScene::kTable);
    }
  for (const auto& ball : balls) {
    const int n = static_cast<int>(4 * M_PI * ball.radius * ball.radius / (ball_step * ball_step));
    for (int i = 0; i < n; ++i) {  // spiral of equal areas, a little inside so that the splats end at the ball
      const float z = 1 - (2 * i + 1.0f) / n, r = std::sqrt(1 - z * z), angle = 2.399963f * i;
      const Vec3f normal(r * std::cos(angle), r * std::sin(angle), z);
      if (ball.centre.z() + ball.radius * z < 0) continue;
      add_disc(scene.cloud, ball.centre + (ball.radius - ball_step) * normal, normal, 0.8f * ball_step, ball.colour);
      scene.truth.push_back(ball.id);
    }
  }
  for (int v = 0; v < views; ++v) {
    const double angle = 2 * M_PI * v / views, lift = v % 2 ? 0.9 : 1.6;
    Camera camera = look_at({2.2 * std::cos(angle), 2.2 * std::sin(angle), lift}, {0, 0, 0.1}, {0, 0, 1}, width, height,
                            width * 0.9);
    camera.name = "view" + std::to_string(v);
    scene.cameras.push_back(camera);
  }
  return scene;
}

/// First and past-the-last pixels, along x and y, between the tangents from the camera to a ball; all of the picture
/// when the ball reaches to the camera's plane.
inline std::array<int, 4> ball_pixels(const MadeScene::Ball& ball, const Camera& camera) {
  const Vec3d c = camera.cam_from_world * ball.centre.cast<double>();
  const double r2 = static_cast<double>(ball.radius) * ball.radius, depth = c.z() * c.z() - r2;
  std::array<int, 4> range = {0, camera.width, 0, camera.height};
  if (c.z() <= 0 || depth <= 0) return range;
  for (int k = 0; k < 2; ++k) {
    const double focal = k ? camera.fy : camera.fx, centre = k ? camera.cy : camera.cx;
    const double wide = ball.radius * std::sqrt(c[k] * c[k] + depth);
    range[2 * k] = std::max(0, static_cast<int>(std::floor(centre + focal * (c[k] * c.z() - wide) / depth)));
    range[2 * k + 1] =
        std::min(range[2 * k + 1], static_cast<int>(std::ceil(centre + focal * (c[k] * c.z() + wide) / depth)) + 1);
  }
  return range;
}

/// Ids seen by a camera, by casting a ray through every pixel centre.
inline IdImage cast_ids(const MadeScene& scene, const Camera& camera) {
  IdImage ids(camera.width, camera.height, 1);
  const Vec3d eye = camera.centre();
  std::vector<std::array<int, 4>> pixels;
  for (const auto& ball : scene.balls) pixels.push_back(ball_pixels(ball, camera));
  parallel_for(
      camera.height,
      [&](std::ptrdiff_t row) {
        const int y = static_cast<int>(row);
        std::vector<double> nearest(camera.width, INFINITY);
        for (int x = 0; x < camera.width; ++x) {
          const Vec3d ray = camera.ray(x + 0.5, y + 0.5);
          if (ray.z() >= 0) continue;
          const double t = -eye.z() / ray.z();
          const Vec3d hit = eye + t * ray;
          if (std::abs(hit.x()) < MadeScene::kHalf && std::abs(hit.y()) < MadeScene::kHalf) {
            nearest[x] = t;
            ids(x, y) = MadeScene::kTable;
          }
        }
        for (size_t b = 0; b < scene.balls.size(); ++b) {
          const auto& [x0, x1, y0, y1] = pixels[b];
          if (y < y0 || y >= y1) continue;
          const auto& ball = scene.balls[b];
          const Vec3d to = ball.centre.cast<double>() - eye;
          const double r2 = ball.radius * ball.radius;
          for (int x = x0; x < x1; ++x) {
            const double along = to.dot(camera.ray(x + 0.5, y + 0.5)), miss = to.squaredNorm() - along * along;
            if (miss < r2 && along - std::sqrt(r2 - miss) < nearest[x]) {
              nearest[x] = along - std::sqrt(r2 - miss);
              ids(x, y) = ball.id;
            }
          }
        }
      },
      8);
  return ids;
}

inline MaskSet cast_masks(const MadeScene& scene) {
  MaskSet masks;
  for (size_t c = 0; c < scene.cameras.size(); ++c)
    masks.views.push_back({static_cast<int>(c), cast_ids(scene, scene.cameras[c])});
  return masks;
}

/// side^2 balls of many colours in a grid, with ids of 8, 16 and 24 bits.
inline std::vector<MadeScene::Ball> grid_of_balls(int side) {
  std::vector<MadeScene::Ball> balls;
  const float spacing = 1.9f / static_cast<float>(side);
  for (int k = 0; k < side * side; ++k) {
    Random random(9, k, 0);
    const float radius = spacing * static_cast<float>(random.uniform(0.3, 0.4));
    const Vec3f colour(random.uniform(0.05, 0.95), random.uniform(0.05, 0.95), random.uniform(0.05, 0.95));
    const uint32_t id = 10 + static_cast<uint32_t>(k) + (k % 3 == 1 ? 1000u : k % 3 == 2 ? 70000u : 0u);
    const float x = spacing * (static_cast<float>(k % side) - 0.5f * static_cast<float>(side - 1));
    const float y = spacing * (static_cast<float>(k / side) - 0.5f * static_cast<float>(side - 1));
    balls.push_back({Vec3f(x, y, 0.6f * radius), radius, id, colour});
  }
  return balls;
}

inline std::vector<MadeScene::Ball> two_balls() {
  return {{Vec3f(-0.35f, 0.1f, 0.15f), 0.3f, 300, Vec3f(0.8f, 0.1f, 0.1f)},
          {Vec3f(0.4f, -0.15f, 0.12f), 0.22f, 70000, Vec3f(0.1f, 0.3f, 0.8f)}};
}

}  // namespace pliant

#pragma once

// A bar that stands in front of a wall, as a scene on disk; and fields on it.

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "app/store/material.h"
#include "app/store/velocity.h"
#include "gaussians/base/camera.h"
#include "gaussians/base/gaussian_cloud.h"
#include "gaussians/base/random.h"
#include "gaussians/io/cameras/transforms.h"
#include "gaussians/io/files/json_file.h"
#include "gaussians/io/splats/ply.h"

namespace pliant::study {

constexpr double kWidth = 0.05, kHeight = 0.22, kClamp = 0.03;  // m; scene units are metres

inline void add_face(GaussianCloud& cloud, Vec3d corner, Vec3d u, Vec3d v, double spacing, double contrast,
                     uint64_t seed) {
  const int nu = static_cast<int>(std::lround(u.norm() / spacing)),
            nv = static_cast<int>(std::lround(v.norm() / spacing));
  const Vec3d normal = u.cross(v).normalized();
  for (int i = 0; i < nu; ++i)
    for (int j = 0; j < nv; ++j) {
      const size_t g = cloud.size();
      cloud.resize(g + 1);
      Random random(seed, g);
      const Vec3d x = corner + (i + 0.5) / nu * u + (j + 0.5) / nv * v;
      cloud.position[g] = x.cast<float>();
      for (int a = 0; a < 3; ++a)
        cloud.log_scale[g][a] =
            static_cast<float>(std::log(std::abs(normal[a]) > 0.5 ? 0.05 * spacing : 0.6 * spacing));
      cloud.rotation[g] = Eigen::Vector4f(1, 0, 0, 0);
      cloud.opacity_logit[g] = 4;
      // The upper half of the bar is redder, so that parts can be told by colour.
      const double warm = contrast > 0.5 && x.z() > 0.5 * (kClamp + kHeight) ? 0.5 : -0.3;
      for (int c = 0; c < 3; ++c)
        cloud.sh_of(g)[c] = static_cast<float>(contrast * random.normal() + (c == 0 ? warm : 0));
    }
}

/// scene.json, splats.ply, transforms.json.
inline void write_bar_scene(const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  GaussianCloud cloud;
  cloud.sh_degree = 0;
  const double w = kWidth, h = kHeight, s = 0.0022;
  add_face(cloud, {0, 0, 0}, {w, 0, 0}, {0, 0, h}, s, 0.8, 1);
  add_face(cloud, {0, w, 0}, {w, 0, 0}, {0, 0, h}, s, 0.8, 2);
  add_face(cloud, {0, 0, 0}, {0, w, 0}, {0, 0, h}, s, 0.8, 3);
  add_face(cloud, {w, 0, 0}, {0, w, 0}, {0, 0, h}, s, 0.8, 4);
  add_face(cloud, {0, 0, h}, {w, 0, 0}, {0, w, 0}, s, 0.8, 5);
  add_face(cloud, {0, 0, 0}, {w, 0, 0}, {0, w, 0}, s, 0.8, 6);
  add_face(cloud, {-0.6, 0.5, -0.4}, {1.2, 0, 0}, {0, 0, 1.0}, 0.02, 0.2, 7);
  write_ply(folder / "splats.ply", cloud);
  std::vector<Camera> cameras;
  for (int k = 0; k < 8; ++k) {
    const double angle = (k - 3.5) * 0.25 - M_PI / 2;
    cameras.push_back(look_at({0.025 + 0.55 * std::cos(angle), 0.025 + 0.55 * std::sin(angle), 0.16},
                              {0.025, 0.025, 0.12}, {0, 0, 1}, 400, 300, 560));
    cameras.back().name = "view_" + std::to_string(k);
  }
  write_transforms(folder / "transforms.json", cameras);
  write_json(folder / "scene.json", {{"splats", "splats.ply"},
                                     {"cameras", "transforms.json"},
                                     {"up", {0, 0, 1}},
                                     {"metres_per_unit", 1.0},
                                     {"pinned", {{{"box", {-0.01, -0.01, -0.01, w + 0.01, w + 0.01, kClamp}}}}},
                                     {"material", {{"young", 1e5}, {"poisson", 0.3}, {"density", 1000.0}}}});
}

/// What is inside the bar, for fields: points on a grid.
inline std::vector<Vec3f> bar_points(double spacing = 0.004) {
  std::vector<Vec3f> points;
  for (double x = spacing / 2; x < kWidth; x += spacing)
    for (double y = spacing / 2; y < kWidth; y += spacing)
      for (double z = spacing / 2; z < kHeight; z += spacing) points.push_back(Vec3d(x, y, z).cast<float>());
  return points;
}

template <class Young>
void write_bar_material(const std::filesystem::path& file, Young&& young) {
  MaterialFile m;
  m.position = bar_points();
  for (const Vec3f& x : m.position) {
    m.young.push_back(static_cast<float>(young(x)));
    m.poisson.push_back(0.3f);
    m.density.push_back(1000.0f);
    m.volume.push_back(0.004f * 0.004f * 0.004f);
  }
  m.source = "truth of a twin experiment";
  write_material(file, m, "{}");
}

/// At rest, with a velocity that grows with the square of the height above the clamp.
inline Vec3d bar_velocity(const Vec3d& at_tip, const Vec3f& x) {
  const double s = std::max(0.0, (x.z() - kClamp) / (kHeight - kClamp));
  return s * s * at_tip;
}

inline void write_bar_velocity(const std::filesystem::path& file, const Vec3d& at_tip, double damping_time) {
  VelocityFile v;
  v.position = bar_points();
  for (const Vec3f& x : v.position) {
    const double s = std::max(0.0, (x.z() - kClamp) / (kHeight - kClamp));
    v.velocity.push_back(bar_velocity(at_tip, x).cast<float>());
    v.displacement.push_back(Vec3f::Zero());
    v.F.push_back(Mat3f::Identity());
    v.C.push_back(Mat3f::Zero());
    v.C.back().col(2) = (2 * s / (kHeight - kClamp) * at_tip).cast<float>();
  }
  v.whole_damping_time = v.damping_time = damping_time;
  v.source = "truth of a twin experiment";
  write_velocity(file, v, "{}");
}

}  // namespace pliant::study

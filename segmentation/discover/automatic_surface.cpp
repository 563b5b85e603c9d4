#include "segmentation/discover/automatic_surface.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "gaussians/base/linear_algebra.h"
#include "gaussians/base/nearest.h"
#include "gaussians/base/portable.h"

namespace pliant {
namespace {

constexpr float kUnseenAgreement = 0.5f;  // of an edge that no view shows
constexpr float kPriorViews = 0.5f;       // that would say so

bool finite(const GaussianCloud& cloud, size_t p) {
  bool good = cloud.position[p].allFinite() && cloud.rotation[p].allFinite() && cloud.log_scale[p].allFinite() &&
              std::isfinite(cloud.opacity_logit[p]) && cloud.rotation[p].norm() > 0 &&
              cloud.log_scale[p].maxCoeff() < 50;
  for (int k = 0; k < 3 * cloud.sh_count() && good; ++k) good = std::isfinite(cloud.sh_of(p)[k]);
  return good;
}

Vec3f rgb_of(const GaussianCloud& cloud, size_t p) { return dc_color(cloud.sh_of(p)).cwiseMax(0.0f).cwiseMin(1.0f); }

/// Axis of least spread of every point's neighbours, weighted by opacity.
std::vector<Vec3f> surface_normals(const GaussianCloud& cloud, int neighbours) {
  const std::vector<int> near = k_nearest(cloud.position, cloud.position, neighbours);
  std::vector<Vec3f> normal(cloud.size(), Vec3f::UnitZ());
  parallel_for(
      static_cast<std::ptrdiff_t>(cloud.size()),
      [&](std::ptrdiff_t i) {
        Vec3d mean = Vec3d::Zero();
        double total = 0;
        const auto each = [&](auto&& visit) {
          for (int j = 0; j < neighbours; ++j)
            if (const int p = near[i * neighbours + j]; p >= 0)
              visit(cloud.position[p].cast<double>(), sigmoid(cloud.opacity_logit[p]));
        };
        each([&](const Vec3d& x, double w) {
          mean += w * x;
          total += w;
        });
        mean /= total;
        Mat3d covariance = Mat3d::Zero();
        each([&](const Vec3d& x, double w) { covariance += w * (x - mean) * (x - mean).transpose(); });
        normal[i] = symmetric_eigen3(covariance).vectors.col(0).cast<float>();
      },
      256);
  return normal;
}

/// Cameras that may be looked at, thinned evenly.
std::vector<int> chosen_views(const std::vector<Camera>& cameras, const std::vector<int>& held_out, int most) {
  std::vector<int> free;
  for (int c = 0; c < static_cast<int>(cameras.size()); ++c)
    if (std::find(held_out.begin(), held_out.end(), c) == held_out.end()) free.push_back(c);
  const int count = std::min<int>(most, static_cast<int>(free.size()));
  std::vector<int> chosen;
  for (int k = 0; k < count; ++k) chosen.push_back(free[static_cast<size_t>(k) * free.size() / count]);
  return chosen;
}

}  // namespace

SolidScene solid_scene(const SolidOptions& options, const GaussianCloud& cloud, const std::vector<Camera>& cameras,
                       const std::vector<int>& held_out) {
  SolidScene scene;
  for (size_t p = 0; p < cloud.size(); ++p)
    if (finite(cloud, p) && sigmoid(cloud.opacity_logit[p]) >= options.opacity)
      scene.gaussian.push_back(static_cast<int>(p));
  scene.cloud = cloud.select(scene.gaussian);
  scene.graph = gaussian_graph(scene.cloud, std::vector<uint8_t>(scene.cloud.size(), 1), options.neighbours);

  // What is far larger than the surfaces are fine is haze; without it the graph is made anew.
  std::vector<int> fine;
  const float largest = options.largest * scene.graph.spacing;
  for (size_t i = 0; i < scene.size(); ++i)
    if (std::exp(scene.cloud.log_scale[i].maxCoeff()) <= largest) fine.push_back(static_cast<int>(i));
  if (fine.size() < scene.size() && !fine.empty()) {
    scene.cloud = scene.cloud.select(fine);
    for (int& i : fine) i = scene.gaussian[i];
    scene.gaussian = std::move(fine);
    scene.graph = gaussian_graph(scene.cloud, std::vector<uint8_t>(scene.cloud.size(), 1), options.neighbours);
  }
  const size_t n = scene.size();
  scene.normal = surface_normals(scene.cloud, options.neighbours + 2);
  scene.mass.assign(n, 0.0f);
  std::vector<Vec3f> rgb(n);
  for (size_t i = 0; i < n; ++i) rgb[i] = rgb_of(scene.cloud, i);

  std::vector<float> same(scene.graph.edges.size(), 0.0f), seen(scene.graph.edges.size(), 0.0f);
  for (const int c : chosen_views(cameras, held_out, options.most_views)) {
    if (n == 0) break;
    const double side = std::max(cameras[c].width, cameras[c].height);
    const Camera camera = cameras[c].scaled(std::min(1.0, options.longest_side / side));
    const BlendWeights weights = blend_weights(scene.cloud, camera, options.footprint.render);
    const SurfacePicture picture = surface_picture(weights, camera, scene.cloud.position, rgb, scene.normal);
    const ViewFootprints view =
        footprints(options.footprint, weights, n, {c, picture_segments(options.segments, picture)});
    std::vector<int> segment(n, -1);
    for (size_t e = 0; e < view.gaussian.size(); ++e) {
      segment[view.gaussian[e]] = view.mask[e];
      scene.mass[view.gaussian[e]] += view.mass[e] / static_cast<float>(weights.pixels());
    }
    for (size_t e = 0; e < same.size(); ++e) {
      const int a = segment[scene.graph.edges[e].a], b = segment[scene.graph.edges[e].b];
      if (a >= 0 && b >= 0) {
        seen[e] += 1;
        same[e] += a == b;
      }
    }
    ++scene.views;
  }
  for (float& mass : scene.mass) mass /= static_cast<float>(std::max(1, scene.views));
  scene.agreement.resize(same.size());
  for (size_t e = 0; e < same.size(); ++e)
    scene.agreement[e] = (same[e] + kUnseenAgreement * kPriorViews) / (seen[e] + kPriorViews);
  return scene;
}

}  // namespace pliant

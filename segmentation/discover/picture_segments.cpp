#include "segmentation/discover/picture_segments.h"

#include <algorithm>
#include <cmath>

#include "gaussians/base/disjoint_sets.h"
#include "gaussians/base/error.h"
#include "gaussians/base/portable.h"
#include "segmentation/graph/color_model.h"

namespace pliant {
namespace {

struct PixelEdge {
  float weight;
  int a, b;
};

/// Union of pixels into segments, with the size of each and its largest inner difference.
class Segments {
 public:
  explicit Segments(size_t pixels) : sets_(pixels), size_(pixels, 1), inner_(pixels, 0.0f) {}
  int root(int i) { return sets_.find(i); }
  int size(int root) const { return size_[root]; }
  /// Largest difference at which a segment still joins others.
  float tolerance(int root, float scale) const { return inner_[root] + scale / static_cast<float>(size_[root]); }
  void join(int a, int b, float weight) {
    if (size_[a] < size_[b]) std::swap(a, b);
    sets_.join_into(a, b);
    size_[a] += size_[b];
    inner_[a] = std::max({inner_[a], inner_[b], weight});
  }

 private:
  DisjointSets sets_;
  std::vector<int> size_;
  std::vector<float> inner_;
};

float squared(float x) { return x * x; }

}  // namespace

SurfacePicture surface_picture(const BlendWeights& weights, const Camera& camera, std::span<const Vec3f> position,
                               std::span<const Vec3f> rgb, std::span<const Vec3f> normal) {
  CHECK(position.size() == rgb.size() && rgb.size() == normal.size());
  SurfacePicture out;
  out.width = weights.width;
  out.height = weights.height;
  out.focal = std::max(camera.fx, camera.fy);
  out.alpha.resize(weights.pixels());
  out.lab.resize(weights.pixels());
  out.point.resize(weights.pixels());
  out.normal.resize(weights.pixels());
  const Mat3f turn = camera.cam_from_world.linear().cast<float>();
  const Vec3f shift = camera.cam_from_world.translation().cast<float>(), eye = camera.centre().cast<float>();
  parallel_for(
      static_cast<std::ptrdiff_t>(weights.pixels()),
      [&](std::ptrdiff_t i) {
        float alpha = 0, depth = 0;
        Vec3f color = Vec3f::Zero(), facing = Vec3f::Zero();
        for (uint32_t e = weights.row_start[i]; e < weights.row_start[i + 1]; ++e) {
          const uint32_t p = weights.gaussian[e];
          const float w = weights.weight[e];
          alpha += w;
          color += w * rgb[p];
          depth += w * (turn.row(2).dot(position[p]) + shift.z());
          facing += (normal[p].dot(eye - position[p]) < 0 ? -w : w) * normal[p];
        }
        out.alpha[i] = alpha;
        if (!(alpha > 1e-4f)) return;
        out.lab[i] = lab_of_rgb(color / alpha);
        const double x = static_cast<double>(i % weights.width) + 0.5, y = static_cast<double>(i / weights.width) + 0.5;
        out.point[i] =
            depth / alpha * Vec3d((x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy, 1.0).cast<float>();
        if (const float length = facing.norm(); length > 0.1f * alpha) out.normal[i] = turn * facing / length;
      },
      256);
  return out;
}

IdImage picture_segments(const PictureSegmentOptions& options, const SurfacePicture& picture) {
  const int width = picture.width, height = picture.height;
  std::vector<PixelEdge> edges;
  edges.reserve(2 * picture.alpha.size());
  const auto difference = [&](int a, int b) {
    const Vec3f shift = picture.lab[b] - picture.lab[a];
    const float color = Vec3f(options.lightness * shift.x(), shift.y(), shift.z()).norm() / options.color;
    const Vec3f step = picture.point[b] - picture.point[a];
    float turn = 0, distance = 0;
    if (!picture.normal[a].isZero() && !picture.normal[b].isZero()) {
      if ((picture.normal[b] - picture.normal[a]).dot(step) < 0)
        turn = std::acos(std::clamp(picture.normal[a].dot(picture.normal[b]), -1.0f, 1.0f)) / options.angle;
      distance = std::min(std::abs(picture.normal[a].dot(step)), std::abs(picture.normal[b].dot(step)));
    } else {
      distance = std::abs(step.z());
    }
    const float pixel =
        std::max(std::min(picture.point[a].z(), picture.point[b].z()), 1e-12f) / static_cast<float>(picture.focal);
    return std::sqrt(squared(color) + squared(turn) + squared(distance / (options.jump * pixel)));
  };
  const auto opaque = [&](int i) { return picture.alpha[i] >= options.opaque; };
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const int a = y * width + x;
      if (!opaque(a)) continue;
      if (x + 1 < width && opaque(a + 1)) edges.push_back({difference(a, a + 1), a, a + 1});
      if (y + 1 < height && opaque(a + width)) edges.push_back({difference(a, a + width), a, a + width});
    }
  std::stable_sort(edges.begin(), edges.end(),
                   [](const PixelEdge& a, const PixelEdge& b) { return a.weight < b.weight; });

  Segments segments(picture.alpha.size());
  for (const PixelEdge& edge : edges) {
    const int a = segments.root(edge.a), b = segments.root(edge.b);
    if (a == b) continue;
    if (edge.weight <= std::min(segments.tolerance(a, options.scale), segments.tolerance(b, options.scale)))
      segments.join(a, b, edge.weight);
  }
  for (const PixelEdge& edge : edges) {
    const int a = segments.root(edge.a), b = segments.root(edge.b);
    if (a != b && std::min(segments.size(a), segments.size(b)) < options.least) segments.join(a, b, edge.weight);
  }
  IdImage ids(width, height, 1);
  std::vector<uint32_t> number(picture.alpha.size(), 0);
  uint32_t count = 0;
  for (int i = 0; i < width * height; ++i) {
    if (!opaque(i)) continue;
    uint32_t& id = number[segments.root(i)];
    if (id == 0) id = ++count;
    ids.data[i] = id;
  }
  return ids;
}

}  // namespace pliant

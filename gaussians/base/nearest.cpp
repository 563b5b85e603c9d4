#include "gaussians/base/nearest.h"

#include <algorithm>
#include <cmath>
#include <nanoflann.hpp>

#include "gaussians/base/portable.h"

namespace pliant {
namespace {

struct Points {
  std::span<const Vec3f> points;
  size_t kdtree_get_point_count() const { return points.size(); }
  float kdtree_get_pt(size_t i, size_t axis) const { return points[i][static_cast<int>(axis)]; }
  template <class Bounds>
  bool kdtree_get_bbox(Bounds&) const {
    return false;
  }
};

using KdTree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, Points>, Points, 3, uint32_t>;

void order(std::vector<NearestPoints::Hit>& hits) {
  std::sort(hits.begin(), hits.end(), [](const auto& a, const auto& b) {
    return a.distance != b.distance ? a.distance < b.distance : a.index < b.index;
  });
}

}  // namespace

struct NearestPoints::Tree {
  Points points;
  KdTree index;
  explicit Tree(std::span<const Vec3f> p)
      : points{p}, index(3, points, nanoflann::KDTreeSingleIndexAdaptorParams(12)) {}
};

NearestPoints::NearestPoints(std::span<const Vec3f> points) : tree_(std::make_unique<Tree>(points)) {}
NearestPoints::~NearestPoints() = default;
NearestPoints::NearestPoints(NearestPoints&&) noexcept = default;

void NearestPoints::query(const Vec3f& x, int k, std::vector<Hit>& hits) const {
  std::vector<uint32_t> index(k);
  std::vector<float> squared(k);
  const size_t found = tree_->index.knnSearch(x.data(), k, index.data(), squared.data());
  hits.clear();
  for (size_t i = 0; i < found; ++i) hits.push_back({static_cast<int>(index[i]), std::sqrt(squared[i])});
  order(hits);
}

void NearestPoints::within(const Vec3f& x, float radius, std::vector<Hit>& hits) const {
  around(x, radius, hits);
  order(hits);
}

void NearestPoints::around(const Vec3f& x, float radius, std::vector<Hit>& hits) const {
  thread_local std::vector<std::pair<uint32_t, float>> found;
  found.clear();
  tree_->index.radiusSearch(x.data(), radius * radius, found, nanoflann::SearchParams(32, 0.0f, false));
  hits.clear();
  for (const auto& [index, squared] : found) hits.push_back({static_cast<int>(index), std::sqrt(squared)});
}

std::vector<int> k_nearest(std::span<const Vec3f> points, std::span<const Vec3f> queries, int k) {
  const NearestPoints tree(points);
  std::vector<int> out(queries.size() * k, -1);
  parallel_for(
      static_cast<std::ptrdiff_t>(queries.size()),
      [&](std::ptrdiff_t q) {
        std::vector<NearestPoints::Hit> hits;
        tree.query(queries[q], k, hits);
        for (size_t j = 0; j < hits.size(); ++j) out[q * k + j] = hits[j].index;
      },
      256);
  return out;
}

}  // namespace pliant

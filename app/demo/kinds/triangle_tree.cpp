#include "app/demo/kinds/triangle_tree.h"

#include <algorithm>
#include <cmath>

namespace pliant {
namespace {

constexpr int kTrianglesOfLeaf = 4;  // triangles at most

/// Whether a ray crosses a box before t_max.
bool crosses(const Eigen::AlignedBox3d& box, const Vec3d& origin, const Vec3d& inverse, double t_max) {
  double enter = 0, leave = t_max;
  for (int k = 0; k < 3; ++k) {
    const double a = (box.min()[k] - origin[k]) * inverse[k], b = (box.max()[k] - origin[k]) * inverse[k];
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  return enter <= leave;
}

}  // namespace

TriangleTree::TriangleTree(const TriangleMesh& mesh) {
  for (size_t i = 0; i < mesh.triangle.size(); ++i) {
    const Eigen::Vector3i& t = mesh.triangle[i];
    const Vec3d& corner = mesh.vertex[t[0]];
    triangles_.push_back({corner, mesh.vertex[t[1]] - corner, mesh.vertex[t[2]] - corner, static_cast<int>(i)});
  }
  if (!triangles_.empty()) build(0, static_cast<int>(triangles_.size()));
}

int TriangleTree::build(int begin, int end) {
  const int self = static_cast<int>(nodes_.size());
  nodes_.emplace_back();
  Eigen::AlignedBox3d box, centres;
  for (int i = begin; i < end; ++i) {
    const Triangle& t = triangles_[i];
    for (const Vec3d& x : {t.corner, Vec3d(t.corner + t.first), Vec3d(t.corner + t.second)}) box.extend(x);
    centres.extend(t.corner);
  }
  // A flat box is met as well as a thick one.
  box.min().array() -= 1e-9;
  box.max().array() += 1e-9;
  nodes_[self].box = box;
  nodes_[self].begin = begin;
  nodes_[self].end = end;
  if (end - begin <= kTrianglesOfLeaf) return self;
  int axis = 0;
  centres.sizes().maxCoeff(&axis);
  const int middle = (begin + end) / 2;
  std::nth_element(triangles_.begin() + begin, triangles_.begin() + middle, triangles_.begin() + end,
                   [axis](const Triangle& a, const Triangle& b) {
                     return std::pair(a.corner[axis], a.index) < std::pair(b.corner[axis], b.index);
                   });
  build(begin, middle);
  nodes_[self].other = build(middle, end);
  return self;
}

template <class Visit>
void TriangleTree::visit(const Ray& ray, const double& t_max, Visit&& meets) const {
  if (nodes_.empty()) return;
  const Vec3d inverse = ray.direction.cwiseInverse();
  int stack[64], top = 0;
  stack[top++] = 0;
  while (top > 0) {
    const int at = stack[--top];
    const Node& node = nodes_[at];
    if (!crosses(node.box, ray.origin, inverse, t_max)) continue;
    if (node.other > 0) {
      stack[top++] = node.other;
      stack[top++] = at + 1;
      continue;
    }
    for (int i = node.begin; i < node.end; ++i) {
      const Triangle& triangle = triangles_[i];
      const Vec3d p = ray.direction.cross(triangle.second);
      const double determinant = triangle.first.dot(p);
      if (determinant == 0) continue;
      const Vec3d from = ray.origin - triangle.corner, q = from.cross(triangle.first);
      const double b = from.dot(p) / determinant, c = ray.direction.dot(q) / determinant;
      if (b < 0 || c < 0 || b + c > 1) continue;
      meets(triangle.index, triangle.second.dot(q) / determinant, b, c, determinant);
    }
  }
}

TriangleTree::Hit TriangleTree::first(const Ray& ray, double t_min, double t_max) const {
  Hit best;
  best.t = t_max;
  visit(ray, best.t, [&](int triangle, double t, double b, double c, double) {
    if (t > t_min && t < best.t) best = {triangle, t, b, c};
  });
  return best;
}

int TriangleTree::winding(const Vec3d& x) const {
  // Any direction serves that no mesh is aligned with.
  const Ray ray{x, Vec3d(0.5377, 0.3183, 0.7807).normalized()};
  int count = 0;
  visit(ray, kNoHit, [&](int, double t, double, double, double determinant) {
    // A ray that goes out crosses a triangle from behind, where the determinant is negative.
    if (t > 0) count += determinant < 0 ? 1 : -1;
  });
  return count;
}

}  // namespace pliant

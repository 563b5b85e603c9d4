#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "app/demo/kinds/shapes.h"

namespace pliant {

/// Boxes around boxes around the triangles of a closed mesh, halved at the median of the longest side.
class TriangleTree {
 public:
  TriangleTree() = default;
  explicit TriangleTree(const TriangleMesh& mesh);

  /// A crossing at t with the triangle's weights 1 - b - c, b, c; triangle = -1: none.
  struct Hit {
    int triangle = -1;
    double t = kNoHit, b = 0, c = 0;
  };
  /// First crossing with t in (t_min, t_max) (Moeller and Trumbore 1997).
  Hit first(const Ray& ray, double t_min, double t_max) const;
  /// How many times the mesh encloses x, whose triangles face outwards.
  int winding(const Vec3d& x) const;

 private:
  struct Node {
    Eigen::AlignedBox3d box;
    int begin = 0, end = 0;  ///< triangles of a leaf
    int other = 0;           ///< second child; the first follows its parent; 0 = leaf
  };
  struct Triangle {
    Vec3d corner, first, second;  ///< a corner and the edges from it
    int index;
  };
  int build(int begin, int end);
  template <class Visit>
  void visit(const Ray& ray, const double& t_max, Visit&& leaf) const;

  std::vector<Node> nodes_;
  std::vector<Triangle> triangles_;
};

}  // namespace pliant

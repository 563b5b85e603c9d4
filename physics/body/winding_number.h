#pragma once

#include <vector>

#include "physics/body/surfels.h"

namespace pliant {

/// Generalised winding number of oriented discs (Barill et al. 2018): about 1 inside, 0 outside, 1/2 on the surface.
/// Distant groups of discs act as one dipole.
class WindingNumber {
 public:
  explicit WindingNumber(const std::vector<Surfel>& surfels);
  bool empty() const { return nodes_.empty(); }  ///< no surfel bounds anything
  float at(const Vec3f& x) const { return empty() ? 0.0f : at(0, x) / (4 * 3.14159265f); }

 private:
  struct Disc {
    Vec3f position, moment;  // moment = area * outward normal
    float softening;         // squared radius inside which the dipole is smooth
  };
  struct Node {
    Vec3f centre, moment;
    float radius;
    int begin, end;  // discs
    int right = -1;  // the left child follows its parent; -1 for a leaf
  };

  int build(int begin, int end);
  float at(int node, const Vec3f& x) const;

  std::vector<Disc> discs_;
  std::vector<Node> nodes_;
};

}  // namespace pliant

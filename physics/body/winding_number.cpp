#include "physics/body/winding_number.h"

#include <algorithm>
#include <cmath>

namespace pliant {
namespace {

constexpr float kSoftening = 0.03f;  // squared radius of smoothing over the area of a disc
constexpr int kLeaf = 8;
constexpr float kOpening = 2.0f;  // a group farther than this many of its radii is one dipole

float dipole(const Vec3f& moment, const Vec3f& r, float softening) {
  const float d2 = r.squaredNorm() + softening;
  return moment.dot(r) / (d2 * std::sqrt(d2));
}

}  // namespace

WindingNumber::WindingNumber(const std::vector<Surfel>& surfels) {
  for (const Surfel& s : surfels)
    if (s.one_sided()) discs_.push_back({s.position, s.area * s.normal, kSoftening * s.area});
  if (!discs_.empty()) build(0, static_cast<int>(discs_.size()));
}

int WindingNumber::build(int begin, int end) {
  const int index = static_cast<int>(nodes_.size());
  nodes_.emplace_back();
  Node node{Vec3f::Zero(), Vec3f::Zero(), 0, begin, end, -1};
  Box box;
  float weight = 0;
  for (int i = begin; i < end; ++i) {
    const float area = discs_[i].moment.norm();
    node.centre += area * discs_[i].position;
    node.moment += discs_[i].moment;
    weight += area;
    box.add(discs_[i].position);
  }
  node.centre = weight > 0 ? Vec3f(node.centre / weight) : box.centre();
  for (int i = begin; i < end; ++i) node.radius = std::max(node.radius, (discs_[i].position - node.centre).norm());
  if (end - begin > kLeaf) {
    int axis = 0;
    box.size().maxCoeff(&axis);
    const int middle = (begin + end) / 2;
    std::nth_element(discs_.begin() + begin, discs_.begin() + middle, discs_.begin() + end,
                     [axis](const Disc& a, const Disc& b) { return a.position[axis] < b.position[axis]; });
    build(begin, middle);
    node.right = build(middle, end);
  }
  nodes_[index] = node;
  return index;
}

float WindingNumber::at(int index, const Vec3f& x) const {
  const Node& node = nodes_[index];
  const Vec3f r = node.centre - x;
  if (r.squaredNorm() > kOpening * kOpening * node.radius * node.radius && node.end - node.begin > 1)
    return dipole(node.moment, r, 0);
  if (node.right >= 0) return at(index + 1, x) + at(node.right, x);
  float sum = 0;
  for (int i = node.begin; i < node.end; ++i)
    sum += dipole(discs_[i].moment, discs_[i].position - x, discs_[i].softening);
  return sum;
}

}  // namespace pliant

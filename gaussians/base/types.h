#pragma once

#include <Eigen/Core>
#include <cmath>
#include <vector>

namespace pliant {

using Vec2f = Eigen::Vector2f;
using Vec3f = Eigen::Vector3f;
using Vec4f = Eigen::Vector4f;
using Mat3f = Eigen::Matrix3f;
using Vec3d = Eigen::Vector3d;
using Mat3d = Eigen::Matrix3d;

template <class T>
using Vec3 = Eigen::Matrix<T, 3, 1>;
template <class T>
using Mat3 = Eigen::Matrix<T, 3, 3>;

/// Axis-aligned box [low, high].
struct Box {
  Vec3f low = Vec3f::Constant(INFINITY), high = Vec3f::Constant(-INFINITY);

  void add(const Vec3f& x) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  bool contains(const Vec3f& x) const { return (x.array() >= low.array()).all() && (x.array() <= high.array()).all(); }
  Vec3f size() const { return high - low; }
  Vec3f centre() const { return 0.5f * (low + high); }
  bool empty() const { return !(low.array() <= high.array()).all(); }
};

}  // namespace pliant

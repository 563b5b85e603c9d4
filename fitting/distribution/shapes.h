#pragma once

#include <functional>
#include <vector>

#include "gaussians/base/random.h"
#include "gaussians/base/types.h"

namespace pliant {

/// A place inside of a shape, in the shape's own terms too.
struct ShapePoint {
  Vec3f position = Vec3f::Zero();
  float along = 0;   ///< 0..1 from where the shape begins (root, bottom) to where it ends
  float across = 0;  ///< sheets: -1..1 from edge to edge; others: 0 in the middle or inside, 1 at the outside
  float depth = 0;   ///< distance from the shape's own surface [m]
};

/// A solid that knows its volume and can be sampled uniformly.  Lengths in metres.
class SolidShape {
 public:
  virtual ~SolidShape() = default;
  virtual double volume() const = 0;
  virtual ShapePoint sample(Random& random) const = 0;  ///< uniform over the volume
  virtual bool contains(const Vec3f& x) const = 0;      ///< sheets contain nothing: they displace no other shape
  virtual double thickness() const = 0;                 ///< smallest, typical of the shape
  virtual int thin_directions() const = 0;              ///< 0 = a lump, 1 = a sheet, 2 = a rod
  /// Samples about `spacing` apart that fill it: what is thinner than the spacing is one sample thick.
  double samples_at(double spacing) const;
};

/// A chain of points that starts at `start` along `direction`, `length` long, and turns toward `pull` by up to
/// `bend` radians at its end.
std::vector<Vec3f> curve(const Vec3f& start, const Vec3f& direction, float length, const Vec3f& pull, float bend);
/// Point and unit tangent at the share 0..1 of a chain's length.
struct CurvePlace {
  Vec3f position, tangent;
};
CurvePlace place_on(const std::vector<Vec3f>& chain, float along);
/// A unit vector across `axis`, turned by `angle` around it.
Vec3f across_axis(const Vec3f& axis, float angle);
/// A frame whose third column is along `axis`.
Mat3f axes_along(const Vec3f& axis);
/// The chain of two points.
inline std::vector<Vec3f> straight(const Vec3f& from, const Vec3f& to) { return {from, to}; }

/// Round rod along a chain, from radius `first` to `last`.
class Tube : public SolidShape {
 public:
  Tube(std::vector<Vec3f> chain, float first, float last);
  double volume() const override;
  ShapePoint sample(Random& random) const override;
  bool contains(const Vec3f& x) const override;
  double thickness() const override { return first_ + last_; }
  int thin_directions() const override { return 2; }

 private:
  float radius(float along) const { return first_ + (last_ - first_) * along; }
  std::vector<Vec3f> chain_;
  float first_, last_, length_ = 0;
};

/// Thin sheet about a chain: half width `half_width(along)`, edges lifted along the normal by `curl` half widths.
class Sheet : public SolidShape {
 public:
  Sheet(std::vector<Vec3f> chain, const Vec3f& side, std::function<float(float)> half_width, float curl,
        float thickness);
  double volume() const override;
  ShapePoint sample(Random& random) const override;
  bool contains(const Vec3f&) const override { return false; }
  double thickness() const override { return thickness_; }
  int thin_directions() const override { return 1; }

 private:
  std::vector<Vec3f> chain_;
  Vec3f side_;
  std::function<float(float)> half_width_;
  float curl_, thickness_, widest_ = 0, length_ = 0;
};

/// Ellipsoid with `radii` along the columns of `axes`; hollow where `wall` > 0.  `along` runs along the third axis.
class Ellipsoid : public SolidShape {
 public:
  Ellipsoid(const Vec3f& centre, const Vec3f& radii, const Mat3f& axes = Mat3f::Identity(), float wall = 0);
  double volume() const override;
  ShapePoint sample(Random& random) const override;
  bool contains(const Vec3f& x) const override;
  double thickness() const override { return wall_ > 0 ? wall_ : 2 * radii_.minCoeff(); }
  int thin_directions() const override { return wall_ > 0 ? 1 : 0; }

 private:
  Vec3f local(const Vec3f& x) const { return (axes_.transpose() * (x - centre_)).cwiseQuotient(radii_); }
  Vec3f centre_, radii_;
  Mat3f axes_;
  float wall_, inner_;  // inner_: share of the radii that is empty
};

/// Body of revolution about `axis` from `base`, `height` long, between the radii `inner(along)` and `outer(along)`.
class Lathe : public SolidShape {
 public:
  Lathe(const Vec3f& base, const Vec3f& axis, float height, std::function<float(float)> outer,
        std::function<float(float)> inner = {});
  double volume() const override { return volume_; }
  ShapePoint sample(Random& random) const override;
  bool contains(const Vec3f& x) const override;
  double thickness() const override { return thickness_; }
  int thin_directions() const override { return inner_ || height_ < 0.3f * widest_ ? 1 : 0; }

 private:
  float inner(float along) const { return inner_ ? inner_(along) : 0.0f; }
  Vec3f base_, axis_, first_, second_;
  float height_, widest_ = 0;
  std::function<float(float)> outer_, inner_;
  double volume_ = 0, thickness_ = 0;
};

/// Box with half sizes `half` along the columns of `axes`.  `along` runs up its third axis.
class Cuboid : public SolidShape {
 public:
  Cuboid(const Vec3f& centre, const Vec3f& half, const Mat3f& axes = Mat3f::Identity());
  double volume() const override { return 8.0 * half_.prod(); }
  ShapePoint sample(Random& random) const override;
  bool contains(const Vec3f& x) const override;
  double thickness() const override { return 2 * half_.minCoeff(); }
  int thin_directions() const override;

 private:
  Vec3f centre_, half_;
  Mat3f axes_;
};

}  // namespace pliant

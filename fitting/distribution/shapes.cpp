#include "fitting/distribution/shapes.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "gaussians/base/error.h"

namespace pliant {
namespace {

constexpr int kSteps = 64;  // of integrals along a shape
constexpr double kPi = 3.14159265358979323846;

float draw(Random& random, double low, double high) { return static_cast<float>(random.uniform(low, high)); }

float length_of(const std::vector<Vec3f>& chain) {
  float sum = 0;
  for (size_t i = 1; i < chain.size(); ++i) sum += (chain[i] - chain[i - 1]).norm();
  return sum;
}

double mean_of(const std::function<double(float)>& value) {
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) sum += value((i + 0.5f) / kSteps) / kSteps;
  return sum;
}

}  // namespace

double SolidShape::samples_at(double spacing) const {
  const int thin = thin_directions();
  return volume() / (std::pow(spacing, 3 - thin) * std::pow(std::min(spacing, thickness()), thin));
}

std::vector<Vec3f> curve(const Vec3f& start, const Vec3f& direction, float length, const Vec3f& pull, float bend) {
  constexpr int kPieces = 12;
  std::vector<Vec3f> chain = {start};
  const Vec3f from = direction.normalized();
  const Vec3f turned = pull - pull.dot(from) * from;
  const Vec3f to = turned.norm() > 1e-6f ? Vec3f(turned.normalized()) : across_axis(from, 0);
  for (int i = 0; i < kPieces; ++i) {
    const float angle = bend * (i + 0.5f) / kPieces;
    chain.push_back(chain.back() + length / kPieces * (std::cos(angle) * from + std::sin(angle) * to));
  }
  return chain;
}

CurvePlace place_on(const std::vector<Vec3f>& chain, float along) {
  CHECK(chain.size() > 1);
  const float at = std::clamp(along, 0.0f, 1.0f) * static_cast<float>(chain.size() - 1);
  const size_t i = std::min(static_cast<size_t>(at), chain.size() - 2);
  const Vec3f step = chain[i + 1] - chain[i];
  return {chain[i] + (at - static_cast<float>(i)) * step, step.normalized()};
}

Vec3f across_axis(const Vec3f& axis, float angle) {
  const Vec3f first = axis.unitOrthogonal();
  return std::cos(angle) * first + std::sin(angle) * axis.normalized().cross(first);
}

Mat3f axes_along(const Vec3f& axis) {
  Mat3f axes;
  axes.col(2) = axis.normalized();
  axes.col(0) = across_axis(axis, 0);
  axes.col(1) = axes.col(2).cross(axes.col(0));
  return axes;
}

Tube::Tube(std::vector<Vec3f> chain, float first, float last)
    : chain_(std::move(chain)), first_(first), last_(last), length_(length_of(chain_)) {}

double Tube::volume() const { return kPi * length_ * (first_ * first_ + first_ * last_ + last_ * last_) / 3; }

ShapePoint Tube::sample(Random& random) const {
  ShapePoint p;
  const float widest = std::max(first_, last_);
  do p.along = draw(random, 0, 1);
  while (random.uniform() * widest * widest > radius(p.along) * radius(p.along));
  p.across = std::sqrt(draw(random, 0, 1));
  const CurvePlace place = place_on(chain_, p.along);
  const float r = radius(p.along);
  p.position = place.position + p.across * r * across_axis(place.tangent, draw(random, 0, 2 * kPi));
  p.depth = (1 - p.across) * r;
  return p;
}

bool Tube::contains(const Vec3f& x) const {
  float nearest = INFINITY, along = 0;
  const float pieces = static_cast<float>(chain_.size() - 1);
  for (size_t i = 0; i + 1 < chain_.size(); ++i) {
    const Vec3f step = chain_[i + 1] - chain_[i];
    const float t = (x - chain_[i]).dot(step) / step.squaredNorm(), within = std::clamp(t, 0.0f, 1.0f);
    const float distance = (x - chain_[i] - within * step).norm();
    if (distance >= nearest) continue;
    nearest = distance;
    along = (static_cast<float>(i) + ((i == 0 && t < 0) || (i + 2 == chain_.size() && t > 1) ? t : within)) / pieces;
  }
  return along >= 0 && along <= 1 && nearest < radius(along);  // the ends are flat
}

Sheet::Sheet(std::vector<Vec3f> chain, const Vec3f& side, std::function<float(float)> half_width, float curl,
             float thickness)
    : chain_(std::move(chain)),
      side_(side.normalized()),
      half_width_(std::move(half_width)),
      curl_(curl),
      thickness_(thickness),
      length_(length_of(chain_)) {
  for (int i = 0; i <= kSteps; ++i) widest_ = std::max(widest_, half_width_(static_cast<float>(i) / kSteps));
}

double Sheet::volume() const {
  return 2.0 * length_ * thickness_ * mean_of([&](float along) { return half_width_(along); });
}

ShapePoint Sheet::sample(Random& random) const {
  ShapePoint p;
  do p.along = draw(random, 0, 1);
  while (random.uniform() * widest_ > half_width_(p.along));
  p.across = draw(random, -1, 1);
  const float through = draw(random, -0.5, 0.5), w = half_width_(p.along);
  const CurvePlace place = place_on(chain_, p.along);
  const Vec3f side = (side_ - side_.dot(place.tangent) * place.tangent).normalized();
  const Vec3f normal = side.cross(place.tangent);
  p.position = place.position + p.across * w * side + (curl_ * p.across * p.across * w + through * thickness_) * normal;
  p.depth = (0.5f - std::abs(through)) * thickness_;
  return p;
}

Ellipsoid::Ellipsoid(const Vec3f& centre, const Vec3f& radii, const Mat3f& axes, float wall)
    : centre_(centre),
      radii_(radii),
      axes_(axes),
      wall_(wall),
      inner_(wall > 0 ? std::max(0.0f, 1 - wall / radii.minCoeff()) : 0.0f) {}

double Ellipsoid::volume() const { return 4 * kPi / 3 * radii_.prod() * (1 - std::pow(double{inner_}, 3)); }

ShapePoint Ellipsoid::sample(Random& random) const {
  Vec3f u;
  for (float& c : u.reshaped()) c = static_cast<float>(random.normal());
  u.normalize();
  const double least = std::pow(double{inner_}, 3);
  const float r = static_cast<float>(std::cbrt(random.uniform(least, 1)));
  ShapePoint p;
  p.position = centre_ + axes_ * (r * u).cwiseProduct(radii_);
  p.along = 0.5f + 0.5f * r * u.z();
  p.across = inner_ > 0 ? (r - inner_) / (1 - inner_) : r;
  p.depth = (1 - r) * radii_.minCoeff();
  return p;
}

bool Ellipsoid::contains(const Vec3f& x) const {
  const float r = local(x).norm();
  return r < 1 && r > inner_;
}

Lathe::Lathe(const Vec3f& base, const Vec3f& axis, float height, std::function<float(float)> outer,
             std::function<float(float)> inner)
    : base_(base),
      axis_(axis.normalized()),
      first_(across_axis(axis_, 0)),
      second_(axis_.cross(first_)),
      height_(height),
      outer_(std::move(outer)),
      inner_(std::move(inner)) {
  for (int i = 0; i <= kSteps; ++i) widest_ = std::max(widest_, outer_(static_cast<float>(i) / kSteps));
  const auto ring = [&](float s) { return double{outer_(s)} * outer_(s) - double{this->inner(s)} * this->inner(s); };
  volume_ = kPi * height_ * mean_of(ring);
  thickness_ = inner_ ? mean_of([&](float s) { return outer_(s) - inner_(s); }) : std::min(height_, 2 * widest_);
}

ShapePoint Lathe::sample(Random& random) const {
  ShapePoint p;
  for (;;) {
    p.along = draw(random, 0, 1);
    const float out = outer_(p.along), in = inner(p.along);
    if (random.uniform() * widest_ * widest_ > out * out - in * in) continue;
    const float r = std::sqrt(draw(random, in * in, out * out)), angle = draw(random, 0, 2 * kPi);
    p.across = (r - in) / std::max(out - in, 1e-9f);
    p.depth = std::min(out - r, height_ * std::min(p.along, 1 - p.along));
    if (in > 0) p.depth = std::min(p.depth, r - in);
    p.position = base_ + p.along * height_ * axis_ + r * (std::cos(angle) * first_ + std::sin(angle) * second_);
    return p;
  }
}

bool Lathe::contains(const Vec3f& x) const {
  const float along = (x - base_).dot(axis_) / height_;
  if (along < 0 || along > 1) return false;
  const float r = (x - base_ - along * height_ * axis_).norm();
  return r < outer_(along) && r >= inner(along);
}

Cuboid::Cuboid(const Vec3f& centre, const Vec3f& half, const Mat3f& axes) : centre_(centre), half_(half), axes_(axes) {}

ShapePoint Cuboid::sample(Random& random) const {
  Vec3f u;
  for (float& c : u.reshaped()) c = draw(random, -1, 1);
  ShapePoint p;
  p.position = centre_ + axes_ * u.cwiseProduct(half_);
  p.along = 0.5f + 0.5f * u.z();
  p.across = u.cwiseAbs().maxCoeff();
  p.depth = ((1 - u.array().abs()) * half_.array()).minCoeff();
  return p;
}

bool Cuboid::contains(const Vec3f& x) const {
  return ((axes_.transpose() * (x - centre_)).array().abs() < half_.array()).all();
}

int Cuboid::thin_directions() const {
  Vec3f h = half_;
  std::sort(h.data(), h.data() + 3);
  return h[1] < 0.2f * h[2] ? 2 : h[0] < 0.3f * h[1] ? 1 : 0;
}

}  // namespace pliant

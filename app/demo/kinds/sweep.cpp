#include "app/demo/kinds/sweep.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "app/demo/kinds/rows.h"
#include "app/demo/kinds/triangle_tree.h"
#include "gaussians/base/error.h"

namespace pliant {
namespace {

constexpr double kFullTurn = 2 * std::numbers::pi;
constexpr double kSurfaceEdge = 0.0016;  // m, of the triangles: less than a pixel of a photo
constexpr int kCapRows = 5;              // of a rounded end

class TriangleSurface final : public AnalyticShape {
 public:
  explicit TriangleSurface(const SurfaceMap& map) : rows_(static_cast<int>(map.rows.size())), columns_(map.columns) {
    CHECK(rows_ > 2 && columns_ > 2 && map.rows.front() == 0 && map.rows.back() == 1);
    for (const double u : map.rows)
      for (int c = 0; c < columns_; ++c) mesh_.vertex.push_back(map.at(u, static_cast<double>(c) / columns_));
    connect_rows(mesh_, rows_, columns_);
    std::erase_if(mesh_.triangle, [&](const Eigen::Vector3i& t) { return area_vector(t).norm() < 1e-14; });
    set_normals();
    Eigen::AlignedBox3d box;
    for (const Vec3d& x : mesh_.vertex) box.extend(x);
    centre_ = box.center();
    for (const Vec3d& x : mesh_.vertex) radius_ = std::max(radius_, (x - centre_).norm());
    radius_ *= 1 + 1e-9;
    tree_ = TriangleTree(mesh_);
  }

  SurfaceHit intersect(const Ray& ray, double t_min, double t_max) const override {
    const TriangleTree::Hit hit = tree_.first(ray, t_min, t_max);
    if (hit.triangle < 0) return {};
    const Eigen::Vector3i& t = mesh_.triangle[hit.triangle];
    return {hit.t, ((1 - hit.b - hit.c) * mesh_.normal[t[0]] + hit.b * mesh_.normal[t[1]] + hit.c * mesh_.normal[t[2]])
                       .normalized()};
  }
  bool inside(const Vec3d& x) const override { return tree_.winding(x) > 0; }

  // Rows at equal steps of the mean meridian, points at equal steps along each row.
  std::vector<SurfacePoint> cover(double spacing, uint64_t seed) const override {
    std::vector<double> along = {0};
    for (int r = 1; r < rows_; ++r) {
      double step = 0;
      for (int c = 0; c < columns_; ++c) step += (vertex(r, c) - vertex(r - 1, c)).norm() / columns_;
      along.push_back(along.back() + step);
    }
    std::vector<SurfacePoint> points;
    cover_rows(
        steps(along.back(), spacing), seed, 1,
        [&](double row) { return steps(perimeters(row_at(along, row)).back(), spacing); },
        [&](double row, double column) {
          const double r = row_at(along, row);
          const std::vector<double> around = perimeters(r);
          points.push_back(at(r, place_in(around, column * around.back())));
        });
    return points;
  }
  TriangleMesh mesh(double) const override { return mesh_; }
  Vec3d bound_centre() const override { return centre_; }
  double bound_radius() const override { return radius_; }

 private:
  const Vec3d& vertex(int row, int column) const { return mesh_.vertex[row * columns_ + column % columns_]; }
  Vec3d area_vector(const Eigen::Vector3i& t) const {
    return (mesh_.vertex[t[1]] - mesh_.vertex[t[0]]).cross(mesh_.vertex[t[2]] - mesh_.vertex[t[0]]) / 2;
  }
  /// Mean of the triangles around a vertex, weighted by area; one for all vertices of a pole.
  void set_normals() {
    double volume = 0;
    for (const Eigen::Vector3i& t : mesh_.triangle) volume += mesh_.vertex[t[0]].dot(area_vector(t)) / 3;
    if (volume < 0)
      for (Eigen::Vector3i& t : mesh_.triangle) std::swap(t[1], t[2]);
    mesh_.normal.assign(mesh_.vertex.size(), Vec3d::Zero());
    for (const Eigen::Vector3i& t : mesh_.triangle)
      for (int k = 0; k < 3; ++k) mesh_.normal[t[k]] += area_vector(t);
    for (const int row : {0, rows_ - 1}) {
      Vec3d sum = Vec3d::Zero();
      for (int c = 0; c < columns_; ++c) sum += mesh_.normal[row * columns_ + c];
      for (int c = 0; c < columns_; ++c) mesh_.normal[row * columns_ + c] = sum;
    }
    for (Vec3d& n : mesh_.normal) n.normalize();
  }
  /// Fractional index of `value` in an ascending list.
  static double place_in(const std::vector<double>& list, double value) {
    const auto above = std::upper_bound(list.begin(), list.end(), value);
    const size_t i = std::clamp<size_t>(above - list.begin(), 1, list.size() - 1) - 1;
    const double step = list[i + 1] - list[i];
    return static_cast<double>(i) + (step > 0 ? std::clamp((value - list[i]) / step, 0.0, 1.0) : 0.0);
  }
  double row_at(const std::vector<double>& along, double share) const { return place_in(along, share * along.back()); }
  /// Lengths from column 0 to each next one in a row between two rows of vertices.
  std::vector<double> perimeters(double row) const {
    const int r = std::min(static_cast<int>(row), rows_ - 2);
    const double f = row - r;
    std::vector<double> length = {0};
    for (int c = 0; c < columns_; ++c) {
      const Vec3d a = vertex(r, c) + f * (vertex(r + 1, c) - vertex(r, c)),
                  b = vertex(r, c + 1) + f * (vertex(r + 1, c + 1) - vertex(r, c + 1));
      length.push_back(length.back() + (b - a).norm());
    }
    return length;
  }
  /// The point of the triangle that lies there.
  SurfacePoint at(double row, double column) const {
    const int r = std::min(static_cast<int>(row), rows_ - 2), c = std::min(static_cast<int>(column), columns_ - 1);
    const double f = row - r, g = column - c;
    // Corners as connect_rows() splits them: the diagonal runs from (0, 1) to (1, 0).
    const int near = r * columns_ + c, side = r * columns_ + (c + 1) % columns_, far = near + columns_,
              both = side + columns_;
    const bool first = f + g <= 1;
    const int a = first ? near : both, b = side, d = far;
    const double wb = first ? g : 1 - f, wd = first ? f : 1 - g, wa = 1 - wb - wd;
    return {wa * mesh_.vertex[a] + wb * mesh_.vertex[b] + wd * mesh_.vertex[d],
            (wa * mesh_.normal[a] + wb * mesh_.normal[b] + wd * mesh_.normal[d]).normalized()};
  }

  int rows_, columns_;
  TriangleMesh mesh_;
  TriangleTree tree_;
  Vec3d centre_ = Vec3d::Zero();
  double radius_ = 0;
};

double signed_power(double x, double p) { return std::copysign(std::pow(std::abs(x), p), x); }

/// A spine by its length, with directions of width that are carried along without twist.
class Spine {
 public:
  Spine(const std::vector<Vec3d>& points, const Vec3d& side) {
    CHECK(points.size() > 1);
    std::vector<double> at = {0};
    for (size_t i = 1; i < points.size(); ++i) at.push_back(at.back() + (points[i] - points[i - 1]).norm());
    length_ = at.back();
    const int pieces = std::max(24, static_cast<int>(std::ceil(length_ / kSurfaceEdge)));
    size_t k = 0;
    for (int i = 0; i <= pieces; ++i) {
      const double s = length_ * i / pieces;
      while (k + 2 < points.size() && at[k + 1] < s) ++k;
      point_.push_back(points[k] + (s - at[k]) / (at[k + 1] - at[k]) * (points[k + 1] - points[k]));
    }
    // Corners of the chain are rounded, ends stay.
    const int rounds = static_cast<int>(pieces / points.size());
    for (int round = 0; round < rounds; ++round) {
      std::vector<Vec3d> smooth = point_;
      for (int i = 1; i < pieces; ++i) smooth[i] = 0.25 * (point_[i - 1] + 2 * point_[i] + point_[i + 1]);
      point_ = smooth;
    }
    Vec3d carried = side;
    for (int i = 0; i <= pieces; ++i) {
      const Vec3d tangent = (point_[std::min(i + 1, pieces)] - point_[std::max(i - 1, 0)]).normalized();
      carried = (carried - carried.dot(tangent) * tangent).normalized();
      side_.push_back(carried);
      normal_.push_back(tangent.cross(carried));
    }
  }
  double length() const { return length_; }
  /// Point, side and normal at the share u of the length.
  void at(double u, Vec3d& x, Vec3d& side, Vec3d& normal) const {
    const double place = u * static_cast<double>(point_.size() - 1);
    const size_t i = std::min(static_cast<size_t>(place), point_.size() - 2);
    const double f = place - static_cast<double>(i);
    x = point_[i] + f * (point_[i + 1] - point_[i]);
    side = side_[i] + f * (side_[i + 1] - side_[i]);
    normal = normal_[i] + f * (normal_[i + 1] - normal_[i]);
  }

 private:
  double length_ = 0;
  std::vector<Vec3d> point_, side_, normal_;
};

}  // namespace

std::unique_ptr<AnalyticShape> make_surface(const SurfaceMap& map) { return std::make_unique<TriangleSurface>(map); }

std::unique_ptr<AnalyticShape> make_sweep(const Sweep& sweep) {
  const bool round = sweep.half_thickness == 0;
  const auto spine = std::make_shared<Spine>(sweep.spine, sweep.side);
  const auto cap_length = [&](double end) {
    const double half = sweep.half(end);
    return std::min(0.4, (round ? half : std::min(half, sweep.half_thickness)) / spine->length());
  };
  const double first = cap_length(0), last = cap_length(1);
  SurfaceMap map;
  for (int i = 0; i < kCapRows; ++i) map.rows.push_back(first * (1 - std::cos(kFullTurn / 4 * i / kCapRows)));
  const int body = std::max(2, static_cast<int>(std::ceil((1 - first - last) * spine->length() / kSurfaceEdge)));
  for (int i = 0; i <= body; ++i) map.rows.push_back(first + (1 - first - last) * i / body);
  for (int i = kCapRows - 1; i >= 0; --i) map.rows.push_back(1 - last * (1 - std::cos(kFullTurn / 4 * i / kCapRows)));
  double widest = 0;
  for (const double u : map.rows) widest = std::max(widest, sweep.half(u));
  const double perimeter = round ? kFullTurn * widest : 4 * (widest + sweep.half_thickness);
  map.columns = std::max(12, static_cast<int>(std::ceil(perimeter / kSurfaceEdge)));
  map.at = [=, half = sweep.half, lift = sweep.lift, thickness = sweep.half_thickness](double u, double v) {
    // What the rounded ends leave of the section.
    const double from_end = std::min(first > 0 ? u / first : 1.0, last > 0 ? (1 - u) / last : 1.0);
    const double share = from_end >= 1 ? 1.0 : std::sqrt(std::max(0.0, from_end * (2 - from_end)));
    const double cosine = std::cos(kFullTurn * v), sine = std::sin(kFullTurn * v), power = round ? 1.0 : 0.5;
    const double across = signed_power(cosine, power), over = signed_power(sine, power);
    Vec3d x, side, normal;
    spine->at(u, x, side, normal);
    const double wide = half(u), thick = round ? wide : std::min(thickness, wide);
    const double lifted = lift ? lift(u, share * across) : 0.0;
    return Vec3d(x + share * across * wide * side + (share * over * thick + lifted) * normal);
  };
  return make_surface(map);
}

std::unique_ptr<AnalyticShape> make_rod(const std::vector<Vec3d>& spine, double first, double last) {
  Sweep sweep;
  sweep.spine = spine;
  sweep.side = (spine[1] - spine[0]).unitOrthogonal();
  sweep.half = [=](double u) { return first + (last - first) * u; };
  return make_sweep(sweep);
}

std::vector<Vec3d> spine_of(const std::vector<Vec3f>& chain) {
  std::vector<Vec3d> spine;
  for (const Vec3f& x : chain) spine.push_back(x.cast<double>());
  return spine;
}

}  // namespace pliant

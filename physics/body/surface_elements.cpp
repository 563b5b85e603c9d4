#include "physics/body/surface_elements.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <utility>

#include "physics/mpm/bspline.h"

namespace pliant {
namespace {

constexpr double kUneven = 0.15;  // per cell; less is noise of the particles' places, inside of the body
constexpr double kFilled = 0.4;  // share of a cell from which on it counts as filled

/// Numbers on the integer lattice, zero where none was stored.
class Lattice {
 public:
  double& at(int i, int j, int k) { return value_[key(i, j, k)]; }
  double get(int i, int j, int k) const {
    const auto found = value_.find(key(i, j, k));
    return found == value_.end() ? 0.0 : found->second;
  }

 private:
  static uint64_t key(int i, int j, int k) {
    constexpr uint64_t kMask = (1 << 21) - 1;
    return (static_cast<uint64_t>(i) & kMask) << 42 | (static_cast<uint64_t>(j) & kMask) << 21 |
           (static_cast<uint64_t>(k) & kMask);
  }
  std::unordered_map<uint64_t, double> value_;
};

}  // namespace

template <class T>
std::vector<Vec3<T>> surface_elements(const BasicParticles<T>& particles, double dx) {
  Lattice share;
  const size_t n = particles.size();
  const auto for_stencil = [&](size_t i, auto&& visit) {
    const Vec3d x = particles.position[i].template cast<double>() / dx;
    const Spline<double> s[3] = {Spline<double>(x[0]), Spline<double>(x[1]), Spline<double>(x[2])};
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b)
        for (int c = 0; c < 3; ++c) visit(s, a, b, c);
  };
  for (size_t i = 0; i < n; ++i) {
    const double filled = particles.volume[i] / (dx * dx * dx);
    for_stencil(i, [&](const Spline<double>* s, int a, int b, int c) {
      share.at(s[0].base + a, s[1].base + b, s[2].base + c) += filled * s[0].weight[a] * s[1].weight[b] * s[2].weight[c];
    });
  }
  std::vector<Vec3<T>> out(n, Vec3<T>::Zero());
  for (size_t i = 0; i < n; ++i) {
    Vec3d gradient = Vec3d::Zero();
    double filled = 0;
    for_stencil(i, [&](const Spline<double>* s, int a, int b, int c) {
      const int o[3] = {a, b, c};
      double w[3], d[3];
      for (int k = 0; k < 3; ++k) {
        const double u = s[k].offset;
        const double slope[3] = {-(1.5 - u), 2 * (1 - u), u - 0.5};  // dN/dx; with 1 - u from the middle node
        w[k] = s[k].weight[o[k]], d[k] = slope[o[k]];
      }
      const double here = share.get(s[0].base + a, s[1].base + b, s[2].base + c);
      filled += here * w[0] * w[1] * w[2];
      gradient += here * Vec3d(d[0] * w[1] * w[2], w[0] * d[1] * w[2], w[0] * w[1] * d[2]);
    });
    if (!(gradient.norm() > kUneven * filled)) continue;
    // Across a face, gradient over share sums to ln 2: from 1 inside to 1/2 on the face; edges cancel out of it.
    out[i] = (-particles.volume[i] / (dx * 0.693147180559945 * filled) * gradient).template cast<T>();
  }
  return out;
}

template <class T>
std::vector<uint8_t> thin_parts(const std::vector<Vec3<T>>& position, const std::vector<T>& volume, double dx) {
  const size_t n = position.size();
  std::vector<uint8_t> thin(n, 1);
  if (n == 0) return thin;
  // Cells are counted from the particles' lowest corner, so that an aligned body fills whole cells.
  Vec3d low = Vec3d::Constant(INFINITY);
  for (const Vec3<T>& x : position) low = low.cwiseMin(x.template cast<double>());
  const double side = std::cbrt(static_cast<double>(volume[0]));
  low -= Vec3d::Constant(0.5 * side);
  const auto cell_of = [&](size_t i, int a) {
    return static_cast<int>(std::clamp(std::floor((position[i][a] - low[a]) / dx), 0.0, 1e6));
  };
  Lattice filled, tried, thick;
  for (size_t i = 0; i < n; ++i) filled.at(cell_of(i, 0), cell_of(i, 1), cell_of(i, 2)) += volume[i] / (dx * dx * dx);
  const auto for_cube = [](int i, int j, int k, auto&& visit) {
    for (int a = -1; a <= 1; ++a)
      for (int b = -1; b <= 1; ++b)
        for (int c = -1; c <= 1; ++c) visit(i + a, j + b, k + c);
  };
  for (size_t p = 0; p < n; ++p) {
    const int i = cell_of(p, 0), j = cell_of(p, 1), k = cell_of(p, 2);
    if (std::exchange(tried.at(i, j, k), 1) == 1) continue;
    bool whole = true;
    for_cube(i, j, k, [&](int a, int b, int c) { whole &= filled.get(a, b, c) >= kFilled; });
    if (!whole) continue;
    for_cube(i, j, k, [&](int a, int b, int c) { thick.at(a, b, c) = 1; });
  }
  for (size_t p = 0; p < n; ++p) {
    const int i = cell_of(p, 0), j = cell_of(p, 1), k = cell_of(p, 2);
    bool is_thick = thick.get(i, j, k) > 0;
    // A face that crosses a layer of cells leaves slivers, which belong to the cells beside them.
    if (!is_thick && filled.get(i, j, k) < kFilled)
      for_cube(i, j, k, [&](int a, int b, int c) { is_thick |= thick.get(a, b, c) > 0; });
    thin[p] = !is_thick;
  }
  return thin;
}

template std::vector<Vec3<float>> surface_elements(const BasicParticles<float>&, double);
template std::vector<Vec3<double>> surface_elements(const BasicParticles<double>&, double);
template std::vector<uint8_t> thin_parts(const std::vector<Vec3<float>>&, const std::vector<float>&, double);
template std::vector<uint8_t> thin_parts(const std::vector<Vec3<double>>&, const std::vector<double>&, double);

}  // namespace pliant

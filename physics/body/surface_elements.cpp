#include "physics/body/surface_elements.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "gaussians/base/nearest.h"
#include "physics/mpm/bspline.h"

namespace pliant {
namespace {

constexpr double kUneven = 0.15;  // per cell; less is noise of the particles' places, inside of the body
// Slope per cell over share from which on a particle is one of the outermost, about half a cell deep at most; cells
// below them at which the middle of a thick part begins; and cells around that middle, to a corner of the part.
constexpr double kOuter = 0.6, kDeep = 0.9, kAround = 2.6;
// What makes lengths sum to the area of flat faces of parts from 0.75 cells on, over faces, grids and layers; and
// cells^2 that count as spread of a single layer, whose sides cannot be told apart.
constexpr double kOfFace = 1.38, kLeastSpread = 0.008;

/// Values on the integer lattice, zero where none was stored.
template <class Value>
class Lattice {
 public:
  Value& at(int i, int j, int k) { return value_[key(i, j, k)]; }
  Value get(int i, int j, int k) const {
    const auto found = value_.find(key(i, j, k));
    return found == value_.end() ? Value() : found->second;
  }

 private:
  static uint64_t key(int i, int j, int k) {
    constexpr uint64_t kMask = (1 << 21) - 1;
    return (static_cast<uint64_t>(i) & kMask) << 42 | (static_cast<uint64_t>(j) & kMask) << 21 |
           (static_cast<uint64_t>(k) & kMask);
  }
  std::unordered_map<uint64_t, Value> value_;
};

/// Volume around a point, and its first and second moments about it, in cells.
struct Moments {
  double volume = 0;
  Vec3d first = Vec3d::Zero();
  Mat3d second = Mat3d::Zero();

  /// Adds w times `other`, whose point lies at `arm` from this one's.
  void add(double w, const Moments& other, const Vec3d& arm) {
    volume += w * other.volume;
    first += w * (other.first + other.volume * arm);
    second += w * (other.second + other.first * arm.transpose() + arm * other.first.transpose() +
                   other.volume * arm * arm.transpose());
  }
};

/// Calls visit(splines, a, b, c) for the 27 nodes around x [cells].
template <class Visit>
void for_stencil(const Vec3d& x, Visit&& visit) {
  const Spline<double> s[3] = {Spline<double>(x[0]), Spline<double>(x[1]), Spline<double>(x[2])};
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b)
      for (int c = 0; c < 3; ++c) visit(s, a, b, c);
}

/// [N] length per cell of the gradient of the logarithm of the share of space that the particles fill, 0 where it is
/// noise.
template <class T>
std::vector<double> slopes(const BasicParticles<T>& particles, double dx) {
  Lattice<double> share;
  const size_t n = particles.size();
  for (size_t i = 0; i < n; ++i) {
    const double filled = particles.volume[i] / (dx * dx * dx);
    for_stencil(particles.position[i].template cast<double>() / dx, [&](const Spline<double>* s, int a, int b, int c) {
      share.at(s[0].base + a, s[1].base + b, s[2].base + c) +=
          filled * s[0].weight[a] * s[1].weight[b] * s[2].weight[c];
    });
  }
  std::vector<double> out(n, 0.0);
  for (size_t i = 0; i < n; ++i) {
    Vec3d gradient = Vec3d::Zero();
    double filled = 0;
    for_stencil(particles.position[i].template cast<double>() / dx, [&](const Spline<double>* s, int a, int b, int c) {
      const int o[3] = {a, b, c};
      double w[3], d[3];
      for (int k = 0; k < 3; ++k) {
        const double u = s[k].offset;
        const double slope[3] = {-(1.5 - u), 2 * (1 - u), u - 0.5};  // dN/dx; with 1 - u from the middle node
        w[k] = s[k].weight[o[k]];
        d[k] = slope[o[k]];
      }
      const double here = share.get(s[0].base + a, s[1].base + b, s[2].base + c);
      filled += here * w[0] * w[1] * w[2];
      gradient += here * Vec3d(d[0] * w[1] * w[2], w[0] * d[1] * w[2], w[0] * w[1] * d[2]);
    });
    if (gradient.norm() > kUneven * filled) out[i] = gradient.norm() / filled;
  }
  return out;
}

}  // namespace

template <class T>
std::vector<Vec3<T>> surface_elements(const BasicParticles<T>& particles, double dx) {
  Lattice<Moments> around;
  const size_t n = particles.size();
  const auto weight = [](const Spline<double>* s, int a, int b, int c) {
    return s[0].weight[a] * s[1].weight[b] * s[2].weight[c];
  };
  const auto arm = [](const Spline<double>* s, int a, int b, int c) {  // from the particle to the node, cells
    return Vec3d(a - s[0].offset, b - s[1].offset, c - s[2].offset);
  };
  for (size_t i = 0; i < n; ++i) {
    Moments own;
    own.volume = particles.volume[i] / (dx * dx * dx);
    for_stencil(particles.position[i].template cast<double>() / dx, [&](const Spline<double>* s, int a, int b, int c) {
      around.at(s[0].base + a, s[1].base + b, s[2].base + c).add(weight(s, a, b, c), own, -arm(s, a, b, c));
    });
  }
  std::vector<Vec3<T>> out(n, Vec3<T>::Zero());
  for (size_t i = 0; i < n; ++i) {
    Moments all;
    for_stencil(particles.position[i].template cast<double>() / dx, [&](const Spline<double>* s, int a, int b, int c) {
      const Moments node = around.get(s[0].base + a, s[1].base + b, s[2].base + c);
      all.add(weight(s, a, b, c), node, arm(s, a, b, c));
    });
    const Vec3d mean = all.first / all.volume;
    const Mat3d spread = all.second / all.volume - mean * mean.transpose() + kLeastSpread * Mat3d::Identity();
    // Across a plate of uniform material, whose spread is its thickness^2 / 12, this grows from its middle to its faces
    // as the volume of a side asks for; in a thick part the spread is that of the splines, and edges add theirs.
    const Vec3d inward = spread.inverse() * mean;
    if (!(inward.norm() > kUneven)) continue;
    out[i] = (-particles.volume[i] / (dx * kOfFace) * inward).template cast<T>();
  }
  return out;
}

template <class T>
std::vector<uint8_t> thin_parts(const BasicParticles<T>& particles, double dx) {
  // The outermost particles, those deep below them, and what lies around these.
  const size_t n = particles.size();
  const std::vector<double> slope = slopes(particles, dx);
  std::vector<Vec3f> all, outer, deep;
  for (size_t i = 0; i < n; ++i) {
    all.push_back(particles.position[i].template cast<float>());
    if (slope[i] > kOuter) outer.push_back(all.back());
  }
  if (outer.empty()) return std::vector<uint8_t>(n, 0);
  std::vector<NearestPoints::Hit> hit;
  const NearestPoints skin(outer);
  for (const Vec3f& x : all) {
    skin.query(x, 1, hit);
    if (hit[0].distance >= kDeep * dx) deep.push_back(x);
  }
  if (deep.empty()) return std::vector<uint8_t>(n, 1);
  std::vector<uint8_t> thin(n);
  const NearestPoints core(deep);
  for (size_t i = 0; i < n; ++i) {
    core.query(all[i], 1, hit);
    thin[i] = hit[0].distance > kAround * dx;
  }
  return thin;
}

template std::vector<Vec3<float>> surface_elements(const BasicParticles<float>&, double);
template std::vector<Vec3<double>> surface_elements(const BasicParticles<double>&, double);
template std::vector<uint8_t> thin_parts(const BasicParticles<float>&, double);
template std::vector<uint8_t> thin_parts(const BasicParticles<double>&, double);

}  // namespace pliant

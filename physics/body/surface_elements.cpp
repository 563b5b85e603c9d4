#include "physics/body/surface_elements.h"

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
      share.at(s[0].base + a, s[1].base + b, s[2].base + c) +=
          filled * s[0].weight[a] * s[1].weight[b] * s[2].weight[c];
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
        w[k] = s[k].weight[o[k]];
        d[k] = slope[o[k]];
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
std::vector<uint8_t> thin_parts(const BasicParticles<T>& particles, double dx) {
  // The outermost particles, those deep below them, and what lies around these.
  const size_t n = particles.size();
  const std::vector<Vec3<T>> elements = surface_elements(particles, dx);
  std::vector<Vec3f> all, outer, deep;
  for (size_t i = 0; i < n; ++i) {
    all.push_back(particles.position[i].template cast<float>());
    if (elements[i].norm() * dx * 0.693 > kOuter * particles.volume[i]) outer.push_back(all.back());
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

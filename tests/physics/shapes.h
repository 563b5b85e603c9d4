#pragma once

#include <cmath>

#include "gaussians/base/random.h"
#include "physics/body/samples.h"
#include "physics/mpm/particles.h"

namespace pliant::fixture {

/// Particles of equal volume that fill the points of the box [0, size] for which inside(x), `per_cell`^3 to a cell;
/// jitter in [0, 1] moves them inside their sub-cells.
template <class T, class Inside>
BasicParticles<T> fill_shape(const Vec3d& size, double dx, int per_cell, double jitter, double young, double poisson,
                             double density, Inside&& inside) {
  BasicParticles<T> p;
  const double h = dx / per_cell;
  uint64_t element = 0;
  for (int i = 0; i < std::lround(size.x() / h); ++i)
    for (int j = 0; j < std::lround(size.y() / h); ++j)
      for (int k = 0; k < std::lround(size.z() / h); ++k) {
        Random random(7, element++);
        Vec3d x;
        const int at[3] = {i, j, k};
        for (int a = 0; a < 3; ++a) x[a] = (at[a] + 0.5 + jitter * (random.uniform() - 0.5)) * h;
        if (inside(x)) p.position.push_back(x.cast<T>());
      }
  const size_t n = p.position.size();
  p.volume.assign(n, static_cast<T>(h * h * h));
  p.mass.assign(n, static_cast<T>(h * h * h * density));
  p.young.assign(n, static_cast<T>(young));
  p.poisson.assign(n, static_cast<T>(poisson));
  p.cell_size = static_cast<T>(dx);
  return p;
}

template <class T>
BasicParticles<T> block(const Vec3d& size, double dx, double jitter = 1.0, double young = 1e4, double poisson = 0.3,
                        double density = 1000) {
  return fill_shape<T>(size, dx, 2, jitter, young, poisson, density, [](const Vec3d&) { return true; });
}

/// Dense stratified samples of a solid inside the box [0, size].
template <class Inside>
SolidSamples solid(const Vec3d& size, double spacing, Inside&& inside) {
  const BasicParticles<double> p = fill_shape<double>(size, spacing, 1, 1.0, 1, 0, 1, inside);
  SolidSamples s;
  for (const Vec3d& x : p.position) s.position.push_back(x.cast<float>());
  s.volume.assign(p.size(), static_cast<float>(spacing * spacing * spacing));
  s.spacing = static_cast<float>(spacing);
  return s;
}

}  // namespace pliant::fixture

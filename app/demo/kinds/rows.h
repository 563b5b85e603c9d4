#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "app/demo/kinds/shapes.h"
#include "gaussians/base/random.h"

namespace pliant {

constexpr double kTwoPi = 2 * std::numbers::pi;  ///< angle of a whole turn

/// Spreads points over a strip of rows: row k of `rows` has `count(k)` points, and each is placed by
/// place(row parameter in (0, 1), column parameter in [0, 1)).  Rows are staggered by half a step and everything is
/// jittered by a tenth of a step, so that no grid shows.
template <class Count, class Place>
void cover_rows(int rows, uint64_t seed, uint64_t stream, Count&& count, Place&& place) {
  for (int k = 0; k < rows; ++k) {
    const int n = count((k + 0.5) / rows);
    for (int i = 0; i < n; ++i) {
      Random random(seed, stream * 100003 + static_cast<uint64_t>(k), static_cast<uint64_t>(i));
      const double row = (k + 0.5 + 0.2 * (random.uniform() - 0.5)) / rows;
      const double column = (i + (k % 2 ? 0.25 : 0.75) + 0.2 * (random.uniform() - 0.5)) / n;
      place(row, column);
    }
  }
}

/// Steps of about `spacing` along a length, at least one.
inline int steps(double length, double spacing) { return std::max(1, static_cast<int>(std::lround(length / spacing))); }

/// Triangles of a closed-around grid of rows x columns vertices.
inline void connect_rows(TriangleMesh& mesh, int rows, int columns) {
  for (int r = 0; r + 1 < rows; ++r)
    for (int c = 0; c < columns; ++c) {
      const int a = r * columns + c, b = r * columns + (c + 1) % columns;
      mesh.triangle.emplace_back(a, b, a + columns);
      mesh.triangle.emplace_back(b, b + columns, a + columns);
    }
}

}  // namespace pliant

#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "app/demo/kinds/shapes.h"

namespace pliant {

/// A closed surface x(u, v): u in [0, 1] from one pole to the other, v in [0, 1) around, anticlockwise seen against the
/// direction of growing u.
struct SurfaceMap {
  std::function<Vec3d(double u, double v)> at;
  std::vector<double> rows;  ///< ascending u of the rows of vertices, from 0 to 1
  int columns = 0;
};
/// The triangles between the vertices of the map, with normals that are interpolated.
std::unique_ptr<AnalyticShape> make_surface(const SurfaceMap& map);

/// A section that runs along a spine: rods, leaves, petals, sheets, coils.
struct Sweep {
  std::vector<Vec3d> spine;              ///< at least two points
  Vec3d side = Vec3d::UnitY();           ///< direction of the width at the start; carried along without twist
  std::function<double(double u)> half;  ///< half width at the share u of the spine's length
  double half_thickness = 0;             ///< 0: as the half width, so that the section is round
  /// How far the middle of the section is moved along its normal (tangent x side), from u and the place across it in
  /// -1..1; nothing: not at all.
  std::function<double(double u, double across)> lift = {};
};
/// Both ends are rounded.  Sections are ellipses where they are round, else nearly rectangles: |a|^4 + |b|^4 = 1.
std::unique_ptr<AnalyticShape> make_sweep(const Sweep& sweep);

/// A sweep with round sections from radius `first` to `last`.
std::unique_ptr<AnalyticShape> make_rod(const std::vector<Vec3d>& spine, double first, double last);

/// Points of a chain in double precision.
std::vector<Vec3d> spine_of(const std::vector<Vec3f>& chain);

}  // namespace pliant

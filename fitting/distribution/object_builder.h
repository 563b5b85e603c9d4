#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "fitting/distribution/material_object.h"
#include "fitting/distribution/shapes.h"
#include "gaussians/base/random.h"

namespace pliant {

/// What a procedural object is made of at one place.
struct Substance {
  double young = 1e6;    ///< Pa
  double poisson = 0.3;  ///< 0..0.49
  double density = 1e3;  ///< kg/m^3
};

/// Puts shapes together into an object whose material is known everywhere.  A place in several shapes belongs to the
/// one that was added last.  The object stands on z = 0 or above it, up is z.
class ObjectBuilder {
 public:
  using Colouring = std::function<Vec3f(const ShapePoint&)>;
  using Filling = std::function<Substance(const ShapePoint&)>;

  ObjectBuilder(std::string family, uint64_t seed);

  double between(double low, double high) { return random_.uniform(low, high); }
  double log_between(double low, double high);  ///< uniform in the logarithm
  bool chance(double share) { return random_.uniform() < share; }
  int count(int low, int high);                          ///< uniform, both included
  Vec3f tint(const Vec3f& colour, double spread = 0.1);  ///< a colour near this one
  Vec3f any_colour();
  Vec3f outward(double rise);  ///< unit vector to any side, `rise` = its z
  int new_part() { return parts_++; }

  template <class Shape>
  void add(Shape shape, int part, Colouring colour, Filling filling) {
    pieces_.push_back({std::make_unique<Shape>(std::move(shape)), part, std::move(colour), std::move(filling)});
  }
  template <class Shape>
  void add(Shape shape, int part, const Vec3f& colour, const Substance& substance) {
    add(
        std::move(shape), part, [colour](const ShapePoint&) { return colour; },
        [substance](const ShapePoint&) { return substance; });
  }

  /// 800 to 2000 samples, as interior_fill.h makes them: one volume each, thin parts with their thickness.  What no
  /// rule says varies too: material by a smooth random field of .03 to .15 decades and by the sample, brightness and
  /// colours; in a quarter of the objects every part gets a random colour, because things are painted and dyed; parts
  /// are unknown in a third and merged in some, as segmentations are.
  MaterialObject build();

 private:
  struct Piece {
    std::unique_ptr<SolidShape> shape;
    int part;
    Colouring colour;
    Filling filling;
  };
  double spacing_for(double samples) const;

  std::string family_;
  Random random_;
  std::vector<Piece> pieces_;
  int parts_ = 0;
};

}  // namespace pliant

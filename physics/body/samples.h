#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "gaussians/base/types.h"

namespace pliant {

/// Points that fill a solid, each standing for a piece of its volume, in the units of the cloud they came from.
struct SolidSamples {
  std::vector<Vec3f> position;   ///< [M, 3]
  std::vector<float> volume;     ///< [M] units^3; sums to the volume of the solid
  std::vector<float> thickness;  ///< [M] thickness of the sheet or rod that a sample lies in; 0 = thick, or not known
  std::vector<uint8_t> rod;      ///< [M] 1 = that part is a rod, 0 = a sheet; empty = not yet known
  float spacing = 0;             ///< mean distance of neighbouring samples

  size_t size() const { return position.size(); }
  double total_volume() const;
  /// Samples at `indices`, in that order.
  SolidSamples select(std::span<const int> indices) const;
};

}  // namespace pliant

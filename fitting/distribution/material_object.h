#pragma once

#include <string>
#include <vector>

#include "physics/body/samples.h"

namespace pliant {

/// An object whose material is known everywhere: what the distribution network learns from and is judged by.
struct MaterialObject {
  std::string family;          ///< kind of object; training and judging never share one
  SolidSamples samples;        ///< [M] in metres, with the thickness of thin parts
  std::vector<Vec3f> colour;   ///< [M, 3] diffuse sRGB in 0..1 of the nearest surface
  std::vector<int> part;       ///< [M] part that a segmentation would tell apart; empty = none are known
  Vec3f up = Vec3f::UnitZ();   ///< against gravity; the object stands or hangs along it
  std::vector<float> young;    ///< [M] Pa
  std::vector<float> poisson;  ///< [M]
  std::vector<float> density;  ///< [M] kg/m^3
};

}  // namespace pliant

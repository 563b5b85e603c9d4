#pragma once

#include <Eigen/Core>
#include <vector>

#include "gaussians/base/types.h"

namespace pliant {

inline const Vec3d kPotColours[] = {{0.66, 0.36, 0.25}, {0.36, 0.46, 0.58}, {0.60, 0.52, 0.42}};
inline const Vec3d kSoilColour(0.30, 0.21, 0.15);

/// Outer wall, lip and inner wall down to the soil, for make_lathe(); metres.
std::vector<Eigen::Vector2d> pot_profile(double radius, double height, double soil);
/// Soil that rises a little towards the stem.
std::vector<Eigen::Vector2d> soil_profile(double radius, double soil, double stem_radius);

}  // namespace pliant

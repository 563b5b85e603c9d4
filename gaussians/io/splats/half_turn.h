#pragma once

#include "gaussians/base/gaussian_cloud.h"

namespace pliant {

/// Turns the cloud by 180 degrees around a world axis (0 = x, 1 = y, 2 = z): positions, rotations and harmonics.  It
/// is its own inverse, and it takes x right, y up, z back to x right, y down, z forward for the x axis.
void turn_half(GaussianCloud& cloud, int axis);

/// Turns the cloud to x right, y up, z back: by half a turn from the axes of 3DGS PLY, by a quarter from a world whose
/// z is up.
void turn_y_up(GaussianCloud& cloud, bool z_is_up);

}  // namespace pliant

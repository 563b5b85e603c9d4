#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "gaussians/base/types.h"

namespace pliant {

/// velocity.h5: how a motion starts, at points of the body.
struct VelocityFile {
  std::vector<Vec3f> velocity;      ///< [M, 3] m/s
  std::vector<Vec3f> displacement;  ///< [M, 3] m, from the shape at rest
  std::vector<Vec3f> position;  ///< [M, 3] scene units, at rest; empty: the driving particles of particles.h5 beside it
  std::vector<Mat3f> F, C;      ///< [M, 3, 3] deformation gradient; affine velocity field 1/s
  double time = 0;              ///< s on the reference's clock
  double damping_time = 0;      ///< s, fitted along with it, beside what the transfers of its grid take; 0 = none
  double whole_damping_time = 0;  ///< s, with that: the object's own, on any grid; 0 = not known
  std::string source;             ///< where the values come from, a phrase
};

/// Group /driving {velocity, displacement, F, C, position}.
void write_velocity(const std::filesystem::path& file, const VelocityFile& velocity,
                    const std::string& provenance_json);
/// Also checks that values are finite and that all parts have equally many rows.
VelocityFile read_velocity(const std::filesystem::path& file);

}  // namespace pliant

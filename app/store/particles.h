#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "gaussians/base/types.h"

namespace pliant {

/// particles.h5: the solid samples of an object and the driving particles that MPM moves, in scene units.
struct ParticleFile {
  std::vector<Vec3f> solid_position;    ///< [S, 3]
  std::vector<float> solid_volume;      ///< [S] units^3
  std::vector<int> solid_driver;        ///< [S] index into driving_*, -1 = rigid, not simulated
  std::vector<int> solid_follows;       ///< [S] the simulated sample that a sample of a disconnected piece moves with,
                                        ///< -1 = none; empty = there are no such pieces
  std::vector<Vec3f> driving_position;  ///< [M, 3] at rest
  std::vector<float> driving_volume;    ///< [M] units^3
  std::vector<float>
      driving_thickness;             ///< [M] units, of the sheet or rod a driver lies in; 0 = thick; empty = all thick
  std::vector<uint8_t> driving_rod;  ///< [M] 1 = that part is a rod, 0 = a sheet; empty like the thickness
  std::vector<std::array<int, 2>> driving_links;  ///< [L] ascending pairs of drivers that hang together; empty = all
                                                  ///< that share a cell do
  double cell_size = 0;                           ///< grid spacing, scene units
  double metres_per_unit = 1;
  std::string pinned_json = "[]";  ///< regions that hold the object, as in interactions.json
};

/// Groups /solid {position, volume, driver, follows where it is not empty} and /driving {position, volume, thickness,
/// rod, links}.
void write_particles(const std::filesystem::path& file, const ParticleFile& particles,
                     const std::string& provenance_json);
/// Also checks that values are finite and that drivers and followed samples exist.
ParticleFile read_particles(const std::filesystem::path& file);

}  // namespace pliant

#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "physics/body/samples.h"

namespace pliant {

/// solid.h5: the solid samples of an object, in scene units, before anything says what it is made of.
struct SolidFile {
  SolidSamples samples;
  std::vector<uint8_t> simulated;  ///< [S] 1 = free to move, or near to what is; 0 = rigid
  double volume = 0;               ///< of the whole solid, units^3
  std::string pinned_json = "[]";  ///< regions that hold the object, as in interactions.json
};

/// Group /solid {position, volume, thickness, rod, simulated}.
void write_solid(const std::filesystem::path& file, const SolidFile& solid, const std::string& provenance_json);
/// Also checks that values are finite and flags are 0 or 1.
SolidFile read_solid(const std::filesystem::path& file);

}  // namespace pliant

#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "physics/body/samples.h"
#include "physics/loads/region.h"

namespace pliant {

/// The particles that MPM moves.  Every solid sample belongs to one of them.
struct DrivingParticles {
  std::vector<Vec3f> position;     ///< [N, 3] centroid of the samples, in their units
  std::vector<float> volume;       ///< [N] sum over the samples
  std::vector<int> sample_driver;  ///< [M] driver of each sample
  std::vector<float> thickness;    ///< [N] of the sheet or rod a driver lies in; 0 = thick, or not known
  std::vector<uint8_t> rod;        ///< [N] 1 = that part is a rod, 0 = a sheet
  float cell_size = 0;             ///< grid spacing dx = (8 V / N)^(1/3), where thin parts count as kThinCells dx thick

  size_t size() const { return position.size(); }
};

/// Parts thinner than this many cells are simulated as if they were so thick, with their mass and their bending
/// stiffness kept (E t^3 of a sheet, E t^4 of a rod).
constexpr float kThinCells = 0.75f;
/// Thinner parts than this share of it stay so stiff that they spring back.
constexpr double kThinnestPart = 0.05;

struct DriverOptions {
  int count = 8000;  ///< clusters; lowered to the number of samples when there are fewer; thin parts get more where
                     ///< they would be farther apart than hangs together
  uint64_t seed = 0;
  int iterations = 10;  ///< of Lloyd's algorithm
};

/// K-means of the samples, weighted by volume (Lloyd 1982), from centres drawn along a space-filling order.  No
/// driver is empty.  Drivers of parts thinner than kThinCells dx are spread across that thickness, three for one in
/// rods, so that the grid feels them bend.  Deterministic for a seed, for any number of threads.  Throws Error{kUsage}
/// without samples.
DrivingParticles kmeans_drivers(const DriverOptions& options, const SolidSamples& samples);

/// What is simulated: samples that lie less than 3 cells inside every pinned region and less than 4 from one that is
/// free to move; others are rigid.
struct SimulatedPart {
  std::vector<int> kept;  ///< indices of the simulated samples, ascending
  float cell_size = 0;    ///< dx of `count` drivers in the simulated volume
  double volume = 0;      ///< simulated volume
};

/// dx follows from the simulated volume, which follows from dx; solved by iteration.  Regions are in the units of the
/// samples.  Throws Error{kUsage} when nothing is left to simulate.
SimulatedPart select_simulated(const SolidSamples& samples, std::span<const Region> pinned, int count);

}  // namespace pliant

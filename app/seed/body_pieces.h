#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "app/run/run_directory.h"
#include "app/simulate/motion.h"
#include "physics/body/driving_particles.h"

namespace pliant {

/// The simulated samples of a body by what hangs together.
struct BodyPieces {
  Pieces pieces;
  std::vector<int> samples;    ///< [N] indices of the samples that `pieces` numbers
  std::vector<uint8_t> held;   ///< [pieces] 1 = by a region
  std::vector<uint8_t> loose;  ///< [pieces] 1 = too small for a body of its own, and neither held by a region
  std::vector<Vec3f> centre;   ///< [pieces] scene units
  std::vector<size_t> count;   ///< [pieces] samples

  bool any_loose() const;
};

/// Pieces of what `part` simulates.  Those that hang on nothing are taken out of it: each moves as one with the nearest
/// sample that is left, see followed_samples.
BodyPieces find_body_pieces(const SolidSamples& samples, const std::vector<Region>& pins, SimulatedPart& part);

/// [samples] for those of every loose piece the sample of `part` that is nearest to the piece, -1 for others; empty
/// when no piece is loose.
std::vector<int> followed_samples(const SolidSamples& samples, const SimulatedPart& part, const BodyPieces& body);

/// Says what is loose, and what of its own body nothing holds while another piece is held, and where.
void tell_loose(const Context& context, const BodyPieces& body);
/// [{samples, volume, centre, simulated}], by falling volume; of many pieces the first 100.
nlohmann::json pieces_json(const BodyPieces& body);
/// pieces.png: the object from 8 sides, every piece in a colour.
void write_pieces(const RunDirectory& run, const GaussianCloud& object, const Eigen::Vector3d& up,
                  const SolidSamples& samples, const BodyPieces& body);

}  // namespace pliant

#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "app/store/particles.h"
#include "app/store/trajectory.h"
#include "physics/body/pieces.h"
#include "physics/loads/region.h"

namespace pliant {

constexpr float kPieceReach = 0.75f;  ///< cells between samples of one piece
constexpr double kOwnBody = 0.05;     ///< share of the volume from which on a piece that nothing holds moves by itself

/// [pieces] 1 = one of the regions holds a sample of the piece; `position`: of the samples that `pieces` numbers.
std::vector<uint8_t> held_pieces(const Pieces& pieces, const std::vector<Vec3f>& position,
                                 const std::vector<Region>& pins);
/// The largest piece that is held; the largest of all where none is.
int largest_held(const Pieces& pieces, const std::vector<Vec3f>& position, const std::vector<Region>& pins);

/// The driving particles whose motion is taken for that of an object, and which the automatic push moves.
struct ObjectTip {
  std::vector<int> particles;  ///< ascending
  bool top = true;             ///< the highest tenth; else the end that is farthest from what holds the object
};

/// The highest tenth along `up`, unless what `pins` [scene units] hold lies near it: where it is less than a third as
/// far from them as the farthest particle, the end around that particle, of the tenth that is farthest from them.
/// Separate pieces that no pin holds do not count while another one is held.
ObjectTip tip_of(const ParticleFile& particles, const std::vector<Region>& pins, const Vec3d& up);

/// How the tip (the mean of its particles) moved, as shares of `height` [scene units]: tip_peak, tip_end,
/// tip_drift_before (largest displacement in the first `quiet` seconds), and the largest motion of any particle.
nlohmann::json describe_motion(const TrajectoryFile& trajectory, const ParticleFile& particles, const ObjectTip& tip,
                               double height, double quiet = 0.25);

}  // namespace pliant

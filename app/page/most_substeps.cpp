#include "app/page/most_substeps.h"

#include <algorithm>
#include <cmath>

#include "physics/simulate/simulator.h"

namespace pliant {
namespace {

constexpr double kRestReserve = 4;        // substeps over those at rest that a frame may take in any case ...
constexpr double kStifferReserve = 1.25;  // ... and over those at rest with the stiffness of now
constexpr double kMostStiffer = 100;      // times, as far as the pages' sliders go

}  // namespace

int most_substeps(const SimulateOptions& options, const Particles& particles, double young_scale, double many) {
  const double rest = substeps_at_rest(options, particles);
  const double reserve = std::max(kRestReserve, kStifferReserve * std::sqrt(std::min(young_scale, kMostStiffer)));
  return static_cast<int>(std::min(std::max(many, reserve * rest), 1.0 * kMaxSubstepsOfFrame));
}

}  // namespace pliant

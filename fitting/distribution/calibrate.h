#pragma once

#include "fitting/distribution/distribution_network.h"
#include "fitting/distribution/training_set.h"

namespace pliant {

/// Sets temperature and wide weight to those of the highest likelihood, over a grid (temperatures: Guo et al. 2017),
/// and the tail so that 80 % of the values lie inside of their intervals (conformal prediction: Vovk et al. 2005).  All
/// of it on families that were not seen: those that `held` has, by all members, and each that `train` has, by the
/// member that leaves it out.
void calibrate(const TrainingSet& train, const TrainingSet& held, DistributionNetwork& network);

}  // namespace pliant

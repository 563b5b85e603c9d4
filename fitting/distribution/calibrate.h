#pragma once

#include "fitting/distribution/distribution_network.h"
#include "fitting/distribution/training_set.h"

namespace pliant {

/// Sets temperature and wide weight to those of the highest likelihood of the set, over a grid (temperatures: Guo et
/// al. 2017), and the tail so that 80 % of its values lie inside of their intervals (conformal prediction: Vovk et al.
/// 2005).
void calibrate(const TrainingSet& set, DistributionNetwork& network);

}  // namespace pliant

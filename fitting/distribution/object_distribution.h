#pragma once

#include "fitting/distribution/distribution_network.h"

namespace pliant {

/// Every sample takes the mean over samples that lie close by, look alike and are as thick (bilateral filter: Tomasi
/// and Manduchi 1998): E, its interval and rho as decades.
void average_over_neighbours(const FeatureInput& object, MaterialDistribution& distribution);

/// Material of an object around its means: `predict_distribution` of its features, which judges each sample by itself,
/// averaged over neighbours.  `volume` [M] is what counts in the means of the object.
MaterialDistribution object_distribution(const DistributionNetwork& network, const FeatureInput& object,
                                         std::span<const float> volume, const MaterialMeans& means);

}  // namespace pliant

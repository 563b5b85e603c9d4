#pragma once

#include "fitting/distribution/distribution_network.h"
#include "gaussians/base/random.h"

namespace pliant {

/// A small network of random parameters, which says something of every sample.
inline DistributionNetwork made_network(uint64_t seed) {
  DistributionNetwork n;
  n.size.hidden = 16;
  auto& parameters = n.members.emplace_back(initial_parameters(n.size, seed));
  Random random(seed, 1);
  for (float& p : parameters) p += static_cast<float>(0.2 * random.normal());
  n.shift.assign(kFeatures, 0.1f);
  n.scale.assign(kFeatures, 0.9f);
  n.wide_mean = -0.8f;
  n.wide_sigma = 1.4f;
  return n;
}

}  // namespace pliant

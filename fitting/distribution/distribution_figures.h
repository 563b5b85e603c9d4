#pragma once

#include <span>
#include <string>
#include <vector>

#include "fitting/distribution/distribution_network.h"
#include "fitting/distribution/material_object.h"

namespace pliant {

/// How well a network knows objects whose material is known, of one family or of several.  Both the network and what it
/// is compared with are given the true mean of each object.
struct DistributionFigures {
  std::string family;
  size_t objects = 0, samples = 0;
  double error = 0, error_of_mean = 0;  ///< medians over the samples of |delta log10 E|: network, mean alone
  double log_density = 0;               ///< mean over the samples of that of the true log10 E, per decade
  double log_density_of_one = 0;        ///< under one Gaussian of all training values
  double coverage = 0;                  ///< share of samples inside of their 80 % interval
  double density_error = 0, density_error_of_mean = 0;  ///< medians of |delta log10 rho|
  double poisson_error = 0, poisson_error_of_mean = 0;  ///< medians of |delta nu|
};

/// Figures of each family in the order of its first object, then of all, "all", in which every object counts alike.
std::vector<DistributionFigures> distribution_figures(const DistributionNetwork& network,
                                                      std::span<const MaterialObject> objects);

}  // namespace pliant

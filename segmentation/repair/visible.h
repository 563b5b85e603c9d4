#pragma once

#include <vector>

#include "segmentation/repair/hole.h"

namespace pliant {

/// The Gaussians of `patch` that no view sees outside its hole: nothing may be added in front of or on what is there,
/// nor where a view saw that there was nothing.
GaussianCloud inside_holes(const GaussianCloud& patch, const std::vector<HoleView>& views,
                           const Observation& observation, const std::vector<Camera>& cameras);

/// Never observed Gaussians that come into view in holes and nowhere else: nobody knows whether they are right.
std::vector<int> uncovered_guesses(const GaussianCloud& background, const Observation& observation,
                                   const std::vector<HoleView>& views, const std::vector<Camera>& cameras);

}  // namespace pliant

#pragma once

#include <vector>

#include "app/fit/fit_scene.h"

namespace pliant {

/// The object as the video's camera sees it, coloured by a value of its driving particles on a logarithmic scale,
/// before the scene in grey; rigid parts stay grey.  Below it a bar with round numbers from `low` to `high` > 0 and
/// `label`.
ImageF picture_of_drivers(const FitScene& fit, const std::vector<double>& value, double low, double high,
                          const std::string& label);

}  // namespace pliant

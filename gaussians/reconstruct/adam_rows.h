#pragma once

#include <span>

#include "gaussians/reconstruct/training_state.h"

namespace pliant {

/// One step of Adam (Kingma and Ba 2015, algorithm 1; beta .9, .999, epsilon 1e-15 as the reference 3DGS code) over an
/// array [n, rates.size()] whose columns have rates of their own.  `step` counts from 1.
void adam_rows(std::span<float> parameter, std::span<const float> gradient, std::span<const float> rates, long step,
               Moments& moments);

}  // namespace pliant

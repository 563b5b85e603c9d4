#pragma once

#include "gaussians/reconstruct/train_options.h"

namespace pliant {

/// Share of a training that is done, in [0, 1]: of the seconds when these are limited, else of the iterations.
double training_progress(const TrainOptions& options, int iteration, double seconds);

/// Value that falls (or rises) exponentially from `first` to `last`.
float exponential_rate(float first, float last, double progress);

/// Degree of the spherical harmonics that is trained.
int sh_degree_at(const TrainOptions& options, double progress);

/// Photos are shown at 1 / 2^level of their size: a quarter for the first eighth, half for the next quarter.
/// `longest_side` of the photos keeps small ones from getting too small (below 200 px).
int level_at(const TrainOptions& options, double progress, int longest_side);

/// Number of Gaussians that MCMC aims at: exponential from `started_with` to the budget.
size_t planned_gaussians(const TrainOptions& options, size_t started_with, size_t budget, double progress);

}  // namespace pliant

#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "app/statistics/proportion.h"

namespace pliant {

/// A stated uncertainty and the truth: the estimate's standard deviation upwards and downwards, > 0.
struct StatedBand {
  double estimate = 0, sigma_below = 0, sigma_above = 0, truth = 0;

  /// Distance of the truth in standard deviations of its side.
  double z() const;
};

struct Coverage {
  int inside = 0, rows = 0;
  double share = 0;
  Interval interval;       ///< of the probability, exact, 95 %
  bool as_stated = false;  ///< the nominal probability lies in it
};

struct CalibrationLevel {
  double nominal = 0;
  Coverage stated;               ///< of the bands as they are, all rows
  std::optional<double> factor;  ///< by which bands of this level are to be multiplied, from the first half; none where
                                 ///< that has too few rows
  Coverage second_half;          ///< of the bands as they are, second half
  std::optional<Coverage> with_factor;      ///< of the bands times `factor`, second half
  std::optional<Coverage> with_one_factor;  ///< of the bands times the factor of all levels, second half
};

struct Calibration {
  std::vector<CalibrationLevel> levels;
  std::optional<double> factor;  ///< one for all levels: the geometric mean of those above 0
};

/// Whether stated bands hold the truth as often as they say, the errors being taken as normal: a band of probability q
/// is z_q standard deviations wide on either side, z_q = Phi^-1((1 + q) / 2).  The factor of a level is the order
/// statistic ceil((n + 1) q) of |z| / z_q over one half of the rows (split conformal prediction, Vovk et al. 2005, Lei
/// et al. 2018), which covers new rows with probability q or more whatever the errors' distribution is; fewer than
/// q / (1 - q) rows do not have it.  The other half checks it.  Rows are halved at random by `seed`.  At least 8 rows.
Calibration calibrate(std::span<const StatedBand> rows, std::span<const double> levels, uint64_t seed);

/// How many of the bands, times `factor`, hold the truth at a nominal probability.
Coverage coverage(std::span<const StatedBand> rows, double nominal, double factor = 1);

/// Standard deviations on either side that hold a normal variable with this probability.
double normal_half_width(double probability);

}  // namespace pliant

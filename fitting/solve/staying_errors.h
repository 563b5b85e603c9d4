#pragma once

#include <cstddef>
#include <span>

namespace pliant {

// A track begins at a patch of one frame, and how that was matched is wrong in all later ones: of the errors [rows,
// columns] of a fit, those of a column share a part that stays.  Entries of 0 were not measured.

/// Correlation of any two errors of a column, by the spread of the columns' means; from 0 to 0.95.
double staying_share(std::span<const double> errors, size_t columns);

/// Takes of each column's mean as much as leaves errors independent whose correlation in a column is `to` (the square
/// root of that covariance's inverse, but for a factor).  `values` are errors, or derivatives of them, from which as
/// much has been taken as is right for `from`; entries count whose error in `measured` is not 0.
void even_out(std::span<double> values, std::span<const double> measured, size_t columns, double from, double to);

}  // namespace pliant

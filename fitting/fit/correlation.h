#pragma once

#include <cstddef>
#include <span>

#include "gaussians/base/types.h"

namespace pliant {

/// Factor by which correlation between neighbouring rows widens the variance of a mean: 1 + 2 sum of the
/// autocorrelations, averaged over the columns of residuals [rows, columns], up to their first zero.  Covariances of a
/// fit times this factor times the residuals' variance allow for what the model cannot explain.
double correlation_factor(std::span<const double> residuals, size_t columns);

/// The same for correlation between neighbouring columns: of residuals [rows, points, axes] of points at `place` [points],
/// 1 + the sum over the other points of the correlation at their distance, up to its first zero.
double neighbour_factor(std::span<const double> residuals, std::span<const Vec3f> place, size_t axes);

/// Standard deviation that errors [rows, points, axes] would need to weigh as much as they do if all were independent: the
/// root mean square of those that are not 0, wider by the roots of both factors.
double unexplained(std::span<const double> residuals, std::span<const Vec3f> place, size_t axes);

}  // namespace pliant

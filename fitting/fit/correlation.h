#pragma once

#include <cstddef>
#include <span>

#include "gaussians/base/types.h"

namespace pliant {

/// Factor by which correlation between neighbouring rows widens the variance of a mean: 1 + 2 sum of the
/// autocorrelations, averaged over the columns of residuals [rows, columns], up to their first zero.  Covariances of a
/// fit times this factor times the residuals' variance allow for what the model cannot explain.
double correlation_factor(std::span<const double> residuals, size_t columns);

/// The same for correlation between neighbouring rows and neighbouring points: of residuals [rows, points, axes] of points
/// at `place` [points], the sum of the correlations with all points and rows no farther than where those in space alone,
/// and those in time alone, first come to zero.  At least 1.
double correlation_factor(std::span<const double> residuals, std::span<const Vec3f> place, size_t axes);

/// Standard deviation that errors [rows, points, axes] would need to weigh as much as they do if all were independent: the
/// root mean square of those that are not 0, wider by the root of that factor.
double unexplained(std::span<const double> residuals, std::span<const Vec3f> place, size_t axes);

}  // namespace pliant

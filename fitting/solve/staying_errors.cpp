#include "fitting/solve/staying_errors.h"

#include <algorithm>
#include <cmath>

#include "gaussians/base/error.h"

namespace pliant {
namespace {

constexpr double kMost = 0.95;

/// What is left of the mean of `count` errors.
double kept_of_mean(double share, double count) { return std::sqrt((1 - share) / (1 + (count - 1) * share)); }

}  // namespace

double staying_share(std::span<const double> errors, size_t columns) {
  CHECK(columns > 0 && errors.size() % columns == 0);
  // Of n errors of variance s^2, the square of the sum is expected to be n s^2 (1 + (n - 1) share).
  double together = 0, alone = 0;
  for (size_t c = 0; c < columns; ++c) {
    double sum = 0, squares = 0, count = 0;
    for (size_t i = c; i < errors.size(); i += columns) {
      sum += errors[i];
      squares += errors[i] * errors[i];
      count += errors[i] != 0;
    }
    together += sum * sum - squares;
    alone += (count - 1) * squares;
  }
  return alone > 0 ? std::clamp(together / alone, 0.0, kMost) : 0;
}

void even_out(std::span<double> values, std::span<const double> measured, size_t columns, double from, double to) {
  CHECK(columns > 0 && values.size() == measured.size() && values.size() % columns == 0);
  if (from == to) return;
  for (size_t c = 0; c < columns; ++c) {
    double sum = 0, count = 0;
    for (size_t i = c; i < values.size(); i += columns)
      if (measured[i] != 0) {
        sum += values[i];
        count += 1;
      }
    if (count == 0) continue;
    const double less = (1 - kept_of_mean(to, count) / kept_of_mean(from, count)) * sum / count;
    for (size_t i = c; i < values.size(); i += columns)
      if (measured[i] != 0) values[i] -= less;
  }
}

}  // namespace pliant

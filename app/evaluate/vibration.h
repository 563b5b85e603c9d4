#pragma once

#include <cstddef>
#include <vector>

namespace pliant {

/// Where points are over time: displacements [T][K * dims], evenly sampled, with a weight [K] for each point.
struct PointMotion {
  double rate = 0;  ///< 1/s
  int dims = 2;
  std::vector<std::vector<double>> displacement;
  std::vector<double> weight;

  size_t frames() const { return displacement.size(); }
  size_t points() const { return weight.size(); }
};

/// a + b t + exp(-decay t) (c cos(2 pi frequency t) + s sin(2 pi frequency t)), t in s from the first value.
struct DampedOscillation {
  double frequency = 0, decay = 0;  ///< Hz, 1/s; frequency 0 = nothing is seen to oscillate
  double slower_than = 0;           ///< Hz; half a period in the record, where the best fit is that: slow or creeping
  double amplitude = 0;             ///< sqrt(c^2 + s^2)
  double explained = 0;             ///< share of the variance about the line a + b t
};

/// Least squares over evenly sampled values; linear in all but frequency and decay, which are searched on a grid that
/// closes in.  Needs 8 values and half a period.  Also of what dies out early in the record: `decay` is sought up to
/// half the rate and 4 * 2 pi frequency, and down to a growth by e over the record.  Frequency 0 where the best fit
/// lies at the end of the frequencies (half a period in the record, half the rate) or of the decays, as of what creeps
/// back.  The time grows with the square of the number of values: about 15 ms for 250.
DampedOscillation fit_oscillation(const std::vector<double>& values, double rate);

/// What a motion does on the whole.
struct Vibration {
  std::vector<double> course;  ///< [T] first principal component of all displacements, in their unit
  double share = 0;            ///< of the motion's variance that this component has
  double amplitude = 0;  ///< half the way from end to end, along its main direction, of the point that only 5 % surpass
  DampedOscillation oscillation;  ///< of the course from frame `first` on
  DampedOscillation
      small;  ///< once it stays within a third of its largest; large swings of a plant are slower; needs 3 periods
};

/// `first`: frame from which the motion is free; negative = where the course is farthest from its mean, when that lies
/// in the first half, else 0.  Returns it in `first`.
Vibration describe_vibration(const PointMotion& motion, int& first);

}  // namespace pliant

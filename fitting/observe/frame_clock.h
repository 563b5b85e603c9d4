#pragma once

#include <span>

namespace pliant {

/// The rate of a video's frames, and how coarsely its file stores their instants.
struct FrameClock {
  double rate = 0;  ///< 1/s
  double grain =
      0;  ///< s, of time stamps that are rounded instants of that rate (1 ms in Matroska); 0 = taken as exact

  /// The instant [s from the first frame] that a time stamp is rounded from.
  double instant(double stamp) const;
};

/// `stamps`: s from the first frame, growing; `file_rate`: what the file tells, which is the average rate in many
/// formats.  That is the rate of uneven steps.  Of steps that are even, but for missing frames, it is one over the
/// step: what the file tells or else the nearest common rate, if within the rounding of the stamps.
FrameClock clock_of(std::span<const double> stamps, double file_rate);

}  // namespace pliant

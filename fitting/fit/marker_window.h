#pragma once

#include <string>
#include <vector>

#include "fitting/observe/markers.h"

namespace pliant {

/// What part of a recording of markers counts.
struct MarkerWindowOptions {
  double rest_begin = 0;     ///< s of the recording; from here to the release the body is at rest
  double release = 0;        ///< s of the recording; NaN = where motion sets in
  double release_range = 0;  ///< s before the release that count as well
  double window = 0;         ///< s after it
};

/// What was measured of some markers there, as displacements from rest.
struct MarkerWindow {
  std::vector<double> time;                      ///< [T] s of the recording
  std::vector<std::vector<Vec3d>> displacement;  ///< [T][chosen] m
  std::vector<std::vector<double>> weight;       ///< [T][chosen]

  double total_weight() const;
};

/// Time of the release [s].  Throws Error{kUsage} for one that is given and not within the recording from `rest_begin`
/// on, Error{kInput} where the recording has no rest or no motion.
double marker_release(const MarkerWindowOptions& options, const MarkerTracks& tracks);

/// Of the markers `chosen`, which were at `rest` [markers, 3] m before `release`.  Throws Error{kInput} where too
/// little was measured after it.
MarkerWindow marker_window(const MarkerWindowOptions& options, const MarkerTracks& tracks, double release,
                           const std::vector<int>& chosen, const std::vector<Vec3d>& rest);

/// A sentence on each of the markers `chosen` that has less weight in `kept` than it had as recorded (without_spikes).
std::vector<std::string> spike_warnings(const MarkerTracks& recorded, const MarkerTracks& kept,
                                        const std::vector<int>& chosen);

/// When every one of them has been seen at rest [s].
double seen_at_rest(const MarkerWindowOptions& options, const MarkerTracks& tracks, const std::vector<int>& chosen);

}  // namespace pliant

#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "gaussians/base/types.h"

namespace pliant {

/// Where markers on a body were measured.
struct MarkerTracks {
  std::vector<std::string> name;             ///< [K]
  std::vector<double> time;                  ///< [T] s, ascending
  std::vector<std::vector<Vec3d>> position;  ///< [T][K] m; zero where not measured
  std::vector<std::vector<double>> weight;   ///< [T][K] 1, or 0 where not measured

  size_t markers() const { return name.size(); }
  size_t samples() const { return time.size(); }
};

/// Comma- or semicolon-separated table whose first line names the columns: `time` (or `t`; seconds, or with the ending
/// _s or _ms), then x, y and z of each marker, as NAME_x NAME_y NAME_z with the ending _m or _mm or none
/// (`unit_of_unnamed` [m]), or simply x y z repeated.  An empty cell, `nan` or `NA` is a gap.  Lines that begin with #
/// are skipped.  Throws Error{kInput} naming line and column.
MarkerTracks read_markers(const std::filesystem::path& file, double unit_of_unnamed = 1);

/// Linear interpolation at other times; not measured beyond the ends and next to gaps.
MarkerTracks resampled(const MarkerTracks& tracks, std::span<const double> times);

/// [K] mean of what was measured in [begin, end]; NaN for a marker that was not.
std::vector<Vec3d> mean_position(const MarkerTracks& tracks, double begin, double end);

/// Last time before any marker is farther from `rest` [K] than `share` of the largest such distance of all markers and
/// times; a marker whose rest is NaN does not count, nor does a distance that is not there again within the marker's
/// next two samples.  The first time when nothing moves.
double onset_of_motion(const MarkerTracks& tracks, std::span<const Vec3d> rest, double share = 0.03);

/// Without weight where, after `begin` [s], when all are at rest, a marker jumps away for a single sample: by more than
/// twice what any marker moves for longer, or by a tenth of that where the marker rests just before and after.
MarkerTracks without_spikes(const MarkerTracks& tracks, double begin);

}  // namespace pliant

#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "fitting/observe/align_patch.h"
#include "fitting/observe/reference_video.h"
#include "gaussians/vision/optical_flow.h"

namespace pliant {

struct TrackOptions {
  AlignOptions patch;
  double round_trip = 3;  ///< px: a track that flow leads back this far from where it started counts exp(-1/2); flow
                          ///< errs by 2 px at edges
  double low_correlation = 0.5;                ///< of the patch with that at rest: lost below ...
  double high_correlation = 0.85;              ///< ... and fully counted above
  double blur = 0.3;                           ///< px: expected error at which a track counts half
  FlowQuality step_flow = FlowQuality::kFine;  ///< of the flow from frame to frame
  int look_again = 1;  ///< frames from one to the next in which doubtful points are looked for from the first frame
};

/// Where points of the first frame are in every frame.
struct PixelTracks {
  std::vector<std::vector<Eigen::Vector2d>> pixel;  ///< [T][P] px
  std::vector<std::vector<double>> weight;          ///< [T][P] 0 = lost, hidden or without texture .. 1
  std::vector<std::vector<double>> sigma;  ///< [T][P] px, expected error from noise alone; infinite = no texture
  double kept = 0;                         ///< mean weight
};

/// Follows `points` [P] (px in the first frame, which shows the object at rest) through the video.  Dense flow gives
/// two guesses for each frame, one from the first frame and one from the frame before; the patch around the point is
/// then aligned with the first frame itself (align_patch.h), so that errors do not add up.  The weight is small where
/// flow backwards does not lead back, where the patch looks different, and where it has no texture.  `object` [H, W, 1]
/// (may be empty) marks the object in the first frame: only its pixels make up the patches, and points should lie on
/// it. Equal bit for bit for any number of threads.
PixelTracks track_pixels(const TrackOptions& options, std::span<const ImageF> video,
                         std::span<const Eigen::Vector2d> points, const ImageU8& object = {});
inline PixelTracks track_pixels(const TrackOptions& options, const ReferenceVideo& video,
                                std::span<const Eigen::Vector2d> points, const ImageU8& object = {}) {
  return track_pixels(options, video.frames, points, object);
}

}  // namespace pliant

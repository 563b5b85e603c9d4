#pragma once

#include "fitting/objective/flow_loss.h"
#include "fitting/objective/guidance_loss.h"
#include "fitting/objective/motion.h"
#include "fitting/objective/picture_loss.h"
#include "fitting/objective/track_loss.h"

namespace pliant {

/// Frames `first` to `last` of a video as a roll-out shows them.
struct ClipFrames {
  int first = 0, last = 0;  ///< of the video
  int lead = 0, every = 1;  ///< frame lead + every * k of the roll-out shows frame first + k
  double fps = 24;          ///< of the video

  int of(int video_frame) const { return lead + every * (video_frame - first); }
  int count() const { return of(last) + 1; }
};

/// What a motion is compared with; weights say what counts against one square pixel of the tracks, and 0 leaves out.
struct ClipTerms {
  double track_weight = 1;
  std::shared_ptr<const DrawnObject<float>> drawn;  ///< of everything but the tracks
  std::vector<SeenFrames<float>> seen;  ///< by each camera, [T] frames of the video, and where they are compared
  PictureLossOptions picture;
  double picture_weight = 0;
  double flow_weight = 0;   ///< of squared pixels a frame
  double flow_outlier = 1;  ///< px
  std::shared_ptr<Guidance> guide;
  Camera guide_camera;
  double guide_weight = 0;

  /// Whether anything but tracks counts.
  bool beyond_tracks() const { return picture_weight > 0 || flow_weight > 0 || guide_weight > 0; }
};

/// `tracks` [frames of the video] may be null when only guidance counts.
Objective<float> clip_objective(const ClipTerms& terms, const TrackLoss<float>* tracks, const ClipFrames& frames);

/// Frames [T] cut down to the box of what counts in some `weight` ([T] of [H, W, 1], or one for all frames), and a
/// border for the windows of SSIM.  A frame in which nothing counts becomes an empty one.  Throws Error{kInput} where
/// nothing counts in any.
SeenFrames<float> cut_to_weight(const Camera& camera, std::span<const ImageF> frames, std::span<const ImageF> weight);

/// Flow between neighbouring frames first .. last of a video (dense inverse search), as a roll-out shows them; none
/// from or to an empty frame.  A pixel counts by its weight, with weights of each frame by the least of those there in
/// both frames and where the flow leads to, and by how well flow backwards leads back to it.
SeenFlow<float> flow_of_clip(const SeenFrames<float>& seen, const ClipFrames& frames);

}  // namespace pliant

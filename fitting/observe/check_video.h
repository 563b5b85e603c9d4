#pragma once

#include <span>
#include <string>
#include <vector>

#include "fitting/observe/frame_rhythm.h"
#include "fitting/observe/reference_video.h"
#include "gaussians/vision/match_pictures.h"

namespace pliant {

enum class VideoProblem {
  kOtherView,    ///< the first frame does not show the scene from this camera
  kViewOff,      ///< it does, from a place somewhat beside it
  kHidden,       ///< the object covers next to nothing of the picture
  kCut,          ///< the background jumps
  kLeap,         ///< the object does, before a background that stands still
  kCameraMoves,  ///< the background drifts
  kStatic,       ///< the object does not move
  kNotAtRest,    ///< the first frame shows the object away from its place in the scene
  kRate,         ///< the scene file tells another frame rate than the file
  kLight,        ///< brightness of the background changes
  kRepeated,     ///< frames are shown more than once
  kDropped       ///< frames are missing at even distances
};

/// Something about a video that a fit should not pass over.
struct VideoFinding {
  VideoProblem problem;
  bool refuse = false;  ///< a fit would explain something else than the object's motion
  double value = 0, limit = 0;
  int frame = -1;        ///< where it is worst; -1 = everywhere
  std::string sentence;  ///< what was found, with the value, and what to do
};

struct VideoCheckOptions {
  double least_score = 0.3;                            ///< of the first frame against the scene (PictureMatch)
  double most_shift = 0.01, noted_shift = 0.005;       ///< of the width, between first frame and scene: refused, said
  double most_drift = 0.005, noted_drift = 0.0015;     ///< of the width, of the background: refused, said
  double least_motion = 0.5;                           ///< px, of the object
  double most_displaced = 0.25;                        ///< of its motion, in the first frame from its place at rest
  double least_continuity = 0.5, least_change = 0.03;  ///< score and colour difference between frames that make a cut
  double noted_light = 0.1;                            ///< relative change of the background's mean colour
  double noted_repeats = 0.15;                         ///< share of frames
  int least_pixels = 30;                               ///< of the object
  int flow_frames = 24;                                ///< compared with the first one
};

struct VideoChecks {
  PictureMatch match;     ///< of the first frame with the scene
  double drift = 0;       ///< px, median over the background, in the worst frame
  double motion = 0;      ///< px, 95th percentile over the object, in the frame that is farthest
  double noise = 0;       ///< px, of the flow where nothing moves
  double displaced = 0;   ///< px, 95th percentile over the object, in the first frame from the scene at rest
  double continuity = 1;  ///< lowest score of the background between neighbouring frames
  double light = 0;       ///< largest relative change of the background's mean colour
  double repeated = 0;    ///< share of frames
  FrameRhythm rhythm;     ///< of frames that are repeated or missing
  std::vector<VideoFinding> findings;  ///< those that refuse first

  bool usable() const { return findings.empty() || !findings.front().refuse; }
  const VideoFinding* find(VideoProblem problem) const;
};

/// Looks whether a video can be explained by motion of the object before a camera that stands still.  `picture` [H, W,
/// 3] is the scene rendered from video.camera, `object` [H, W, 1] marks the object in it.  `compared` ([T], [1] or none
/// of [H, W, 1]) is 0 where something hides the scene; see HiddenPixels.  Thresholds: on the demo scene the right
/// camera scores 0.76 with a shift of 0.2 % of the width, the 39 others at most 0.11 with 2.4 % or more.
VideoChecks check_video(const VideoCheckOptions& options, const ReferenceVideo& video, const ImageF& picture,
                        const ImageU8& object, std::span<const ImageU8> compared = {});

/// Throws Error{kInput} with all sentences that refuse, naming `file`.
void require_usable(const VideoChecks& checks, const std::string& file);

}  // namespace pliant

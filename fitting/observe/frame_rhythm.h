#pragma once

#include <span>

namespace pliant {

/// A pattern that repeats itself every `period` frames: in it some frames show the one before again, or one step of the
/// motion is twice as long as the others, because a frame is missing there.
struct FrameRhythm {
  int period = 0;    ///< frames; 0 = there is none
  int repeated = 0;  ///< of them, that show the one before again
  int missing = 0;   ///< of them: 1 or 0

  /// Frames of the motion in a frame of the video: 1/2 when each is shown twice, 5/4 when every fifth was dropped.
  double share() const { return period > 0 ? static_cast<double>(period - repeated + missing) / period : 1; }
};

/// The shortest rhythm of `change` [T], by how much each frame differs from the one before (that of the first is not
/// read).  It must hold in both halves of the motion for at least three periods each; a swing between two frames is no
/// rhythm unless its own period is an exact multiple of theirs.
FrameRhythm find_rhythm(std::span<const float> change);

}  // namespace pliant

#pragma once

#include <span>
#include <vector>

#include "fitting/observe/hidden_pixels.h"
#include "gaussians/base/image.h"

namespace pliant {

/// How the frames of a video differ: all [T], and from the frame before unless stated; of the first one, as if nothing
/// had changed.
struct FrameChanges {
  std::vector<double> score;       ///< match score of the background
  std::vector<double> difference;  ///< mean absolute difference of the background's colours
  std::vector<float> moved;        ///< mean absolute difference of the colours of the object's surroundings
  std::vector<double> light;       ///< relative change of the background's mean colour from the first frame
};

/// `surroundings` [H, W, 1] is not 0 where the object may move, 0 on the background.  What is hidden is not compared.
FrameChanges frame_changes(std::span<const ImageF> frames, const ImageU8& surroundings, const HiddenPixels& hidden);

}  // namespace pliant

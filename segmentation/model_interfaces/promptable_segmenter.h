#pragma once

#include <optional>
#include <vector>

#include "gaussians/base/image.h"
#include "gaussians/base/types.h"

namespace pliant {

/// What a person or a detector points at in a picture [px].
struct MaskPrompt {
  struct Box {
    float x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  };
  struct Point {
    float x = 0, y = 0;
    bool foreground = true;
  };
  std::optional<Box> box;
  std::vector<Point> points;
};

struct SegmentedMask {
  ImageF logits;            ///< [H, W, 1] of the picture; > 0 = belongs to the thing
  float predicted_iou = 0;  ///< 0..1, the segmenter's own guess
};

/// Masks for prompts (the SAM family: Kirillov et al. 2023).  The picture is read once, prompts are cheap.
class PromptableSegmenter {
 public:
  virtual ~PromptableSegmenter() = default;
  /// picture [H, W, 3] sRGB in 0..1; replaces the one before.
  virtual void encode(const ImageF& picture) = 0;
  /// Candidates for one prompt, best first, at least one; of the picture of the last `encode`, without which this is a
  /// broken invariant.  A prompt without box and points, or outside the picture, is an Error{kUsage}.
  virtual std::vector<SegmentedMask> segment(const MaskPrompt& prompt) = 0;
};

}  // namespace pliant

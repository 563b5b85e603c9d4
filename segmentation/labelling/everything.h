#pragma once

#include <vector>

#include "segmentation/labelling/id_picture.h"

namespace pliant {

/// Everything in a picture from a promptable segmenter alone; the values of SAM's automatic mask generator (Kirillov et
/// al. 2023, appendix B).
struct EverythingOptions {
  int points_per_side = 32;       ///< of a grid of prompts
  float least_iou = 0.88f;        ///< predicted
  float least_stability = 0.95f;  ///< of the masks at the logits +-stability_offset
  float stability_offset = 1;
  float box_nms = 0.7f;       ///< overlap of boxes at which only the better mask stays
  float most_share = 0.95f;   ///< of the picture that a mask may cover
  bool skip_covered = false;  ///< no prompt where a mask that was found lies already; coarse grids come first

  /// For a segmenter without weights: fewer prompts, and its predictions are lower.
  static EverythingOptions weight_free();
};

/// Masks of all prompts that pass, best first.  picture [H, W, 3] as for `encode`.
std::vector<PictureMask> segment_everything(const EverythingOptions& options, const ImageF& picture,
                                            PromptableSegmenter& segmenter);

}  // namespace pliant

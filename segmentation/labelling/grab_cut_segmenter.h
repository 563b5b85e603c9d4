#pragma once

#include <cstdint>

#include "segmentation/labelling/picture_window.h"
#include "segmentation/model_interfaces/promptable_segmenter.h"
#include "segmentation/select/grab_cut.h"

namespace pliant {

struct GrabCutSegmenterOptions {
  GrabCutOptions cut;
  std::vector<float> levels = {1, 3};  ///< of the logits, see GrabCutOptions
  int window = 160;                    ///< px, longer side of what is cut; the rest of the picture is never looked at
  float context = 0.5f;                ///< of a box, on every side: background for sure
  float core = 0.5f;                   ///< of a box's axes: the ellipse in the middle is foreground for sure
  float shape = 1;                     ///< log odds in the middle of a box; 0 on the inscribed ellipse, negative beyond
  float least_part = 0.1f;             ///< parts apart from the core are kept when they hold this share of the mask
  float least_hole = 0.02f;            ///< smaller holes are filled, share of the mask
  float dot = 0.02f;                   ///< radius of what a point marks for sure, share of the window
  float point = 4,
        reach = 0.12f;    ///< log odds beside a point, and the distance over which they fade, share of the window
  int point_window = 96;  ///< `window` of points alone
  std::vector<float> sizes = {0.1f, 0.25f,
                              0.6f};  ///< of what is meant by points alone, shares of the picture's longer side
};

/// Masks without learnt weights: GrabCut (Rother, Kolmogorov and Blake 2004) in a window around the prompt.
class GrabCutSegmenter final : public PromptableSegmenter {
 public:
  explicit GrabCutSegmenter(const GrabCutSegmenterOptions& options = {}) : options_(options) {}
  void encode(const ImageF& picture) override;
  std::vector<SegmentedMask> segment(const MaskPrompt& prompt) override;

 private:
  SegmentedMask cut(const MaskPrompt::Box& box, bool tight, const std::vector<MaskPrompt::Point>& points) const;

  GrabCutSegmenterOptions options_;
  ImageF lab_;  ///< [H, W, 3] of the picture
};

}  // namespace pliant

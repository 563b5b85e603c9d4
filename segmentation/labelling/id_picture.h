#pragma once

#include <string>
#include <vector>

#include "gaussians/base/image.h"
#include "segmentation/model_interfaces/promptable_segmenter.h"

namespace pliant {

/// The pixels of one thing, kept as the rectangle around them.
struct PictureMask {
  std::string name;  ///< empty = unknown
  float score = 0;   ///< 0..1
  int x0 = 0, y0 = 0, width = 0, height = 0;
  std::vector<uint8_t> inside;  ///< [height * width]
  size_t pixels = 0;

  MaskPrompt::Box box() const;
};

/// What has logits > 0.
PictureMask picture_mask(const ImageF& logits, std::string name, float score);

struct PaintOptions {
  float nested = 0.8f;       ///< a mask with this share of it inside another one ...
  float larger = 2;          ///< ... that has this many times its pixels lies in front of it, whatever their scores
  float least_left = 0.3f;   ///< of its pixels that a mask must keep, and
  size_t least_pixels = 40;  ///< so many
};

/// One thing in a photo.
struct LabelledThing {
  uint32_t id = 0;
  std::string name;  ///< empty = unknown
  float score = 0;
  MaskPrompt::Box box;
  size_t pixels = 0;  ///< in the id picture
};

struct LabelledPhoto {
  IdImage ids;                        ///< [H, W, 1]; 1..n, best score first; 0 = nothing found there
  std::vector<LabelledThing> things;  ///< thing k has id k + 1
  std::vector<std::string> said;      ///< what the user should know
};

/// Masks that overlap made into one id picture: a pixel goes to the mask in front, else to the one with the best score.
LabelledPhoto paint_masks(const PaintOptions& options, int width, int height, std::vector<PictureMask> masks);

/// Places of the boxes that stay, best score first: of two that overlap by more than `most` the better one (non-maximum
/// suppression).  Equal scores keep their order.
std::vector<size_t> suppress_duplicates(const std::vector<MaskPrompt::Box>& boxes, const std::vector<float>& scores,
                                        float most);

}  // namespace pliant

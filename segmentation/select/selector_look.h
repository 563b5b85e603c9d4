#pragma once

#include "segmentation/select/selector.h"

namespace pliant {

/// A part of a prepared view, as if the object in it always had the same size in pixels.
struct Selector::Look {
  const RegionView* view = nullptr;
  std::vector<int> regions;  ///< of the view, ascending
  float scale = 1;           ///< px of the cut / px of the view
  GrabCutInput input;        ///< of these regions

  /// `picture`: px of the camera; its longer side becomes `window` px.
  Look(const RegionView& view, const PictureRect& picture, int window);
  void seed_strokes(const std::vector<StrokePrompt>& strokes);
  /// What a mask [regions] says about Gaussians.
  void lift(const std::vector<uint8_t>& mask, Lift& out) const;
};

}  // namespace pliant

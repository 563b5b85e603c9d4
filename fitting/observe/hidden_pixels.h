#pragma once

#include <span>

#include "fitting/observe/object_flow.h"
#include "gaussians/base/image.h"

namespace pliant {

/// What of a video is hidden by something that is not of the scene, such as a hand.
class HiddenPixels {
 public:
  /// `compared` ([T], [1] or none of [H, W, 1]) is 0 on what is hidden.  Where it leaves next to no background (0 in
  /// `surroundings` [H, W, 1]) in the first frame, it cuts the object out instead, and nothing is hidden.
  HiddenPixels(std::span<const ImageU8> compared, const ImageU8& surroundings);

  bool at(int frame, int x, int y) const {
    return !compared_.empty() && compared_[compared_.size() == 1 ? 0 : frame](x, y) == 0;
  }
  /// `ignored` [H, W, 1] and, not 0 either, the centres of windows of match_pictures.h of which something is hidden in
  /// one of two frames.
  ImageU8 beside(const ImageU8& ignored, int frame, int other) const;
  bool any() const { return !compared_.empty(); }
  /// Pixels of `mask` [H, W, 1], those that are not 0, that are seen in a frame.
  size_t seen(int frame, const ImageU8& mask) const;
  /// `picture` [H, W, 3] of a frame with what is hidden there as in `other`, so that no flow is drawn along with it.
  ImageF filled(const ImageF& picture, int frame, const ImageF& other) const;
  /// object_flow of what is seen in `frame` and, where the flow leads to, in `other`.
  ObjectFlow seen_flow(const ImageF& flow, const ImageF& contrast, ImageU8 object, ImageU8 surroundings, int frame,
                       int other) const;

 private:
  std::span<const ImageU8> compared_;
};

/// [H, W, 1] not 0 within `radius` px of where `mask` is not 0.
ImageU8 dilated(const ImageU8& mask, int radius);

}  // namespace pliant

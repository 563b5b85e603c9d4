#pragma once

#include <string>

#include "segmentation/repair/plane_picture.h"

namespace pliant {

struct ShadowOptions {
  float reach = 1.2f;           ///< how far from the footprint a contact shadow may go, in radii of the footprint
  float min_darkening = 0.05f;  ///< least darkening at the footprint [log luminance]
  float min_rim = 0.15f;        ///< least share of the footprint's rim that is dark
  float max_tint = 0.25f;       ///< how much the channels may differ in darkening, relative to their mean
  int offsets = 200;            ///< translations under which the surroundings repeat, best first, that are tried
};

/// The darkening of a support around the place where an object stood.
struct Shadow {
  enum class Verdict {
    kNone,      ///< the support is not darker around the footprint than elsewhere
    kPlain,     ///< a dark region that touches the footprint, fades out within reach and keeps the colour's hue
    kDoubtful,  ///< darker, but it may be paint or a shadow cast from farther away
  } verdict = Verdict::kNone;
  std::string doubt;     ///< why it is not plain
  PlanePicture picture;  ///< geometry of `gain`
  ImageF gain;           ///< [H, W, 1] light that is left, 1 outside the shadow
  float darkest = 1;     ///< least gain beside the footprint
  float area = 0;        ///< of the shadow around the footprint (scene units squared)

  /// Light left at a point of the plane, bilinear; 1 outside the picture.
  float gain_at(const Vec3f& x) const;
};

/// Looks for the contact shadow around the target of a plane's picture (its footprint).  Every texel is compared with
/// texels of equal texture out of reach (the translations under which the surroundings repeat), which leaves the
/// light: its logarithm, smoothed, freed of a linear trend, in the connected region around the footprint that is
/// darker than the light varies elsewhere.
Shadow find_shadow(const ShadowOptions& options, const PlanePicture& picture);

/// Divides the colours of the picture's Gaussians by the gain where they lie.  Returns how many changed; no other
/// Gaussian and no other attribute is touched.
size_t lift_shadow(const Shadow& shadow, GaussianCloud& background);

}  // namespace pliant

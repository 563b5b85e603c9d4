#pragma once

#include <functional>
#include <vector>

#include "gaussians/base/camera.h"
#include "gaussians/base/gaussian_cloud.h"
#include "gaussians/base/image.h"
#include "gaussians/render/render.h"

namespace pliant {

/// What counts as a hole after an object has been removed.
struct HoleOptions {
  float min_alpha = 0.9f;       ///< accumulated opacity below which a pixel is open
  float min_object = 0.05f;     ///< least blend weight of the object in a pixel where it "was seen"
  float min_observed = 0.05f;   ///< Gaussians with less blend weight [pixels] over all views that are looked at, and in
                                ///< the picture of each other camera, were never observed
  float min_share = 0.25f;      ///< nor were those that in no picture had this share of the weight that they have in it
                                ///< without the object: they shone through it
  float max_unobserved = 0.5f;  ///< share of such Gaussians above which a pixel shows what nobody saw
};

/// The scene before removal, as far as holes are concerned.
struct Observation {
  std::vector<int> view;          ///< [V] cameras that were looked at
  std::vector<ImageF> object;     ///< [V] blend weight of the object, [H, W, 1]
  std::vector<ImageF> depth;      ///< [V] of the object times that weight, [H, W, 1]
  std::vector<ImageU8> outside;   ///< [V] 1 = nothing was there: opacity < 0.5 with the object still in place
  std::vector<ImageU8> ignored;   ///< [V] 1 = the object was seen against nothing: never a hole
  std::vector<float> unobserved;  ///< [background] 1 = never observed while the object was there
};
/// Looks at `views`; the other cameras only tell what was observed.  `under_way` is called before each; it may throw.
Observation observe(const HoleOptions& options, const GaussianCloud& background, const GaussianCloud& object,
                    const std::vector<Camera>& cameras, const std::vector<int>& views,
                    const RenderOptions& render_options = {}, const std::function<void()>& under_way = {});

/// One view after removal.
struct HoleView {
  RenderResult picture;  ///< of the background; features [H, W, 1] = blend weight of never observed Gaussians
  ImageU8 hole;          ///< [H, W, 1] 1 = hole
  ImageU8 open;          ///< [H, W, 1] 1 = in a part of the hole that reaches the void beside the object
  size_t pixels = 0;
};

/// Renders `background` (its first Gaussians those of the observation, others added since) and marks the pixels where
/// the object was seen and accumulated opacity is below min_alpha, or never observed Gaussians are in front.  Left out
/// are ignored pixels and, in open parts, those nearest to the void beside the object: there is nothing to continue.
HoleView find_hole(const HoleOptions& options, const Observation& observation, size_t view,
                   const GaussianCloud& background, const std::vector<Camera>& cameras,
                   const RenderOptions& render_options = {});

}  // namespace pliant

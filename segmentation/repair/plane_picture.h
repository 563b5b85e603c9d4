#pragma once

#include <vector>

#include "segmentation/repair/surfaces.h"

namespace pliant {

/// A plane with its texture, pictured straight from the front in square texels.  u points right, v down, the normal
/// towards the viewer.
struct PlanePicture {
  Vec3f corner = Vec3f::Zero(), normal = Vec3f::UnitZ(), u = Vec3f::UnitX(), v = Vec3f::UnitY();
  float texel = 0;           ///< size of a texel (scene units)
  std::vector<int> members;  ///< observed Gaussians of the background on the plane
  ImageF color;              ///< [H, W, 3] where members cover a texel
  ImageU8 covered;           ///< [H, W, 1] 1 = members are opaque here
  ImageU8 target;            ///< [H, W, 1] 1 = some view sees the texel through its hole; a texel wider than that
  ImageU8 known;             ///< [H, W, 1] 1 = the colour can be trusted, and is not at the rim of the target

  bool empty() const { return color.empty(); }
  /// World position of picture coordinates; texel (i, j) has its centre at (i + 0.5, j + 0.5).
  Vec3f point(float x, float y) const { return corner + texel * (x * u + y * v); }
  Vec2f coordinates(const Vec3f& x) const { return Vec2f(u.dot(x - corner), v.dot(x - corner)) / texel; }
};

struct PlanePictureOptions {
  float margin = 1.8f;    ///< width of the surroundings, in widths of the hole
  int most_texels = 320;  ///< along a side; texels are about a pixel of the views while that suffices
};

/// Empty when no view sees the plane through a hole.
PlanePicture picture_plane(const PlanePictureOptions& options, const Surfaces& surfaces, int plane,
                           const std::vector<HoleView>& views, const std::vector<HoleGeometry>& geometry,
                           const Observation& observation, const GaussianCloud& background,
                           const std::vector<Camera>& cameras, const RenderOptions& render_options = {});

/// Colour without the black that shines through, but for thin lines: trained scenes leave dark joints transparent.
ImageF surface_color(const RenderResult& picture);
/// What may be copied: opaque enough for its colour to be known or a thin line in what is, and not at the fading rim of
/// the target.
ImageU8 source_mask(const RenderResult& picture, const ImageU8& target);

}  // namespace pliant

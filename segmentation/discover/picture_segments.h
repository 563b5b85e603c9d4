#pragma once

#include <vector>

#include "gaussians/base/camera.h"
#include "gaussians/base/image.h"
#include "gaussians/base/types.h"
#include "gaussians/render/blend_weights.h"

namespace pliant {

/// What a view shows of surfaces, one entry per pixel.
struct SurfacePicture {
  int width = 0, height = 0;
  double focal = 1;           ///< px, of a length of 1 at depth 1
  std::vector<float> alpha;   ///< accumulated opacity
  std::vector<Vec3f> lab;     ///< blended colour, see lab_of_rgb
  std::vector<Vec3f> point;   ///< camera frame, at the blended depth (scene units)
  std::vector<Vec3f> normal;  ///< camera frame, unit or zero, towards the camera
};

/// Blends colours `rgb` [N] and unit normals `normal` [N] (world, of either sign, zero = unknown) of the Gaussians.
SurfacePicture surface_picture(const BlendWeights& weights, const Camera& camera, std::span<const Vec3f> position,
                               std::span<const Vec3f> rgb, std::span<const Vec3f> normal);

/// Over-segmentation of a picture.
struct PictureSegmentOptions {
  float color = 0.06f;     ///< difference of Lab / 100 between neighbouring pixels that counts as a clear edge (1),
  float lightness = 0.5f;  ///< factor on its L, which shading changes too,
  float angle = 0.6f;      ///< of normals [rad] where the surface is hollow; ridges belong to a thing,
  float jump = 4.0f;       ///< and distance of the one's point from the other's tangent plane [px]
  float scale = 12.0f;     ///< px; larger = larger segments
  int least = 25;          ///< px; smaller segments join the neighbour that they are most like
  float opaque = 0.5f;     ///< least accumulated opacity of a pixel; others stay 0
};

/// Segments 1, 2, ... by the graph-based method (Felzenszwalb and Huttenlocher 2004), over edges between 4-neighbours
/// that weigh differences of colour, normal and depth.
IdImage picture_segments(const PictureSegmentOptions& options, const SurfacePicture& picture);

}  // namespace pliant

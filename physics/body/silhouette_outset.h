#pragma once

#include <vector>

#include "gaussians/render/render.h"

namespace pliant {

/// How far the surface of an object lies outside of the centres of its Gaussians, scene units: the distance at which
/// the solid of fill_interior has the silhouettes that the object has in its pictures.  The rasteriser widens every
/// Gaussian by a low-pass filter of half a pixel, so trained ones draw back from silhouettes until their pictures agree
/// with the photos; the body is as large as its pictures.  0 where too little of a silhouette is seen.
float silhouette_outset(const GaussianCloud& object, const std::vector<Camera>& cameras,
                        const RenderOptions& options = {});

}  // namespace pliant

#pragma once

#include <vector>

#include "gaussians/base/gaussian_cloud.h"

namespace pliant {

/// A piece of an object's surface, made from one of its Gaussians.
struct Surfel {
  Vec3f position, normal;  ///< the normal points to the more open side
  float area = 0;          ///< of the closed surface that it stands for
  float sheet_area = 0;    ///< the same if it is part of a thin sheet, whose two sides are one
  float side = 0;          ///< share of rays that escape in front minus that behind; near 0 for a sheet
  Vec3f extent[2] = {Vec3f::Zero(), Vec3f::Zero()};  ///< its Gaussian's two largest principal axes, each as long as one
                                                     ///< standard deviation; those across, if it is part of a strand
  Vec3f along = Vec3f::Zero();  ///< the same along the strand that it is part of (strands.h); zero = of none
  float thickness = 0;  ///< of the layer of Gaussians around it, that of a slab with their spread; of a strand, so that
                        ///< its volume is sheet_area * thickness

  /// Surfels that are equally open on both sides bound nothing.
  bool one_sided() const { return side >= 0.2f; }
};

struct SurfelOptions {
  float opacity_threshold = 0.1f;
  int max_count = 50000;  ///< more Gaussians than this are thinned out
  float outset = 0;       ///< one-sided surfels lie this far in front of their Gaussians' centres
  uint64_t seed = 0;
};

/// Surfels of the visible Gaussians.  Normals are the least principal axis of the neighbours' mean covariance where
/// they are flat, else of their spread as well; their sides chosen by how far rays get on either side, areas come from
/// the distance of the k-th neighbour on the same side and what is covered of the disc up to it, and do not exceed the
/// Gaussian's own.  Strands that are one Gaussian thick are round rods, which bound nothing.
std::vector<Surfel> make_surfels(const SurfelOptions& options, const GaussianCloud& cloud);

}  // namespace pliant

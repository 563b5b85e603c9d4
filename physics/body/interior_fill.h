#pragma once

#include "gaussians/base/gaussian_cloud.h"
#include "physics/body/samples.h"

namespace pliant {

struct FillOptions {
  int target_count = 40000;        ///< samples, approximately
  float opacity_threshold = 0.1f;  ///< Gaussians below this opacity do not bound the solid
  int max_cells = 512;             ///< finest cell: longest side / max_cells
  int max_surfels = 50000;         ///< more Gaussians than this are thinned out
  float outset = 0;  ///< the surface lies this far outside of the Gaussians' centres (silhouette_outset.h)
  uint64_t seed = 0;
};

struct FillSummary {
  double volume = 0;  ///< units^3
  size_t samples = 0;
  size_t thin_samples = 0;  ///< samples of parts too thin to have an inside that the grid resolves
  float cell = 0;           ///< side of the grid's cells, units
};

/// Fills an object that is known by the Gaussians on its surface with stratified samples.  Inside is where the
/// generalised winding number of the splats, taken as oriented discs (Jacobson et al. 2013; Barill et al. 2018),
/// exceeds 1/2, so that open bottoms do not leak; the volume is that of the inside fraction of cells.  Parts without
/// an inside (leaves) are sampled along the Gaussians themselves with their thickness.  Deterministic for a seed.
/// Throws Error{kUsage} when the object has no visible Gaussian.
SolidSamples fill_interior(const FillOptions& options, const GaussianCloud& object, FillSummary* summary = nullptr);

}  // namespace pliant

#pragma once

#include "segmentation/field/semantic_field.h"

namespace pliant {

/// Variance [px^2] of the low-pass filter with which the masks are explained best.  Masks are drawn with sharp edges;
/// the filter of the colour rasteriser makes what is opaque stand out over its silhouette, unless the Gaussians were
/// trained to stay inside, with this filter and at this size of pictures.  Short fits to a few views tell, by
/// their wrong pixels in other ones: from options.render.screen_variance on, steps of a factor of sqrt(2), either way,
/// as long as these become fewer.  Where they say nothing and the scene was trained on these views, it is one step
/// finer. `masks` holds training views only; `progress` is called with iteration 0 throughout.
double best_label_filter(const SemanticOptions& options, const GaussianCloud& cloud, const std::vector<Camera>& cameras,
                         const MaskSet& masks, const SemanticProgress& progress = {});

}  // namespace pliant

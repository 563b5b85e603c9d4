#pragma once

#include "gaussians/base/image.h"
#include "segmentation/lift/gesture.h"

namespace pliant {

/// selection.png: the selection from 8 sides, the object tinted, what each rule removed in a colour of its own, and a
/// caption with the counts.  `up` is the scene's unit up.
ImageF selection_sheet(const GestureResult& result, const GaussianCloud& cloud, const Eigen::Vector3d& up,
                       const RenderOptions& options = {});

}  // namespace pliant

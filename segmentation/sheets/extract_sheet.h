#pragma once

#include "gaussians/base/image.h"
#include "gaussians/render/render.h"
#include "segmentation/objects/extract.h"

namespace pliant {

/// extract.png: the object from 8 sides, tinted, and what each rule took or gave in a colour of its own.
ImageF extract_sheet(const ExtractResult& result, const GaussianCloud& cloud, const Eigen::Vector3d& up,
                     const RenderOptions& options);

}  // namespace pliant

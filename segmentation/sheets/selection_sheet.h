#pragma once

#include "gaussians/base/image.h"
#include "segmentation/select/gesture.h"
#include "segmentation/sheets/sides_sheet.h"

namespace pliant {

/// selection.png: the selection from the 8 sides of sheet_sides, the object tinted, what each rule removed in a colour
/// of its own, and a caption with the counts.
ImageF selection_sheet(const GestureResult& result, const GaussianCloud& cloud, const std::vector<Camera>& sides,
                       const RenderOptions& options = {});

}  // namespace pliant

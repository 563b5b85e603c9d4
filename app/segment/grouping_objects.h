#pragma once

#include <filesystem>

#include "gaussians/io/scene/scene.h"
#include "segmentation/labels/segmentation.h"

namespace pliant {

/// What a trained Gaussian Grouping model knows: its obj_dc_* of `scene` as attribute and its classifier, both as they
/// are. Ids are its classes; 0, what its masks left unlabelled, is "background".  Classes that no Gaussian has are left
/// out. `labels` (JSON object id -> name) may be empty.  Throws Error{kInput} when the splats have no attribute of 16
/// channels.
Segmentation grouping_objects(const Scene& scene, const std::filesystem::path& classifier,
                              const std::filesystem::path& labels);

}  // namespace pliant

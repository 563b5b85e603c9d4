#pragma once

#include "gaussians/base/image.h"
#include "gaussians/io/scene.h"
#include "segmentation/lift/segmentation.h"

namespace pliant {

/// The photo of a camera at the camera's size; where there is none, a render of the scene stands in.
ImageF photo_or_render(const Scene& scene, int camera);

/// The camera that shows the most of all objects' boxes.
int representative_view(const std::vector<ObjectEntry>& objects, const Scene& scene);

}  // namespace pliant

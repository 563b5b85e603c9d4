#pragma once

#include "gaussians/base/image.h"
#include "gaussians/io/scene/scene.h"

namespace pliant {

/// The photo of a camera at the camera's size; where there is none, a render of the scene stands in.
ImageF photo_or_render(const Scene& scene, int camera);

/// Whether every camera has its photo.
bool all_photographed(const Scene& scene);

}  // namespace pliant

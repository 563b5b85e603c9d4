#pragma once

#include <vector>

#include "gaussians/base/image.h"
#include "gaussians/io/scene/scene.h"

namespace pliant {

/// The photo of a camera at the camera's size; where there is none, a render of the scene stands in.
ImageF photo_or_render(const Scene& scene, int camera);

/// Whether every camera has its photo.
bool all_photographed(const Scene& scene);

/// The cameras in the order of a sequence of photos: by the names of the photos, or of the cameras where a photo is
/// missing, numbers in them as numbers.
std::vector<int> photo_sequence(const std::vector<Camera>& cameras);

}  // namespace pliant

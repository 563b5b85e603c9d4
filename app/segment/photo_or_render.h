#pragma once

#include <vector>

#include "gaussians/base/image.h"
#include "gaussians/io/scene/scene.h"

namespace pliant {

/// The photo of a camera at the camera's size, turned by its EXIF orientation where it only fits so; where there is
/// none, a render of the scene stands in.  A photo that cannot be read or has another size is an Error{kInput}.
ImageF photo_or_render(const Scene& scene, int camera);
/// The render that stands in.
ImageF render_for_photo(const Scene& scene, int camera);

/// Whether every camera has its photo.
bool all_photographed(const Scene& scene);

/// The cameras in the order of a sequence of photos: by the names of the photos, or of the cameras where a photo is
/// missing, numbers in them as numbers.
std::vector<int> photo_sequence(const std::vector<Camera>& cameras);

}  // namespace pliant

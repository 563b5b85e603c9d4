#include "app/segment/photo_or_render.h"

#include <algorithm>
#include <filesystem>

#include "gaussians/base/error.h"
#include "gaussians/io/images/image_io.h"
#include "gaussians/render/render.h"

namespace pliant {

ImageF photo_or_render(const Scene& scene, int index) {
  const Camera& camera = scene.cameras[index];
  if (!camera.photo.empty() && std::filesystem::exists(camera.photo)) {
    ImageF photo = read_image(camera.photo);
    if (photo.width != camera.width || photo.height != camera.height)
      throw input_error(camera.photo, "",
                        std::to_string(photo.width) + "x" + std::to_string(photo.height) + " pixels, its camera has " +
                            std::to_string(camera.width) + "x" + std::to_string(camera.height),
                        "correct w and h in the camera file");
    return photo;
  }
  RenderOptions options;
  options.antialiased = scene.report.antialiased;
  return render(scene.cloud, camera, options).color;
}

bool all_photographed(const Scene& scene) {
  return std::all_of(scene.cameras.begin(), scene.cameras.end(),
                     [](const Camera& camera) { return std::filesystem::exists(camera.photo); });
}

}  // namespace pliant

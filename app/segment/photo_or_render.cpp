#include "app/segment/photo_or_render.h"

#include <algorithm>
#include <filesystem>
#include <numeric>

#include "gaussians/base/error.h"
#include "gaussians/io/files/number_order.h"
#include "gaussians/io/images/image_io.h"
#include "gaussians/io/images/photo.h"
#include "gaussians/render/render.h"

namespace pliant {

ImageF photo_or_render(const Scene& scene, int index) {
  const Camera& camera = scene.cameras[index];
  if (!camera.photo.empty() && std::filesystem::exists(camera.photo)) {
    ImageF photo = read_image(camera.photo);
    // A camera that only the upright picture fits is that of the upright picture.
    if (photo.width != camera.width && photo.width == camera.height && photo.height == camera.width)
      if (const int orientation = read_photo_head(camera.photo).orientation; orientation >= 5)
        photo = oriented(photo, orientation);
    if (photo.width != camera.width || photo.height != camera.height)
      throw input_error(camera.photo, "",
                        std::to_string(photo.width) + "x" + std::to_string(photo.height) + " pixels, its camera has " +
                            std::to_string(camera.width) + "x" + std::to_string(camera.height),
                        "correct w and h in the camera file");
    return photo;
  }
  return render_for_photo(scene, index);
}

ImageF render_for_photo(const Scene& scene, int index) {
  RenderOptions options;
  options.antialiased = scene.report.antialiased;
  options.background = scene.settings.background_color();
  return render(scene.cloud, scene.cameras[index], options).color;
}

bool all_photographed(const Scene& scene) {
  return std::all_of(scene.cameras.begin(), scene.cameras.end(),
                     [](const Camera& camera) { return std::filesystem::exists(camera.photo); });
}

std::vector<int> photo_sequence(const std::vector<Camera>& cameras) {
  const bool photos =
      std::all_of(cameras.begin(), cameras.end(), [](const Camera& camera) { return !camera.photo.empty(); });
  const auto name = [&](int c) { return photos ? cameras[c].photo : cameras[c].name; };
  std::vector<int> order(cameras.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return number_order(name(a), name(b)); });
  return order;
}

}  // namespace pliant

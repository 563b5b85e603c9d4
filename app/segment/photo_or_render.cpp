#include "app/segment/photo_or_render.h"

#include <algorithm>
#include <filesystem>
#include <numeric>

#include "gaussians/base/error.h"
#include "gaussians/io/files/number_order.h"
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
  options.background = scene.settings.background_color();
  return render(scene.cloud, camera, options).color;
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

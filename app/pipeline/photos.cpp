#include "app/pipeline/photos.h"

#include <filesystem>

#include "gaussians/base/error.h"
#include "gaussians/io/image_io.h"
#include "gaussians/render/render.h"

namespace pliant {

ImageF photo_or_render(const Scene& scene, int index) {
  const Camera& camera = scene.cameras[index];
  if (!camera.photo.empty() && std::filesystem::exists(camera.photo)) {
    ImageF photo = read_image(camera.photo);
    if (photo.width != camera.width || photo.height != camera.height)
      throw input_error(camera.photo, "", std::to_string(photo.width) + "x" + std::to_string(photo.height) + " pixels, its camera has " +
                                              std::to_string(camera.width) + "x" + std::to_string(camera.height),
                        "correct w and h in the camera file");
    return photo;
  }
  RenderOptions options;
  options.antialiased = scene.report.antialiased;
  return render(scene.cloud, camera, options).color;
}

int representative_view(const std::vector<ObjectEntry>& objects, const Scene& scene) {
  int best = 0, best_seen = -1;
  for (size_t c = 0; c < scene.cameras.size(); ++c) {
    const Camera& camera = scene.cameras[c];
    int seen = 0;
    for (const ObjectEntry& object : objects) {
      for (int corner = 0; corner < 8; ++corner) {
        const Box& b = object.bounds;
        const Eigen::Vector3d x(corner & 1 ? b.low.x() : b.high.x(), corner & 2 ? b.low.y() : b.high.y(), corner & 4 ? b.low.z() : b.high.z());
        const Eigen::Vector3d p = camera.cam_from_world * x;
        const double u = camera.fx * p.x() / p.z() + camera.cx, v = camera.fy * p.y() / p.z() + camera.cy;
        seen += p.z() > 0 && u >= 0 && u < camera.width && v >= 0 && v < camera.height;
      }
    }
    if (seen > best_seen) best = static_cast<int>(c), best_seen = seen;
  }
  return best;
}

}  // namespace pliant

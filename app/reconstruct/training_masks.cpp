#include "app/reconstruct/training_masks.h"

#include <cmath>
#include <map>

#include "gaussians/base/lens.h"

namespace pliant {

/// The ids that a pinhole camera sees, from a picture of ids of a camera with a lens in the same place: the nearest
/// pixel.
IdImage ids_through_pinhole(const IdImage& ids, const Camera& lens, const Camera& pinhole) {
  IdImage out(pinhole.width, pinhole.height, 1);
  const double sx = static_cast<double>(ids.width) / lens.width, sy = static_cast<double>(ids.height) / lens.height;
  for (int y = 0; y < out.height; ++y) {
    for (int x = 0; x < out.width; ++x) {
      const Eigen::Vector2d ray((x + 0.5 - pinhole.cx) / pinhole.fx, (y + 0.5 - pinhole.cy) / pinhole.fy);
      const Eigen::Vector2d seen = distort(lens.distortion, ray);
      const double u = std::floor((lens.fx * seen.x() + lens.cx) * sx),
                   v = std::floor((lens.fy * seen.y() + lens.cy) * sy);
      if (u >= 0 && v >= 0 && u < ids.width && v < ids.height)
        out(x, y) = ids(static_cast<int>(u), static_cast<int>(v));
    }
  }
  return out;
}

MaskSet training_masks(const std::filesystem::path& folder, const std::filesystem::path& labels,
                       const CameraFile& cameras, const TrainingPhotos& photos) {
  std::map<std::string, int> photo_named;
  for (size_t i = 0; i < photos.photos.size(); ++i) photo_named[photos.photos[i].camera.name] = static_cast<int>(i);
  std::vector<int> photo_of;  // -1 = cannot be used
  for (const Camera& camera : cameras.cameras) {
    const auto photo = photo_named.find(camera.name);
    photo_of.push_back(photo == photo_named.end() ? -1 : photo->second);
  }
  MaskSet masks = load_masks(folder, labels, cameras.cameras, [&](const IdImage& ids, int camera) {
    const int photo = photo_of[camera];
    return photo < 0 ? IdImage() : ids_through_pinhole(ids, cameras.cameras[camera], photos.photos[photo].camera);
  });
  for (MaskSet::View& view : masks.views) view.camera = photo_of[view.camera];
  std::erase_if(masks.views, [](const MaskSet::View& view) { return view.camera < 0; });
  return masks;
}

}  // namespace pliant

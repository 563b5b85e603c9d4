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
  MaskSet masks = load_masks(folder, labels, cameras.cameras);
  std::map<std::string, int> photo_named;
  for (size_t i = 0; i < photos.photos.size(); ++i) photo_named[photos.photos[i].camera.name] = static_cast<int>(i);
  std::vector<MaskSet::View> views;
  for (const MaskSet::View& view : masks.views) {
    const Camera& lens = cameras.cameras[view.camera];
    const auto photo = photo_named.find(lens.name);
    if (photo == photo_named.end()) continue;  // a photo that cannot be used
    views.push_back({photo->second, ids_through_pinhole(view.ids, lens, photos.photos[photo->second].camera)});
  }
  masks.views = std::move(views);
  return masks;
}

}  // namespace pliant

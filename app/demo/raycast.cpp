#include "app/demo/raycast.h"

#include "gaussians/base/portable.h"

namespace pliant {

DemoPhoto take_photo(const Stage& stage, const Camera& camera) {
  DemoPhoto photo{ImageF(camera.width, camera.height, 3), IdImage(camera.width, camera.height, 1)};
  const Vec3d eye = camera.centre();
  parallel_for(
      camera.height,
      [&](std::ptrdiff_t row) {
        const int y = static_cast<int>(row);
        for (int x = 0; x < camera.width; ++x) {
          Vec3d sum = Vec3d::Zero();
          for (int s = 0; s < kSamplesAcross * kSamplesAcross; ++s) {
            const Ray ray{eye, camera.ray(sample_at(x, s % kSamplesAcross), sample_at(y, s / kSamplesAcross))};
            const StageHit hit = stage.cast(ray);
            sum += stage.colour(ray, hit);
            const bool centre = s == kSamplesAcross * kSamplesAcross / 2;
            if (centre && hit.part >= 0) photo.ids(x, y) = stage.parts()[hit.part].id;
          }
          for (int c = 0; c < 3; ++c)
            photo.color(x, y, c) = static_cast<float>(sum[c] / (kSamplesAcross * kSamplesAcross));
        }
      },
      4);
  return photo;
}

}  // namespace pliant

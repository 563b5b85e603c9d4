#pragma once

#include "gaussians/base/orbit.h"
#include "gaussians/base/random.h"
#include "gaussians/reconstruct/trainer.h"

namespace pliant {

/// A ball of opaque coloured Gaussians of radius 1 around the origin.
inline GaussianCloud painted_ball(int n, uint64_t seed) {
  GaussianCloud cloud;
  cloud.resize(n);
  for (int i = 0; i < n; ++i) {
    Random random(seed, i);
    const Vec3f direction = Vec3f(random.normal(), random.normal(), random.normal()).normalized();
    cloud.position[i] = direction;
    cloud.log_scale[i].setConstant(std::log(2.0f / std::sqrt(static_cast<float>(n))));
    cloud.opacity_logit[i] = 3;
    for (int c = 0; c < 3; ++c) cloud.sh_of(i)[c] = 1.2f * std::sin(3 * direction[c] + c);
  }
  return cloud;
}

/// Photos of a cloud from a ring of cameras around the origin; every 4th is held out.
inline TrainingPhotos photos_of(const GaussianCloud& cloud, int count, int width, int height) {
  TrainingPhotos photos;
  for (int i = 0; i < count; ++i) {
    TrainingPhoto photo;
    const double angle = 6.283185307179586 * i / count;
    photo.camera = look_at({3.5 * std::cos(angle), 3.5 * std::sin(angle), i % 3 - 1.0}, {0, 0, 0}, {0, 0, 1}, width,
                           height, 1.3 * width);
    photo.camera.name = "photo_" + std::to_string(i);
    const ImageF picture = render(cloud, photo.camera).color;
    photo.pixels = ImageU8(width, height, 3);
    for (size_t k = 0; k < picture.data.size(); ++k)
      photo.pixels.data[k] = static_cast<uint8_t>(std::clamp(picture.data[k], 0.0f, 1.0f) * 255 + 0.5f);
    photo.held_out = i % 4 == 0;
    photos.photos.push_back(std::move(photo));
  }
  return photos;
}

inline std::vector<Camera> cameras_of(const TrainingPhotos& photos) {
  std::vector<Camera> cameras;
  for (const TrainingPhoto& photo : photos.photos) cameras.push_back(photo.camera);
  return cameras;
}

}  // namespace pliant

#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "gaussians/base/gaussian_cloud.h"
#include "gaussians/base/random.h"
#include "gaussians/reconstruct/training_photos.h"
#include "gaussians/render/render.h"

namespace pliant {

/// A wavy sheet of small opaque Gaussians of random colours.
inline GaussianCloud textured_sheet(int n = 2500, uint64_t seed = 3) {
  GaussianCloud cloud;
  cloud.resize(n);
  Random random(seed);
  for (int i = 0; i < n; ++i) {
    const double x = random.uniform(-1, 1), y = random.uniform(-1, 1);
    cloud.position[i] = Vec3d(x, y, 0.25 * std::sin(3 * x) * std::cos(2.5 * y)).cast<float>();
    cloud.log_scale[i].setConstant(static_cast<float>(std::log(random.uniform(0.012, 0.04))));
    cloud.opacity_logit[i] = 4;
    for (int c = 0; c < 3; ++c) cloud.sh_of(i)[c] = static_cast<float>((random.uniform() - 0.5) / kSh0);
  }
  return cloud;
}

/// Views on an arc around the sheet, `step` radians from one to the next, in the order of their names.
inline std::vector<Camera> arc_of_cameras(int n, double step = 0.14) {
  std::vector<Camera> cameras;
  for (int i = 0; i < n; ++i) {
    const double angle = step * (i - 0.5 * (n - 1));
    const Eigen::Vector3d eye(2.6 * std::sin(angle), 0.3 - 0.15 * (i % 3), -2.6 * std::cos(angle));
    cameras.push_back(look_at(eye, {0, 0, 0}, {0.1, -1, 0}, 320, 240, 300));
    cameras.back().cx += 3;
    cameras.back().cy -= 2;
    cameras.back().name = "view_" + std::string(1, static_cast<char>('a' + i));
  }
  return cameras;
}

/// Pictures of `cloud` as photos; the first is held out.
inline TrainingPhotos photos_of(const GaussianCloud& cloud, const std::vector<Camera>& cameras) {
  TrainingPhotos photos;
  for (const Camera& camera : cameras) {
    const ImageF picture = render(cloud, camera).color;
    TrainingPhoto photo;
    photo.camera = camera;
    photo.pixels = ImageU8(picture.width, picture.height, 3);
    for (size_t k = 0; k < picture.data.size(); ++k)
      photo.pixels.data[k] = static_cast<uint8_t>(255 * std::min(1.0f, std::max(0.0f, picture.data[k])) + 0.5f);
    photo.held_out = photos.photos.empty();
    photos.photos.push_back(std::move(photo));
  }
  return photos;
}

}  // namespace pliant

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "gaussians/base/error.h"
#include "gaussians/base/portable.h"
#include "gaussians/reconstruct/exposure.h"
#include "gaussians/reconstruct/trainer.h"

namespace pliant {
namespace {

/// Bytes as numbers in [0, 1], area-averaged to the given size.
ImageF averaged(const ImageU8& image, int width, int height) {
  const cv::Mat from(image.height, image.width, CV_8UC(image.channels), const_cast<uint8_t*>(image.data.data()));
  ImageF out(width, height, image.channels);
  cv::Mat to(height, width, CV_32FC(image.channels), out.data.data());
  if (width == image.width && height == image.height) {
    from.convertTo(to, CV_32F, 1.0 / 255);
  } else {
    cv::Mat exact;
    from.convertTo(exact, CV_32F, 1.0 / 255);
    cv::resize(exact, to, to.size(), 0, 0, cv::INTER_AREA);
  }
  CHECK(to.data == reinterpret_cast<uchar*>(out.data.data()));
  return out;
}

}  // namespace

void photo_at_level(const TrainingPhoto& photo, int level, Camera& camera, ImageF& pixels, ImageF& weight) {
  camera = level == 0 ? photo.camera : photo.camera.scaled(1.0 / (1 << level));
  pixels = averaged(photo.pixels, camera.width, camera.height);
  weight = photo.weight.empty() ? ImageF() : averaged(photo.weight, camera.width, camera.height);
}

void change_backdrop(const TrainingPhoto& photo, const Vec3f& from, const Vec3f& to, ImageF& pixels) {
  const ImageF alpha = averaged(photo.alpha, pixels.width, pixels.height);
  for (size_t i = 0; i < alpha.data.size(); ++i)
    for (int c = 0; c < 3; ++c) pixels.data[3 * i + c] += (1 - alpha.data[i]) * (to[c] - from[c]);
}

std::vector<PhotoQuality> held_out_quality(const GaussianCloud& cloud, const TrainingPhotos& photos,
                                           const RenderOptions& options, size_t most) {
  std::vector<const TrainingPhoto*> held_out;
  for (const TrainingPhoto& photo : photos.photos)
    if (photo.held_out) held_out.push_back(&photo);
  const size_t count = most == 0 ? held_out.size() : std::min(most, held_out.size());
  std::vector<PhotoQuality> quality;
  for (size_t i = 0; i < count; ++i) {
    const TrainingPhoto& photo = *held_out[i * held_out.size() / count];
    Camera camera;
    ImageF target, weight;
    photo_at_level(photo, 0, camera, target, weight);
    ImageF picture = render(cloud, camera, options).color;
    for (float& value : picture.data) value = std::clamp(value, 0.0f, 1.0f);
    const ImageF corrected = expose(picture, fit_exposure(picture, target, weight).data());
    quality.push_back({camera.name, psnr_of_mse(mse_loss(picture, target, weight)),
                       ssim(picture, target, weight, SsimWindows::kInside),
                       psnr_of_mse(mse_loss(corrected, target, weight))});
  }
  return quality;
}

}  // namespace pliant

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "gaussians/base/error.h"
#include "gaussians/base/portable.h"
#include "gaussians/reconstruct/exposure.h"
#include "gaussians/reconstruct/trainer.h"

namespace pliant {
namespace {

cv::Mat mat_of(const ImageF& image) {
  return cv::Mat(image.height, image.width, CV_32FC(image.channels), const_cast<float*>(image.data.data()));
}

/// Bytes as numbers in [0, 1].
ImageF numbers_of(const ImageU8& image) {
  const cv::Mat from(image.height, image.width, CV_8UC(image.channels), const_cast<uint8_t*>(image.data.data()));
  ImageF out(image.width, image.height, image.channels);
  cv::Mat to = mat_of(out);
  from.convertTo(to, CV_32F, 1.0 / 255);
  CHECK(to.data == reinterpret_cast<uchar*>(out.data.data()));
  return out;
}

ImageF area_average(ImageF image, int width, int height) {
  if (width == image.width && height == image.height) return image;
  ImageF out(width, height, image.channels);
  cv::Mat to = mat_of(out);
  cv::resize(mat_of(image), to, to.size(), 0, 0, cv::INTER_AREA);
  CHECK(to.data == reinterpret_cast<uchar*>(out.data.data()));
  return out;
}

/// Bytes as numbers in [0, 1], area-averaged to the given size as far as pixels count by `weight` (empty = all do); 0
/// where none does.
ImageF averaged(const ImageU8& image, const ImageU8& weight, int width, int height) {
  ImageF all = numbers_of(image);
  if (weight.empty() || (width == image.width && height == image.height))
    return area_average(std::move(all), width, height);
  const ImageF counts = numbers_of(weight);
  for (size_t i = 0; i < all.data.size(); ++i) all.data[i] *= counts.data[i / image.channels];
  ImageF out = area_average(std::move(all), width, height);
  const ImageF share = area_average(counts, width, height);
  for (size_t i = 0; i < out.data.size(); ++i) {
    const float counted = share.data[i / image.channels];
    out.data[i] = counted > 0 ? out.data[i] / counted : 0;
  }
  return out;
}

}  // namespace

void photo_at_level(const TrainingPhoto& photo, int level, Camera& camera, ImageF& pixels, ImageF& weight) {
  camera = level == 0 ? photo.camera : photo.camera.scaled(1.0 / (1 << level));
  pixels = averaged(photo.pixels, photo.weight, camera.width, camera.height);
  weight = photo.weight.empty() ? ImageF() : averaged(photo.weight, {}, camera.width, camera.height);
}

void change_backdrop(const TrainingPhoto& photo, const Vec3f& from, const Vec3f& to, ImageF& pixels) {
  const ImageF alpha = averaged(photo.alpha, photo.weight, pixels.width, pixels.height);
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
                       ssim(picture, target, weight, SsimWindows::kInside, ZeroWeight::kUnknown),
                       psnr_of_mse(mse_loss(corrected, target, weight))});
  }
  return quality;
}

}  // namespace pliant

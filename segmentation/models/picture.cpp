#include "segmentation/models/picture.h"

#include <algorithm>
#include <cmath>

#include "gaussians/base/error.h"
#include "gaussians/base/portable.h"

namespace pliant {
namespace {

/// Weights of the input pixels first, first + 1, ... in one output pixel.
struct Taps {
  int first = 0;
  std::vector<float> weights;
};

std::vector<Taps> taps_of(int from, int to) {
  const double scale = static_cast<double>(from) / to, reach = std::max(scale, 1.0);
  std::vector<Taps> all(to);
  for (int i = 0; i < to; ++i) {
    const double centre = (i + 0.5) * scale;
    const int first = std::max(0, static_cast<int>(centre - reach + 0.5)),
              last = std::min(from, static_cast<int>(centre + reach + 0.5));
    all[i].first = first;
    double total = 0;
    for (int j = first; j < last; ++j) total += std::max(0.0, 1 - std::abs(j + 0.5 - centre) / reach);
    for (int j = first; j < last; ++j)
      all[i].weights.push_back(static_cast<float>(std::max(0.0, 1 - std::abs(j + 0.5 - centre) / reach) / total));
  }
  return all;
}

}  // namespace

ImageF resize_picture(const ImageF& picture, int width, int height) {
  CHECK(width > 0 && height > 0 && !picture.empty());
  const int channels = picture.channels;
  const std::vector<Taps> across = taps_of(picture.width, width), down = taps_of(picture.height, height);
  ImageF rows(width, picture.height, channels), out(width, height, channels);
  parallel_for(picture.height, [&](std::ptrdiff_t y) {
    for (int x = 0; x < width; ++x)
      for (size_t k = 0; k < across[x].weights.size(); ++k)
        for (int c = 0; c < channels; ++c)
          rows(x, static_cast<int>(y), c) +=
              across[x].weights[k] * picture(across[x].first + static_cast<int>(k), static_cast<int>(y), c);
  });
  parallel_for(height, [&](std::ptrdiff_t y) {
    for (size_t k = 0; k < down[y].weights.size(); ++k) {
      const float* in = rows.at(0, down[y].first + static_cast<int>(k));
      float* sum = out.at(0, static_cast<int>(y));
      for (int i = 0; i < width * channels; ++i) sum[i] += down[y].weights[k] * in[i];
    }
  });
  return out;
}

Fitted fit_picture(const ImageF& picture, int width, int height, float padding) {
  const double scale =
      std::min(static_cast<double>(width) / picture.width, static_cast<double>(height) / picture.height);
  Fitted fitted;
  fitted.width = std::clamp(static_cast<int>(std::lround(picture.width * scale)), 1, width);
  fitted.height = std::clamp(static_cast<int>(std::lround(picture.height * scale)), 1, height);
  fitted.scale_x = static_cast<float>(fitted.width) / picture.width;
  fitted.scale_y = static_cast<float>(fitted.height) / picture.height;
  const ImageF small = resize_picture(picture, fitted.width, fitted.height);
  fitted.picture = ImageF(width, height, picture.channels, padding);
  for (int y = 0; y < small.height; ++y)
    std::copy_n(small.at(0, y), small.width * small.channels, fitted.picture.at(0, y));
  return fitted;
}

Normalisation Normalisation::imagenet() { return {{123.675f, 116.28f, 103.53f}, {58.395f, 57.12f, 57.375f}, false}; }

Tensor to_planes(const ImageF& picture, const Normalisation& normalisation) {
  CHECK(picture.channels == 3);
  Tensor planes = Tensor::floats({1, 3, picture.height, picture.width});
  const size_t pixels = picture.pixels();
  for (int c = 0; c < 3; ++c) {
    const int from = normalisation.bgr ? 2 - c : c;
    for (size_t i = 0; i < pixels; ++i)
      planes.values[c * pixels + i] =
          (255 * picture.data[i * 3 + from] - normalisation.mean[from]) / normalisation.deviation[from];
  }
  return planes;
}

}  // namespace pliant

#include "segmentation/models/lama.h"

#include <algorithm>
#include <cmath>

#include "gaussians/base/error.h"
#include "segmentation/models/picture.h"

namespace pliant {
namespace {

struct Window {
  int x, y, width, height;
};

template <class T>
Image<T> cut(const Image<T>& image, const Window& window) {
  Image<T> part(window.width, window.height, image.channels);
  for (int y = 0; y < window.height; ++y)
    std::copy_n(image.at(window.x, window.y + y), window.width * image.channels, part.at(0, y));
  return part;
}

/// The hole with its surroundings; empty where there is no hole.
Window surroundings(const ImageU8& mask, double context) {
  int x0 = mask.width, y0 = mask.height, x1 = 0, y1 = 0;
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x)
      if (mask(x, y)) {
        x0 = std::min(x0, x);
        x1 = std::max(x1, x + 1);
        y0 = std::min(y0, y);
        y1 = std::max(y1, y + 1);
      }
  if (x0 >= x1) return {0, 0, 0, 0};
  const int grow = std::max(64, static_cast<int>(context * std::max(x1 - x0, y1 - y0)));
  x0 = std::max(0, x0 - grow);
  y0 = std::max(0, y0 - grow);
  x1 = std::min(mask.width, x1 + grow);
  y1 = std::min(mask.height, y1 + grow);
  return {x0, y0, x1 - x0, y1 - y0};
}

/// Index inside [0, n) of a sequence that goes on mirrored, edge pixels twice.
int mirrored(int i, int n) {
  const int period = i % (2 * n);
  return period < n ? period : 2 * n - 1 - period;
}

/// Beginnings of tiles of `tile` that cover `length` and overlap by at least `overlap`.
std::vector<int> tile_starts(int length, int tile, int overlap) {
  if (length <= tile) return {0};
  const int count = (length - overlap + tile - overlap - 1) / (tile - overlap);
  std::vector<int> starts(count);
  for (int i = 0; i < count; ++i) starts[i] = static_cast<int>(static_cast<int64_t>(length - tile) * i / (count - 1));
  return starts;
}

}  // namespace

Lama::Lama(std::unique_ptr<NeuralModule> module, const Options& options)
    : module_(std::move(module)), options_(options) {
  const ModelFile& file = module_->file();
  fixed_height_ = file.size_of("height", 0);
  fixed_width_ = file.size_of("width", fixed_height_);
  range_ = file.size_of("range", 1);
  if (fixed_width_) options_.tile = std::min({options_.tile, fixed_width_, fixed_height_});
  options_.overlap = std::min(options_.overlap, options_.tile / 4);
  contract_.inputs = {{"image", Tensor::Type::kFloat32, "1,3,h,w", 0, 1, "red first, zero where the hole is"},
                      {"mask", Tensor::Type::kFloat32, "1,1,h,w", 0, 1, "1 = hole"}};
  const double slack = 0.01 * range_;  // of rounding
  contract_.outputs = {{"inpainted", Tensor::Type::kFloat32, "1,3,h,w", -slack, range_ + slack, "red first"}};
  if (file.format == ModelFile::Format::kOnnx && file.graph.outputs.size() == 1)
    contract_.outputs[0].name = file.graph.outputs[0].name;
  module_->verify(contract_, {{"h", fixed_height_ ? fixed_height_ : 64}, {"w", fixed_width_ ? fixed_width_ : 72}});
}

ImageF Lama::inpaint(const ImageF& picture, const ImageU8& mask) {
  CHECK(picture.channels == 3 && mask.width == picture.width && mask.height == picture.height);
  const Window window = surroundings(mask, options_.context);
  ImageF out = picture;
  if (window.width == 0) return out;
  const ImageF part = cut(picture, window);
  const ImageU8 hole = cut(mask, window);
  const bool small = std::max(window.width, window.height) <= options_.tile;
  const ImageF filled = small ? fill(part, hole) : fill_by_tiles(part, hole);
  for (int y = 0; y < window.height; ++y)
    for (int x = 0; x < window.width; ++x)
      if (hole(x, y)) std::copy_n(filled.at(x, y), 3, out.at(window.x + x, window.y + y));
  return out;
}

/// One run of the network over a part that fits.
ImageF Lama::fill(const ImageF& picture, const ImageU8& mask) {
  const int width = fixed_width_ ? fixed_width_ : (picture.width + 7) / 8 * 8;
  const int height = fixed_height_ ? fixed_height_ : (picture.height + 7) / 8 * 8;
  Tensor image = Tensor::floats({1, 3, height, width}), hole = Tensor::floats({1, 1, height, width});
  const size_t plane = static_cast<size_t>(width) * height;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const int from_x = mirrored(x, picture.width), from_y = mirrored(y, picture.height);
      const size_t i = static_cast<size_t>(y) * width + x;
      const bool missing = mask(from_x, from_y) != 0;
      hole.values[i] = missing;
      for (int c = 0; c < 3; ++c) image.values[c * plane + i] = missing ? 0 : picture(from_x, from_y, c);
    }
  const Tensor out = module_->run(contract_, {std::move(image), std::move(hole)})[0];
  ImageF filled(picture.width, picture.height, 3);
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x)
      for (int c = 0; c < 3; ++c)
        filled(x, y, c) = std::clamp(out.values[c * plane + static_cast<size_t>(y) * width + x] / range_, 0.f, 1.f);
  return filled;
}

ImageF Lama::fill_by_tiles(const ImageF& picture, const ImageU8& mask) {
  const int tile = options_.tile;
  const double scale = static_cast<double>(tile) / std::max(picture.width, picture.height);
  const int width = std::max(1, static_cast<int>(picture.width * scale)),
            height = std::max(1, static_cast<int>(picture.height * scale));
  ImageF share(mask.width, mask.height, 1);
  for (size_t i = 0; i < share.data.size(); ++i) share.data[i] = mask.data[i] != 0;
  const ImageF small_share = resize_picture(share, width, height);
  ImageU8 small_mask(width, height, 1);
  for (size_t i = 0; i < small_mask.data.size(); ++i) small_mask.data[i] = small_share.data[i] > 1e-4f;
  const ImageF coarse =
      resize_picture(fill(resize_picture(picture, width, height), small_mask), picture.width, picture.height);

  ImageF sum(picture.width, picture.height, 3);
  std::vector<float> weights(picture.pixels());
  for (const int y0 : tile_starts(picture.height, tile, options_.overlap))
    for (const int x0 : tile_starts(picture.width, tile, options_.overlap)) {
      const Window window{x0, y0, std::min(tile, picture.width), std::min(tile, picture.height)};
      const ImageU8 hole = cut(mask, window);
      const auto missing =
          static_cast<size_t>(std::count_if(hole.data.begin(), hole.data.end(), [](uint8_t m) { return m != 0; }));
      if (missing == 0 || 2 * missing > hole.data.size()) continue;
      const ImageF filled = fill(cut(picture, window), hole);
      for (int y = 0; y < window.height; ++y)
        for (int x = 0; x < window.width; ++x) {
          const int edge = std::min({x + 1, y + 1, window.width - x, window.height - y, options_.overlap});
          weights[static_cast<size_t>(y0 + y) * picture.width + x0 + x] += static_cast<float>(edge);
          for (int c = 0; c < 3; ++c) sum(x0 + x, y0 + y, c) += static_cast<float>(edge) * filled(x, y, c);
        }
    }
  for (size_t i = 0; i < weights.size(); ++i)
    for (int c = 0; c < 3; ++c)
      sum.data[i * 3 + c] = weights[i] > 0 ? sum.data[i * 3 + c] / weights[i] : coarse.data[i * 3 + c];
  return sum;
}

}  // namespace pliant

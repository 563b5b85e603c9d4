#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pliant {

/// Image [height, width, channels], row-major, channels interleaved.  Colour is R, G, B; floats are in [0, 1].
/// Pixel (x, y) covers [x, x+1) x [y, y+1) of the image plane; its centre is (x + 0.5, y + 0.5).
template <class T>
struct Image {
  int width = 0, height = 0, channels = 0;
  std::vector<T> data;

  Image() = default;
  Image(int width, int height, int channels, T value = T())
      : width(width), height(height), channels(channels), data(static_cast<size_t>(width) * height * channels, value) {}

  bool empty() const { return data.empty(); }
  size_t pixels() const { return static_cast<size_t>(width) * height; }
  T* at(int x, int y) { return data.data() + (static_cast<size_t>(y) * width + x) * channels; }
  const T* at(int x, int y) const { return data.data() + (static_cast<size_t>(y) * width + x) * channels; }
  T& operator()(int x, int y, int c = 0) { return at(x, y)[c]; }
  const T& operator()(int x, int y, int c = 0) const { return at(x, y)[c]; }
};

using ImageF = Image<float>;
using ImageU8 = Image<uint8_t>;
/// Object id per pixel; 0 = unlabelled.
using IdImage = Image<uint32_t>;

}  // namespace pliant

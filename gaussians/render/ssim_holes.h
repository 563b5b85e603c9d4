#pragma once

#include <algorithm>
#include <vector>

#include "gaussians/render/image_pair.h"
#include "gaussians/render/ssim_rows.h"

namespace pliant {

/// Two images without their pixels of weight 0, for windows whose means are those of the other pixels alone.  Beyond
/// the images all counts, as zeros.
template <class T>
struct SsimHoles {
  Image<T> a, b;   ///< 0 in the holes; empty where there are none
  Image<T> scale;  ///< [H, W, 1] 1 / share of the window around a pixel that is no hole; exactly 1 without holes in it

  explicit SsimHoles(const ImagePair<T>& pair);
  bool empty() const { return a.empty(); }
};

template <class T>
SsimHoles<T>::SsimHoles(const ImagePair<T>& pair) {
  const Image<T>& weight = pair.weight;
  const int width = weight.width, height = weight.height, channels = pair.a.channels;
  if (std::find(weight.data.begin(), weight.data.end(), T(0)) == weight.data.end()) return;
  a = pair.a;
  b = pair.b;
  scale = Image<T>(width, height, 1, T(1));
  // Shares along the rows first, in double: little of a window may be left.
  Image<double> lost(width, height, 1);
  std::vector<char> has_holes(height, 0);
  const auto window = [](int k) { return ssim_rows::kWeight[k < 0 ? -k : k]; };
  constexpr int kReach = ssim_rows::kRadius;
  parallel_for(
      height,
      [&](std::ptrdiff_t row) {
        const int y = static_cast<int>(row);
        for (int x = 0; x < width; ++x) {
          if (weight(x, y) != 0) continue;
          has_holes[y] = 1;
          std::fill_n(a.at(x, y), channels, T(0));
          std::fill_n(b.at(x, y), channels, T(0));
          for (int k = -kReach; k <= kReach; ++k)
            if (x + k >= 0 && x + k < width) lost(x + k, y) += window(k);
        }
      },
      16);
  parallel_for(
      height,
      [&](std::ptrdiff_t row) {
        const int y = static_cast<int>(row);
        std::vector<double> share(width, 1.0);
        for (int k = -kReach; k <= kReach; ++k) {
          if (y + k < 0 || y + k >= height || !has_holes[y + k]) continue;
          for (int x = 0; x < width; ++x) share[x] -= window(k) * lost(x, y + k);
        }
        for (int x = 0; x < width; ++x)
          if (weight(x, y) != 0) scale(x, y) = static_cast<T>(1 / share[x]);
      },
      16);
}

}  // namespace pliant

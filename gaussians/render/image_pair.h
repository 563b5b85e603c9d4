#pragma once

#include <cstddef>
#include <vector>

#include "gaussians/base/error.h"
#include "gaussians/base/portable.h"
#include "gaussians/render/image_loss.h"

namespace pliant {

constexpr int kSsimWindow = 11;

/// Sum in eight interleaved parts, in an order that does not depend on the instruction set.
template <class Value>
double sum_of_row(std::ptrdiff_t n, Value&& value) {
  double part[8] = {};
  std::ptrdiff_t i = 0;
  for (; i + 8 <= n; i += 8)
    for (int k = 0; k < 8; ++k) part[k] += value(i + k);
  for (; i < n; ++i) part[i % 8] += value(i);
  return ((part[0] + part[1]) + (part[2] + part[3])) + ((part[4] + part[5]) + (part[6] + part[7]));
}

/// Two images and how much each of their values counts.
template <class T>
struct ImagePair {
  const Image<T>&a, &b, &weight;
  SsimWindows windows = SsimWindows::kEveryPixel;

  ImagePair(const Image<T>& a, const Image<T>& b, const Image<T>& weight,
            SsimWindows windows = SsimWindows::kEveryPixel)
      : a(a), b(b), weight(weight), windows(windows) {
    CHECK_MSG(a.width == b.width && a.height == b.height && a.channels == b.channels, "images of the same size");
    CHECK_MSG(!a.empty(), "images with pixels");
    CHECK_MSG(weight.empty() || (weight.width == a.width && weight.height == a.height && weight.channels == 1),
              "one weight per pixel");
    CHECK_MSG(windows == SsimWindows::kEveryPixel || (a.width >= kSsimWindow && a.height >= kSsimWindow),
              "images of at least 11 x 11 pixels");
  }

  std::ptrdiff_t row_size() const { return static_cast<std::ptrdiff_t>(a.width) * a.channels; }

  /// Weights of the values of row y.
  void fill_weights(int y, T* out) const {
    const int border = windows == SsimWindows::kInside ? kSsimWindow / 2 : 0;
    const bool outside = y < border || y >= a.height - border;
    for (int x = 0; x < a.width; ++x) {
      const bool counts = !outside && x >= border && x < a.width - border;
      const T w = counts ? (weight.empty() ? T(1) : weight(x, y)) : T(0);
      for (int c = 0; c < a.channels; ++c) *out++ = w;
    }
  }

  /// 1 / sum of all weights, 0 when there are none.
  double inverse_total() const {
    double total = 0;
    if (weight.empty()) {
      const int border = windows == SsimWindows::kInside ? kSsimWindow - 1 : 0;
      total = static_cast<double>(a.width - border) * (a.height - border) * a.channels;
    } else {
      std::vector<double> rows(a.height);
      parallel_for(
          a.height,
          [&](std::ptrdiff_t y) {
            std::vector<T> w(row_size());
            fill_weights(static_cast<int>(y), w.data());
            rows[y] = sum_of_row(row_size(), [&](std::ptrdiff_t i) { return static_cast<double>(w[i]); });
          },
          16);
      for (const double row : rows) total += row;
    }
    return total > 0 ? 1 / total : 0;
  }

  /// Weighted mean of term(difference a - b) over all values.
  template <class Term>
  double mean(Term&& term) const {
    std::vector<double> rows(a.height);
    parallel_for(
        a.height,
        [&](std::ptrdiff_t y) {
          std::vector<T> w(row_size());
          fill_weights(static_cast<int>(y), w.data());
          const T *p = a.at(0, static_cast<int>(y)), *q = b.at(0, static_cast<int>(y));
          rows[y] = sum_of_row(row_size(), [&](std::ptrdiff_t i) {
            return static_cast<double>(w[i]) * term(static_cast<double>(p[i]) - static_cast<double>(q[i]));
          });
        },
        16);
    double total = 0;
    for (const double row : rows) total += row;
    return total * inverse_total();
  }

  /// adj_a = scale * weight * term(difference a - b).
  template <class Term>
  void pointwise_adjoint(double scale, Image<T>& adj_a, Term&& term) const {
    resize_like_a(adj_a);
    const T factor = static_cast<T>(scale * inverse_total());
    parallel_for(
        a.height,
        [&](std::ptrdiff_t y) {
          std::vector<T> w(row_size());
          fill_weights(static_cast<int>(y), w.data());
          const T *p = a.at(0, static_cast<int>(y)), *q = b.at(0, static_cast<int>(y));
          T* adj = adj_a.at(0, static_cast<int>(y));
          for (std::ptrdiff_t i = 0; i < row_size(); ++i) adj[i] = factor * w[i] * term(p[i] - q[i]);
        },
        16);
  }

  void resize_like_a(Image<T>& image) const {
    if (image.width == a.width && image.height == a.height && image.channels == a.channels) return;
    image = Image<T>(a.width, a.height, a.channels);
  }
};

}  // namespace pliant

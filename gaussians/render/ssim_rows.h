#pragma once

#include <cstddef>

namespace pliant::ssim_rows {

// Rows of the structural similarity.  All arrays hold interleaved pixels; a "padded" one has kMargin further pixels of
// zeros on either side of the row, so that windows need no bounds.  Loops run over contiguous values without
// dependence, for the compiler to vectorise.

constexpr int kRadius = 5, kWindow = 2 * kRadius + 1, kMargin = kRadius;
constexpr double kC1 = 0.01 * 0.01, kC2 = 0.03 * 0.03;

/// exp(-k^2 / (2 1.5^2)), k = 0..5, divided by the sum over -5..5.
constexpr double kWeight[kRadius + 1] = {0.2660117248617943,  0.21300553771125366,  0.1093606895097,
                                         0.03600077212843082, 0.007598758135239184, 0.0010283800844791099};

/// Means over a column of 11 pixels, around every value of the middle row: of x, y, x^2 + y^2 and x y.
template <class T>
struct Moments {
  T *x, *y, *squares, *product;
};

template <class T>
inline __attribute__((always_inline)) void column_moments(const T* const* x, const T* const* y, std::ptrdiff_t n,
                                                          const Moments<T>& out) {
  const T *x0 = x[0], *x1 = x[1], *x2 = x[2], *x3 = x[3], *x4 = x[4], *x5 = x[5], *x6 = x[6], *x7 = x[7], *x8 = x[8],
          *x9 = x[9], *x10 = x[10];
  const T *y0 = y[0], *y1 = y[1], *y2 = y[2], *y3 = y[3], *y4 = y[4], *y5 = y[5], *y6 = y[6], *y7 = y[7], *y8 = y[8],
          *y9 = y[9], *y10 = y[10];
#pragma GCC ivdep
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    const T p = x5[i], q = y5[i];
    T mean_x = T(kWeight[0]) * p, mean_y = T(kWeight[0]) * q;
    T s = T(kWeight[0]) * (p * p + q * q), r = T(kWeight[0]) * (p * q);
    const auto add = [&](T w, T a, T b, T c, T d) __attribute__((always_inline)) {
      mean_x += w * (a + b);
      mean_y += w * (c + d);
      s += w * ((a * a + c * c) + (b * b + d * d));
      r += w * (a * c + b * d);
    };
    add(T(kWeight[1]), x4[i], x6[i], y4[i], y6[i]);
    add(T(kWeight[2]), x3[i], x7[i], y3[i], y7[i]);
    add(T(kWeight[3]), x2[i], x8[i], y2[i], y8[i]);
    add(T(kWeight[4]), x1[i], x9[i], y1[i], y9[i]);
    add(T(kWeight[5]), x0[i], x10[i], y0[i], y10[i]);
    out.x[i] = mean_x;
    out.y[i] = mean_y;
    out.squares[i] = s;
    out.product[i] = r;
  }
}

/// Mean along the row around value i of a padded row whose pixels lie `c` values apart.
template <class T>
inline __attribute__((always_inline)) T row_mean(const T* in, std::ptrdiff_t i, std::ptrdiff_t c) {
  return T(kWeight[0]) * in[i] + T(kWeight[1]) * (in[i - c] + in[i + c]) +
         T(kWeight[2]) * (in[i - 2 * c] + in[i + 2 * c]) + T(kWeight[3]) * (in[i - 3 * c] + in[i + 3 * c]) +
         T(kWeight[4]) * (in[i - 4 * c] + in[i + 4 * c]) + T(kWeight[5]) * (in[i - 5 * c] + in[i + 5 * c]);
}

/// dissimilarity[i] = weight[i] (1 - SSIM) from padded column moments.  Means are multiplied by scale[i].
template <class T>
inline __attribute__((always_inline)) void dissimilarity(const Moments<T>& in, const T* weight, const T* scale,
                                                         std::ptrdiff_t n, std::ptrdiff_t c, T* out) {
#pragma GCC ivdep
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    const T x = scale[i] * row_mean(in.x, i, c), y = scale[i] * row_mean(in.y, i, c);
    const T squares = scale[i] * row_mean(in.squares, i, c), product = scale[i] * row_mean(in.product, i, c);
    const T xy = x * y, xx_yy = x * x + y * y;
    const T a1 = 2 * xy + T(kC1), a2 = 2 * (product - xy) + T(kC2);
    const T b1 = xx_yy + T(kC1), b2 = (squares - xx_yy) + T(kC2);
    out[i] = weight[i] * (1 - (a1 * a2) / (b1 * b2));
  }
}

/// The same, and the derivatives of weight[i] SSIM with respect to the three unscaled means that depend on x; `adj.y`
/// is unused.  They are written to padded rows.
template <class T>
inline __attribute__((always_inline)) void dissimilarity_adjoint(const Moments<T>& in, const T* weight, const T* scale,
                                                                 std::ptrdiff_t n, std::ptrdiff_t c, T* out,
                                                                 const Moments<T>& adj) {
#pragma GCC ivdep
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    const T x = scale[i] * row_mean(in.x, i, c), y = scale[i] * row_mean(in.y, i, c);
    const T squares = scale[i] * row_mean(in.squares, i, c), product = scale[i] * row_mean(in.product, i, c);
    const T xy = x * y, xx_yy = x * x + y * y;
    const T a1 = 2 * xy + T(kC1), a2 = 2 * (product - xy) + T(kC2);
    const T b1 = xx_yy + T(kC1), b2 = (squares - xx_yy) + T(kC2);
    const T w = weight[i] * scale[i], inverse = 1 / (b1 * b2), s = (a1 * a2) / (b1 * b2);
    out[i] = weight[i] * (1 - s);
    adj.x[i] = w * (2 * inverse) * (y * (a2 - a1) - s * x * (b2 - b1));
    adj.squares[i] = -w * s * (b1 * inverse);
    adj.product[i] = w * (2 * inverse) * a1;
  }
}

/// Means along the row of three padded rows.
template <class T>
inline __attribute__((always_inline)) void row_means(const Moments<T>& in, std::ptrdiff_t n, std::ptrdiff_t c,
                                                     const Moments<T>& out) {
#pragma GCC ivdep
  for (std::ptrdiff_t i = 0; i < n; ++i) out.x[i] = row_mean(in.x, i, c);
#pragma GCC ivdep
  for (std::ptrdiff_t i = 0; i < n; ++i) out.squares[i] = row_mean(in.squares, i, c);
#pragma GCC ivdep
  for (std::ptrdiff_t i = 0; i < n; ++i) out.product[i] = row_mean(in.product, i, c);
}

/// Derivative with respect to row x: the transposed window, which is the window itself, over the rows of derivatives
/// with respect to means, and scale_l1 weight sign(x - y).  x_mean, squares, product: 11 rows each.
template <class T>
inline __attribute__((always_inline)) void gather_adjoint(const T* const* x_mean, const T* const* squares,
                                                          const T* const* product, const T* x, const T* y,
                                                          const T* weight, T scale_ssim, T scale_l1, std::ptrdiff_t n,
                                                          T* adj) {
#pragma GCC ivdep
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    T m = T(kWeight[0]) * x_mean[5][i], s = T(kWeight[0]) * squares[5][i], p = T(kWeight[0]) * product[5][i];
#pragma GCC unroll 5
    for (int k = 1; k <= kRadius; ++k) {
      m += T(kWeight[k]) * (x_mean[5 - k][i] + x_mean[5 + k][i]);
      s += T(kWeight[k]) * (squares[5 - k][i] + squares[5 + k][i]);
      p += T(kWeight[k]) * (product[5 - k][i] + product[5 + k][i]);
    }
    const T sign = static_cast<T>((x[i] > y[i]) - (x[i] < y[i]));
    adj[i] = scale_ssim * (m + 2 * x[i] * s + y[i] * p) + scale_l1 * weight[i] * sign;
  }
}

}  // namespace pliant::ssim_rows

#include "gaussians/render/image_loss.h"

#include <algorithm>
#include <cmath>

#include "gaussians/base/error.h"
#include "gaussians/base/portable.h"
#include "gaussians/render/ssim_rows.h"

// The row loops are compiled twice and chosen when the program is loaded.  Nothing is fused or reassociated, so both
// give the same bits.
#if defined(__x86_64__) && defined(__linux__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define FOR_EACH_INSTRUCTION_SET __attribute__((target_clones("default", "avx2")))
#else
#define FOR_EACH_INSTRUCTION_SET
#endif

namespace pliant {
namespace {

using ssim_rows::kMargin, ssim_rows::kRadius, ssim_rows::kWindow, ssim_rows::Moments;

/// What one row of the picture needs: pixels of the 11 rows around it, or of their derivatives.
template <class T>
struct Column {
  const T* row[kWindow];
};

// One set of functions per scalar: attributes of this kind do not apply to templates.
#define PLIANT_ROW_FUNCTIONS(T)                                                                                       \
  FOR_EACH_INSTRUCTION_SET void column_moments(const Column<T>& x, const Column<T>& y, std::ptrdiff_t n,              \
                                               const Moments<T>& out) {                                               \
    ssim_rows::column_moments(x.row, y.row, n, out);                                                                  \
  }                                                                                                                   \
  FOR_EACH_INSTRUCTION_SET void dissimilarity(const Moments<T>& in, const T* weight, std::ptrdiff_t n, int c, T* out, \
                                              const Moments<T>* adj) {                                                \
    if (adj && c == 3)                                                                                                \
      ssim_rows::dissimilarity_adjoint(in, weight, n, 3, out, *adj);                                                  \
    else if (adj)                                                                                                     \
      ssim_rows::dissimilarity_adjoint(in, weight, n, c, out, *adj);                                                  \
    else if (c == 3)                                                                                                  \
      ssim_rows::dissimilarity(in, weight, n, 3, out);                                                                \
    else                                                                                                              \
      ssim_rows::dissimilarity(in, weight, n, c, out);                                                                \
  }                                                                                                                   \
  FOR_EACH_INSTRUCTION_SET void row_means(const Moments<T>& in, std::ptrdiff_t n, int c, const Moments<T>& out) {     \
    if (c == 3)                                                                                                       \
      ssim_rows::row_means(in, n, 3, out);                                                                            \
    else                                                                                                              \
      ssim_rows::row_means(in, n, c, out);                                                                            \
  }                                                                                                                   \
  FOR_EACH_INSTRUCTION_SET void gather_adjoint(const Column<T>& x_mean, const Column<T>& squares,                     \
                                               const Column<T>& product, const T* x, const T* y, const T* weight,     \
                                               T scale_ssim, T scale_l1, std::ptrdiff_t n, T* adj) {                  \
    ssim_rows::gather_adjoint(x_mean.row, squares.row, product.row, x, y, weight, scale_ssim, scale_l1, n, adj);      \
  }
PLIANT_ROW_FUNCTIONS(float)
PLIANT_ROW_FUNCTIONS(double)

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
struct Pair {
  const Image<T>&a, &b, &weight;
  SsimWindows windows = SsimWindows::kEveryPixel;

  Pair(const Image<T>& a, const Image<T>& b, const Image<T>& weight, SsimWindows windows = SsimWindows::kEveryPixel)
      : a(a), b(b), weight(weight), windows(windows) {
    CHECK_MSG(a.width == b.width && a.height == b.height && a.channels == b.channels, "images of the same size");
    CHECK_MSG(!a.empty(), "images with pixels");
    CHECK_MSG(weight.empty() || (weight.width == a.width && weight.height == a.height && weight.channels == 1),
              "one weight per pixel");
    CHECK_MSG(windows == SsimWindows::kEveryPixel || (a.width >= kWindow && a.height >= kWindow),
              "images of at least 11 x 11 pixels");
  }

  std::ptrdiff_t row_size() const { return static_cast<std::ptrdiff_t>(a.width) * a.channels; }

  /// Weights of the values of row y.
  void fill_weights(int y, T* out) const {
    const int border = windows == SsimWindows::kInside ? kRadius : 0;
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
      const int border = windows == SsimWindows::kInside ? kWindow - 1 : 0;
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

/// Scratch rows of one thread while it works on a block of image rows.
template <class T>
class RowWorkspace {
 public:
  RowWorkspace(const Pair<T>& pair, bool reverse) : pair_(pair), n_(pair.row_size()) {
    const std::ptrdiff_t margin = kMargin * pair.a.channels;
    stride_ = n_ + 2 * margin;
    // Rows 0..3 hold moments, 4..6 derivatives, 7 weights, 8 values, 9 zeros; then 11 x (3 derivatives, weights).
    rows_.assign(stride_ * (reverse ? kFirstOfRing + 4 * kWindow : kFirstOfRing), T(0));
    data_ = rows_.data() + margin;
    moments_ = {row(0), row(1), row(2), row(3)};
    adj_ = {row(4), nullptr, row(5), row(6)};
  }

  struct Sums {
    double l1 = 0, dissimilarity = 0;
  };

  /// Losses of row y, unscaled.
  Sums forward(int y) { return losses(y, row(7), nullptr); }

  /// Losses of row y; its derivatives with respect to means enter the ring of 11 rows.  Rows outside the image give 0.
  Sums forward_into_ring(int y) {
    const Moments<T> out = {ring(y, 0), nullptr, ring(y, 1), ring(y, 2)};
    if (y < 0 || y >= pair_.a.height) {
      for (int k = 0; k < 3; ++k) std::fill_n(ring(y, k), n_, T(0));
      return {};
    }
    const Sums sums = losses(y, ring(y, 3), &adj_);
    row_means(adj_, n_, pair_.a.channels, out);
    return sums;
  }

  /// Derivatives of row y, once the ring holds rows y - 5 to y + 5.
  void reverse(int y, T scale_ssim, T scale_l1, T* adj) {
    Column<T> column[3];
    for (int k = 0; k < 3; ++k)
      for (int j = 0; j < kWindow; ++j) column[k].row[j] = ring(y + j - kRadius, k);
    gather_adjoint(column[0], column[1], column[2], pair_.a.at(0, y), pair_.b.at(0, y), ring(y, 3), scale_ssim,
                   scale_l1, n_, adj);
  }

 private:
  static constexpr int kFirstOfRing = 10;

  T* row(int k) { return data_ + k * stride_; }
  T* ring(int y, int k) { return row(kFirstOfRing + 4 * ((y + kWindow) % kWindow) + k); }

  Column<T> rows_around(const Image<T>& image, int y) {
    Column<T> column;
    for (int j = 0; j < kWindow; ++j) {
      const int k = y + j - kRadius;
      column.row[j] = k >= 0 && k < image.height ? image.at(0, k) : row(9);
    }
    return column;
  }

  Sums losses(int y, T* weight, const Moments<T>* adj) {
    pair_.fill_weights(y, weight);
    column_moments(rows_around(pair_.a, y), rows_around(pair_.b, y), n_, moments_);
    T* value = row(8);
    dissimilarity(moments_, weight, n_, pair_.a.channels, value, adj);
    const T *p = pair_.a.at(0, y), *q = pair_.b.at(0, y);
    return {sum_of_row(n_, [&](std::ptrdiff_t i) { return static_cast<double>(weight[i] * std::abs(p[i] - q[i])); }),
            sum_of_row(n_, [&](std::ptrdiff_t i) { return static_cast<double>(value[i]); })};
  }

  const Pair<T>& pair_;
  std::ptrdiff_t n_, stride_;
  std::vector<T> rows_;
  T* data_;
  Moments<T> moments_, adj_;
};

/// L1 and D-SSIM; with `adj_a` also the derivative of adj_l1 * L1 + adj_dssim * D-SSIM.  Blocks of rows are
/// independent: each computes the derivatives with respect to means of 5 further rows on either side anew.
template <class T>
PhotometricLoss both_losses(const Pair<T>& pair, double adj_l1 = 0, double adj_dssim = 0, Image<T>* adj_a = nullptr) {
  constexpr int kBlockRows = 50;
  const int height = pair.a.height;
  const double inverse = pair.inverse_total();
  if (adj_a) pair.resize_like_a(*adj_a);
  std::vector<typename RowWorkspace<T>::Sums> rows(height);
  parallel_for((height + kBlockRows - 1) / kBlockRows, [&](std::ptrdiff_t block) {
    RowWorkspace<T> workspace(pair, adj_a != nullptr);
    const int begin = static_cast<int>(block) * kBlockRows, end = std::min(begin + kBlockRows, height);
    if (!adj_a) {
      for (int y = begin; y < end; ++y) rows[y] = workspace.forward(y);
      return;
    }
    for (int y = begin - kRadius; y < end + kRadius; ++y) {
      const auto sums = workspace.forward_into_ring(y);
      if (y >= begin && y < end) rows[y] = sums;
      if (y >= begin + kRadius)
        workspace.reverse(y - kRadius, static_cast<T>(-adj_dssim * inverse), static_cast<T>(adj_l1 * inverse),
                          adj_a->at(0, y - kRadius));
    }
  });
  PhotometricLoss loss;
  for (const auto& row : rows) loss.l1 += row.l1, loss.dssim += row.dissimilarity;
  loss.l1 *= inverse, loss.dssim *= inverse;
  return loss;
}

}  // namespace

template <class T>
double l1_loss(const Image<T>& a, const Image<T>& b, const Image<T>& weight) {
  return Pair<T>(a, b, weight).mean([](double d) { return std::abs(d); });
}

template <class T>
void l1_loss_adjoint(const Image<T>& a, const Image<T>& b, const Image<T>& weight, double adj_loss, Image<T>& adj_a) {
  Pair<T>(a, b, weight).pointwise_adjoint(adj_loss, adj_a, [](T d) { return static_cast<T>((d > 0) - (d < 0)); });
}

template <class T>
double mse_loss(const Image<T>& a, const Image<T>& b, const Image<T>& weight) {
  return Pair<T>(a, b, weight).mean([](double d) { return d * d; });
}

template <class T>
void mse_loss_adjoint(const Image<T>& a, const Image<T>& b, const Image<T>& weight, double adj_loss, Image<T>& adj_a) {
  Pair<T>(a, b, weight).pointwise_adjoint(adj_loss, adj_a, [](T d) { return 2 * d; });
}

double psnr_of_mse(double mse) { return mse > 0 ? -10 * std::log10(mse) : INFINITY; }

template <class T>
double ssim(const Image<T>& a, const Image<T>& b, const Image<T>& weight, SsimWindows windows) {
  return 1 - both_losses(Pair<T>(a, b, weight, windows)).dssim;
}

template <class T>
void ssim_adjoint(const Image<T>& a, const Image<T>& b, const Image<T>& weight, SsimWindows windows, double adj_ssim,
                  Image<T>& adj_a) {
  both_losses(Pair<T>(a, b, weight, windows), 0, -adj_ssim, &adj_a);
}

template <class T>
PhotometricLoss photometric_loss(const PhotometricOptions& options, const Image<T>& a, const Image<T>& b,
                                 const Image<T>& weight) {
  PhotometricLoss loss = both_losses(Pair<T>(a, b, weight));
  loss.total = options.weight_l1 * loss.l1 + options.weight_dssim * loss.dssim;
  return loss;
}

template <class T>
PhotometricLoss photometric_loss_adjoint(const PhotometricOptions& options, const Image<T>& a, const Image<T>& b,
                                         const Image<T>& weight, double adj_total, Image<T>& adj_a) {
  PhotometricLoss loss =
      both_losses(Pair<T>(a, b, weight), adj_total * options.weight_l1, adj_total * options.weight_dssim, &adj_a);
  loss.total = options.weight_l1 * loss.l1 + options.weight_dssim * loss.dssim;
  return loss;
}

#define PLIANT_INSTANTIATE(T)                                                                                       \
  template double l1_loss<T>(const Image<T>&, const Image<T>&, const Image<T>&);                                    \
  template void l1_loss_adjoint<T>(const Image<T>&, const Image<T>&, const Image<T>&, double, Image<T>&);           \
  template double mse_loss<T>(const Image<T>&, const Image<T>&, const Image<T>&);                                   \
  template void mse_loss_adjoint<T>(const Image<T>&, const Image<T>&, const Image<T>&, double, Image<T>&);          \
  template double ssim<T>(const Image<T>&, const Image<T>&, const Image<T>&, SsimWindows);                          \
  template void ssim_adjoint<T>(const Image<T>&, const Image<T>&, const Image<T>&, SsimWindows, double, Image<T>&); \
  template PhotometricLoss photometric_loss<T>(const PhotometricOptions&, const Image<T>&, const Image<T>&,         \
                                               const Image<T>&);                                                    \
  template PhotometricLoss photometric_loss_adjoint<T>(const PhotometricOptions&, const Image<T>&, const Image<T>&, \
                                                       const Image<T>&, double, Image<T>&);
PLIANT_INSTANTIATE(float)
PLIANT_INSTANTIATE(double)

}  // namespace pliant

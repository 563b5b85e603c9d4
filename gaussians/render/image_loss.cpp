#include "gaussians/render/image_loss.h"

#include <algorithm>
#include <cmath>

#include "gaussians/render/image_pair.h"
#include "gaussians/render/ssim_holes.h"
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

static_assert(ssim_rows::kWindow == kSsimWindow);
using ssim_rows::kMargin, ssim_rows::kRadius, ssim_rows::kWindow, ssim_rows::Moments;

/// What one row of the picture needs: pixels of the 11 rows around it, or of their derivatives.
template <class T>
struct Column {
  const T* row[kWindow];
};

// One set of functions per scalar: attributes of this kind do not apply to templates.
#define PLIANT_ROW_FUNCTIONS(T)                                                                                        \
  FOR_EACH_INSTRUCTION_SET void column_moments(const Column<T>& x, const Column<T>& y, std::ptrdiff_t n,               \
                                               const Moments<T>& out) {                                                \
    ssim_rows::column_moments(x.row, y.row, n, out);                                                                   \
  }                                                                                                                    \
  FOR_EACH_INSTRUCTION_SET void dissimilarity(const Moments<T>& in, const T* weight, const T* scale, std::ptrdiff_t n, \
                                              int c, T* out, const Moments<T>* adj) {                                  \
    if (adj && c == 3)                                                                                                 \
      ssim_rows::dissimilarity_adjoint(in, weight, scale, n, 3, out, *adj);                                            \
    else if (adj)                                                                                                      \
      ssim_rows::dissimilarity_adjoint(in, weight, scale, n, c, out, *adj);                                            \
    else if (c == 3)                                                                                                   \
      ssim_rows::dissimilarity(in, weight, scale, n, 3, out);                                                          \
    else                                                                                                               \
      ssim_rows::dissimilarity(in, weight, scale, n, c, out);                                                          \
  }                                                                                                                    \
  FOR_EACH_INSTRUCTION_SET void row_means(const Moments<T>& in, std::ptrdiff_t n, int c, const Moments<T>& out) {      \
    if (c == 3)                                                                                                        \
      ssim_rows::row_means(in, n, 3, out);                                                                             \
    else                                                                                                               \
      ssim_rows::row_means(in, n, c, out);                                                                             \
  }                                                                                                                    \
  FOR_EACH_INSTRUCTION_SET void gather_adjoint(const Column<T>& x_mean, const Column<T>& squares,                      \
                                               const Column<T>& product, const T* x, const T* y, const T* weight,      \
                                               T scale_ssim, T scale_l1, std::ptrdiff_t n, T* adj) {                   \
    ssim_rows::gather_adjoint(x_mean.row, squares.row, product.row, x, y, weight, scale_ssim, scale_l1, n, adj);       \
  }
PLIANT_ROW_FUNCTIONS(float)
PLIANT_ROW_FUNCTIONS(double)

/// Scratch rows of one thread while it works on a block of image rows.
template <class T>
class RowWorkspace {
 public:
  /// `scale` [H, W, 1] of the means of windows; empty = 1.
  RowWorkspace(const ImagePair<T>& pair, const Image<T>& scale, bool reverse)
      : pair_(pair), scale_(scale), n_(pair.row_size()) {
    const std::ptrdiff_t margin = kMargin * pair.a.channels;
    stride_ = n_ + 2 * margin;
    // Rows 0..3 hold moments, 4..6 derivatives, 7 weights, 8 values, 9 zeros, 10 scales; then 11 x (3 derivatives,
    // weights).
    rows_.assign(stride_ * (reverse ? kFirstOfRing + 4 * kWindow : kFirstOfRing), T(0));
    data_ = rows_.data() + margin;
    moments_ = {row(0), row(1), row(2), row(3)};
    adj_ = {row(4), nullptr, row(5), row(6)};
    std::fill_n(row(10), n_, T(1));
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
    if (scale_.empty()) return;
    for (int x = 0; x < pair_.a.width; ++x)
      if (pair_.weight(x, y) == 0)
        std::fill_n(adj + static_cast<std::ptrdiff_t>(x) * pair_.a.channels, pair_.a.channels, T(0));
  }

 private:
  static constexpr int kFirstOfRing = 11;

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
    T *value = row(8), *scale = row(10);
    for (int x = 0; x < scale_.width; ++x)
      std::fill_n(scale + static_cast<std::ptrdiff_t>(x) * pair_.a.channels, pair_.a.channels, scale_(x, y));
    dissimilarity(moments_, weight, scale, n_, pair_.a.channels, value, adj);
    const T *p = pair_.a.at(0, y), *q = pair_.b.at(0, y);
    return {sum_of_row(n_, [&](std::ptrdiff_t i) { return static_cast<double>(weight[i] * std::abs(p[i] - q[i])); }),
            sum_of_row(n_, [&](std::ptrdiff_t i) { return static_cast<double>(value[i]); })};
  }

  const ImagePair<T>& pair_;
  const Image<T>& scale_;
  std::ptrdiff_t n_, stride_;
  std::vector<T> rows_;
  T* data_;
  Moments<T> moments_, adj_;
};

/// L1 and D-SSIM; with `adj_a` also the derivative of adj_l1 * L1 + adj_dssim * D-SSIM.  Blocks of rows are
/// independent: each computes the derivatives with respect to means of 5 further rows on either side anew.
template <class T>
PhotometricLoss losses_of(const ImagePair<T>& pair, const Image<T>& scale, double adj_l1, double adj_dssim,
                          Image<T>* adj_a) {
  constexpr int kBlockRows = 50;
  const int height = pair.a.height;
  const double inverse = pair.inverse_total();
  if (adj_a) pair.resize_like_a(*adj_a);
  std::vector<typename RowWorkspace<T>::Sums> rows(height);
  parallel_for((height + kBlockRows - 1) / kBlockRows, [&](std::ptrdiff_t block) {
    RowWorkspace<T> workspace(pair, scale, adj_a != nullptr);
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
  for (const auto& row : rows) {
    loss.l1 += row.l1;
    loss.dssim += row.dissimilarity;
  }
  loss.l1 *= inverse;
  loss.dssim *= inverse;
  return loss;
}

template <class T>
PhotometricLoss both_losses(const ImagePair<T>& pair, ZeroWeight zero, double adj_l1 = 0, double adj_dssim = 0,
                            Image<T>* adj_a = nullptr) {
  if (zero == ZeroWeight::kUnknown) {
    const SsimHoles<T> holes(pair);
    if (!holes.empty())
      return losses_of(ImagePair<T>(holes.a, holes.b, pair.weight, pair.windows), holes.scale, adj_l1, adj_dssim,
                       adj_a);
  }
  return losses_of(pair, Image<T>(), adj_l1, adj_dssim, adj_a);
}

}  // namespace

template <class T>
double l1_loss(const Image<T>& a, const Image<T>& b, const Image<T>& weight) {
  return ImagePair<T>(a, b, weight).mean([](double d) { return std::abs(d); });
}

template <class T>
void l1_loss_adjoint(const Image<T>& a, const Image<T>& b, const Image<T>& weight, double adj_loss, Image<T>& adj_a) {
  ImagePair<T>(a, b, weight).pointwise_adjoint(adj_loss, adj_a, [](T d) { return static_cast<T>((d > 0) - (d < 0)); });
}

template <class T>
double mse_loss(const Image<T>& a, const Image<T>& b, const Image<T>& weight) {
  return ImagePair<T>(a, b, weight).mean([](double d) { return d * d; });
}

template <class T>
void mse_loss_adjoint(const Image<T>& a, const Image<T>& b, const Image<T>& weight, double adj_loss, Image<T>& adj_a) {
  ImagePair<T>(a, b, weight).pointwise_adjoint(adj_loss, adj_a, [](T d) { return 2 * d; });
}

double psnr_of_mse(double mse) { return mse > 0 ? -10 * std::log10(mse) : INFINITY; }

template <class T>
double ssim(const Image<T>& a, const Image<T>& b, const Image<T>& weight, SsimWindows windows, ZeroWeight zero) {
  return 1 - both_losses(ImagePair<T>(a, b, weight, windows), zero).dssim;
}

template <class T>
void ssim_adjoint(const Image<T>& a, const Image<T>& b, const Image<T>& weight, SsimWindows windows, double adj_ssim,
                  Image<T>& adj_a) {
  both_losses(ImagePair<T>(a, b, weight, windows), ZeroWeight::kUncounted, 0, -adj_ssim, &adj_a);
}

template <class T>
PhotometricLoss photometric_loss(const PhotometricOptions& options, const Image<T>& a, const Image<T>& b,
                                 const Image<T>& weight) {
  PhotometricLoss loss = both_losses(ImagePair<T>(a, b, weight), options.zero_weight);
  loss.total = options.weight_l1 * loss.l1 + options.weight_dssim * loss.dssim;
  return loss;
}

template <class T>
PhotometricLoss photometric_loss_adjoint(const PhotometricOptions& options, const Image<T>& a, const Image<T>& b,
                                         const Image<T>& weight, double adj_total, Image<T>& adj_a) {
  PhotometricLoss loss = both_losses(ImagePair<T>(a, b, weight), options.zero_weight, adj_total * options.weight_l1,
                                     adj_total * options.weight_dssim, &adj_a);
  loss.total = options.weight_l1 * loss.l1 + options.weight_dssim * loss.dssim;
  return loss;
}

#define PLIANT_INSTANTIATE(T)                                                                                       \
  template double l1_loss<T>(const Image<T>&, const Image<T>&, const Image<T>&);                                    \
  template void l1_loss_adjoint<T>(const Image<T>&, const Image<T>&, const Image<T>&, double, Image<T>&);           \
  template double mse_loss<T>(const Image<T>&, const Image<T>&, const Image<T>&);                                   \
  template void mse_loss_adjoint<T>(const Image<T>&, const Image<T>&, const Image<T>&, double, Image<T>&);          \
  template double ssim<T>(const Image<T>&, const Image<T>&, const Image<T>&, SsimWindows, ZeroWeight);              \
  template void ssim_adjoint<T>(const Image<T>&, const Image<T>&, const Image<T>&, SsimWindows, double, Image<T>&); \
  template PhotometricLoss photometric_loss<T>(const PhotometricOptions&, const Image<T>&, const Image<T>&,         \
                                               const Image<T>&);                                                    \
  template PhotometricLoss photometric_loss_adjoint<T>(const PhotometricOptions&, const Image<T>&, const Image<T>&, \
                                                       const Image<T>&, double, Image<T>&);
PLIANT_INSTANTIATE(float)
PLIANT_INSTANTIATE(double)

}  // namespace pliant

#include "gaussians/reconstruct/exposure.h"

#include "gaussians/base/error.h"
#include "gaussians/base/linear_algebra.h"
#include "gaussians/base/portable.h"

namespace pliant {

template <class T>
Image<T> expose(const Image<T>& color, const T* M) {
  CHECK(color.channels == 3);
  Image<T> out(color.width, color.height, 3);
  parallel_for(
      color.height,
      [&](std::ptrdiff_t y) {
        for (int x = 0; x < color.width; ++x) {
          const T* c = color.at(x, static_cast<int>(y));
          for (int k = 0; k < 3; ++k)
            out(x, static_cast<int>(y), k) = M[4 * k] * c[0] + M[4 * k + 1] * c[1] + M[4 * k + 2] * c[2] + M[4 * k + 3];
        }
      },
      16);
  return out;
}

template <class T>
void expose_adjoint(const Image<T>& color, const T* M, Image<T>& adj, T* adj_M) {
  using Sum = Eigen::Matrix<double, kExposureSize, 1>;
  const Sum sum = ordered_sum(static_cast<std::ptrdiff_t>(color.pixels()), Sum(Sum::Zero()), [&](std::ptrdiff_t pixel) {
    const T *c = color.data.data() + 3 * pixel, *g = adj.data.data() + 3 * pixel;
    Sum part;
    for (int k = 0; k < 3; ++k) {
      for (int j = 0; j < 3; ++j) part[4 * k + j] = double(g[k]) * c[j];
      part[4 * k + 3] = g[k];
    }
    return part;
  });
  for (int k = 0; k < kExposureSize; ++k) adj_M[k] += static_cast<T>(sum[k]);
  parallel_for(
      color.height,
      [&](std::ptrdiff_t y) {
        for (int x = 0; x < color.width; ++x) {
          T* g = adj.at(x, static_cast<int>(y));
          const T r = M[0] * g[0] + M[4] * g[1] + M[8] * g[2], gr = M[1] * g[0] + M[5] * g[1] + M[9] * g[2],
                  b = M[2] * g[0] + M[6] * g[1] + M[10] * g[2];
          g[0] = r;
          g[1] = gr;
          g[2] = b;
        }
      },
      16);
}

std::array<float, kExposureSize> fit_exposure(const ImageF& color, const ImageF& target, const ImageF& weight) {
  // Normal equations of x = (r, g, b, 1): A = sum w x x^T, B = sum w x target^T.
  using Sum = Eigen::Matrix<double, 4, 7>;
  const Sum sum = ordered_sum(static_cast<std::ptrdiff_t>(color.pixels()), Sum(Sum::Zero()), [&](std::ptrdiff_t pixel) {
    const float *c = color.data.data() + 3 * pixel, *t = target.data.data() + 3 * pixel;
    const Eigen::Vector4d x(c[0], c[1], c[2], 1);
    Eigen::Matrix<double, 1, 7> row;
    row << x.transpose(), t[0], t[1], t[2];
    return Sum((weight.empty() ? 1.0 : weight.data[pixel]) * x * row);
  });
  const Eigen::Matrix4d A = sum.leftCols<4>() + 1e-6 * Eigen::Matrix4d::Identity();
  const Eigen::Matrix<double, 4, 3> M = solve_symmetric(A, sum.rightCols<3>());
  std::array<float, kExposureSize> exposure;
  for (int k = 0; k < 3; ++k)
    for (int j = 0; j < 4; ++j) exposure[4 * k + j] = static_cast<float>(M(j, k));
  return exposure;
}

template Image<float> expose(const Image<float>&, const float*);
template Image<double> expose(const Image<double>&, const double*);
template void expose_adjoint(const Image<float>&, const float*, Image<float>&, float*);
template void expose_adjoint(const Image<double>&, const double*, Image<double>&, double*);

}  // namespace pliant

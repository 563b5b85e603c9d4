#include "app/evaluate/ms_ssim.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "gaussians/base/error.h"

namespace pliant {
namespace {

constexpr double kExponents[5] = {0.0448, 0.2856, 0.3001, 0.2363, 0.1333};
constexpr double kC1 = 0.01 * 0.01, kC2 = 0.03 * 0.03;
constexpr int kWindow = 11;

cv::Mat channel_of(const Image<double>& image, int channel) {
  cv::Mat out(image.height, image.width, CV_64FC1);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) out.at<double>(y, x) = image(x, y, channel);
  return out;
}

/// Weighted means over the windows that lie inside.
cv::Mat window_means(const cv::Mat& values) {
  static const cv::Mat window = cv::getGaussianKernel(kWindow, 1.5, CV_64F);
  cv::Mat out;
  cv::sepFilter2D(values, out, CV_64F, window, window, cv::Point(-1, -1), 0, cv::BORDER_REPLICATE);
  const int half = kWindow / 2;
  return out(cv::Rect(half, half, values.cols - 2 * half, values.rows - 2 * half)).clone();
}

/// Means of 2 x 2 pixels; an odd last row or column counts twice.
cv::Mat halved(const cv::Mat& values) {
  cv::Mat even;
  cv::copyMakeBorder(values, even, 0, values.rows % 2, 0, values.cols % 2, cv::BORDER_REPLICATE);
  cv::Mat out(even.rows / 2, even.cols / 2, CV_64FC1);
  for (int y = 0; y < out.rows; ++y)
    for (int x = 0; x < out.cols; ++x)
      out.at<double>(y, x) = 0.25 * (even.at<double>(2 * y, 2 * x) + even.at<double>(2 * y, 2 * x + 1) +
                                     even.at<double>(2 * y + 1, 2 * x) + even.at<double>(2 * y + 1, 2 * x + 1));
  return out;
}

/// Means over the windows of luminance times contrast and structure, and of the latter alone.
struct Similarity {
  double whole = 0, structure = 0;
};

Similarity similarity_of(const cv::Mat& a, const cv::Mat& b) {
  const cv::Mat mean_a = window_means(a), mean_b = window_means(b), aa = window_means(a.mul(a)),
                bb = window_means(b.mul(b)), ab = window_means(a.mul(b));
  Similarity sum;
  for (int y = 0; y < mean_a.rows; ++y)
    for (int x = 0; x < mean_a.cols; ++x) {
      const double ma = mean_a.at<double>(y, x), mb = mean_b.at<double>(y, x), va = aa.at<double>(y, x) - ma * ma,
                   vb = bb.at<double>(y, x) - mb * mb, cov = ab.at<double>(y, x) - ma * mb;
      const double structure = (2 * cov + kC2) / (va + vb + kC2);
      sum.structure += structure;
      sum.whole += structure * (2 * ma * mb + kC1) / (ma * ma + mb * mb + kC1);
    }
  const double count = static_cast<double>(mean_a.total());
  return {sum.whole / count, sum.structure / count};
}

}  // namespace

double ms_ssim(const Image<double>& a, const Image<double>& b) {
  CHECK(a.width == b.width && a.height == b.height && a.channels == b.channels);
  CHECK(std::min(a.width, a.height) >= kLeastMsSsimSize);
  double sum = 0;
  for (int channel = 0; channel < a.channels; ++channel) {
    cv::Mat x = channel_of(a, channel), y = channel_of(b, channel);
    double product = 1;
    for (int scale = 0; scale < 5; ++scale) {
      if (scale > 0) {
        x = halved(x);
        y = halved(y);
      }
      const Similarity s = similarity_of(x, y);
      product *= std::pow(std::max(0.0, scale == 4 ? s.whole : s.structure), kExponents[scale]);
    }
    sum += product / a.channels;
  }
  return sum;
}

}  // namespace pliant

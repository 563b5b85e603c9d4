#include "gaussians/vision/match_pictures.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "gaussians/base/error.h"
#include "gaussians/base/quantile.h"
#include "gaussians/vision/as_mat.h"
#include "gaussians/vision/optical_flow.h"

namespace pliant {
namespace {

constexpr int kWindow = 11;              // px
constexpr double kNoise = 2.0 / 255;     // of colours: contrast below it says nothing
constexpr double kTextured = 8.0 / 255;  // contrast from which flow is taken to be right

/// Mean over the window, summed over the channels.
cv::Mat window_sum(const cv::Mat& values) {
  cv::Mat mean, sum;
  cv::boxFilter(values, mean, CV_32F, cv::Size(kWindow, kWindow), cv::Point(-1, -1), true, cv::BORDER_REFLECT);
  cv::transform(mean, sum, cv::Matx13f(1, 1, 1));
  return sum;
}

/// Covariance within windows, summed over the channels.
cv::Mat window_covariance(const cv::Mat& a, const cv::Mat& b) {
  cv::Mat mean_a, mean_b;
  cv::boxFilter(a, mean_a, CV_32F, cv::Size(kWindow, kWindow), cv::Point(-1, -1), true, cv::BORDER_REFLECT);
  cv::boxFilter(b, mean_b, CV_32F, cv::Size(kWindow, kWindow), cv::Point(-1, -1), true, cv::BORDER_REFLECT);
  cv::Mat means;
  cv::transform(mean_a.mul(mean_b), means, cv::Matx13f(1, 1, 1));
  return window_sum(a.mul(b)) - means;
}

}  // namespace

double match_score(const ImageF& a, const ImageF& b, const ImageU8& ignored) {
  CHECK(a.width == b.width && a.height == b.height && a.channels == 3 && b.channels == 3);
  const cv::Mat first = as_mat(a), second = as_mat(b);
  const cv::Mat aa = window_covariance(first, first), bb = window_covariance(second, second),
                ab = window_covariance(first, second);
  double sum = 0, weights = 0;
  for (int y = 0; y < a.height; ++y)
    for (int x = 0; x < a.width; ++x) {
      if (!ignored.empty() && ignored(x, y) != 0) continue;
      const double va = std::max(0.0f, aa.at<float>(y, x)), vb = std::max(0.0f, bb.at<float>(y, x));
      const double weight = std::sqrt(std::max(va, vb));
      sum += weight * ab.at<float>(y, x) / (std::sqrt(va * vb) + 3 * kNoise * kNoise);
      weights += weight;
    }
  return weights > 0 ? sum / weights : 0;
}

ImageF local_contrast(const ImageF& picture) {
  CHECK(picture.channels == 3);
  const cv::Mat mat = as_mat(picture), variance = window_covariance(mat, mat);
  ImageF out(picture.width, picture.height, 1);
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) out(x, y) = std::sqrt(std::max(0.0f, variance.at<float>(y, x)) / 3);
  return out;
}

PictureMatch match_pictures(const ImageF& a, const ImageF& b, const ImageU8& ignored) {
  PictureMatch match;
  match.score = match_score(a, b, ignored);
  const ImageF contrast = local_contrast(a);
  const std::vector<ImageF> both = {a, b};
  const std::vector<std::pair<int, int>> pair = {{0, 1}};
  const ImageF flow = dense_flows(both, pair)[0];
  std::vector<float> lengths;
  for (int y = 0; y < a.height; ++y)
    for (int x = 0; x < a.width; ++x)
      if (contrast(x, y) > kTextured && (ignored.empty() || ignored(x, y) == 0))
        lengths.push_back(std::hypot(flow(x, y, 0), flow(x, y, 1)));
  if (lengths.empty()) return match;
  match.shift = quantile(lengths, 0.5);
  return match;
}

}  // namespace pliant

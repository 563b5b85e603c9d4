#include "fitting/observe/align_patch.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "gaussians/base/error.h"
#include "gaussians/base/linear_algebra.h"

namespace pliant {
namespace {

using Eigen::Vector2d;

constexpr double kSmoothing = 0.8;         // px: bilinear sampling of a smoothed picture has little error of its own
constexpr double kLinearPrior = 0.02;      // keeps the linear part of poorly textured patches near its start
constexpr double kLeastContrast = 1e-4;    // variance of colour below which a patch says nothing
constexpr double kNoiseFloor = 1.0 / 255;  // of colours

// Unknowns: position, linear part by rows, gain of the patch's colours.  One more column holds the picture's colour.
constexpr int kUnknowns = 7, kColumns = 8;
using Columns = Eigen::Matrix<double, kColumns, 1>;
using Normal = Eigen::Matrix<double, kColumns, kColumns>;

}  // namespace

GradientPicture::GradientPicture(const ImageF& picture) : data_(picture.width, picture.height, 9) {
  CHECK(picture.channels == 3);
  const cv::Mat given(picture.height, picture.width, CV_32FC3, const_cast<float*>(picture.data.data()));
  cv::Mat smooth, du, dv;
  cv::GaussianBlur(given, smooth, cv::Size(7, 7), kSmoothing, kSmoothing, cv::BORDER_REPLICATE);
  // The derivative of the sampled signal, not smoothed further.
  const cv::Mat central = (cv::Mat_<float>(1, 3) << -0.5f, 0.0f, 0.5f);
  cv::filter2D(smooth, du, CV_32F, central, cv::Point(-1, -1), 0, cv::BORDER_REPLICATE);
  cv::filter2D(smooth, dv, CV_32F, central.t(), cv::Point(-1, -1), 0, cv::BORDER_REPLICATE);
  for (int y = 0; y < data_.height; ++y)
    for (int x = 0; x < data_.width; ++x)
      for (int c = 0; c < 3; ++c) {
        data_(x, y, c) = smooth.ptr<float>(y)[3 * x + c];
        data_(x, y, 3 + c) = du.ptr<float>(y)[3 * x + c];
        data_(x, y, 6 + c) = dv.ptr<float>(y)[3 * x + c];
      }
}

bool GradientPicture::sample(double u, double v, float (&out)[9]) const {
  const double x = u - 0.5, y = v - 0.5;
  if (!(x >= 0 && y >= 0 && x < data_.width - 1 && y < data_.height - 1)) return false;
  const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
  const float a = static_cast<float>(x - x0), b = static_cast<float>(y - y0);
  const float *top = data_.at(x0, y0), *bottom = data_.at(x0, y0 + 1);
  for (int k = 0; k < 9; ++k)
    out[k] = (1 - b) * ((1 - a) * top[k] + a * top[9 + k]) + b * ((1 - a) * bottom[k] + a * bottom[9 + k]);
  return true;
}

Patch::Patch(const AlignOptions& options, const GradientPicture& picture, const ImageU8& mask, const Vector2d& centre)
    : options_(options) {
  const int r = options.radius;
  const double sigma = 0.5 * r;
  for (int j = -r; j <= r; ++j)
    for (int i = -r; i <= r; ++i) {
      Pixel pixel;
      pixel.offset = Vector2d(i, j);
      const Vector2d at = centre + pixel.offset;
      if (i * i + j * j > r * r) continue;
      const int x = static_cast<int>(std::floor(at.x())), y = static_cast<int>(std::floor(at.y()));
      if (x < 0 || y < 0 || x >= picture.width() || y >= picture.height() || (!mask.empty() && mask(x, y) == 0))
        continue;
      float value[9];
      if (!picture.sample(at.x(), at.y(), value)) continue;
      std::copy_n(value, 3, pixel.colour);
      pixel.weight = static_cast<float>(std::exp(-0.5 * pixel.offset.squaredNorm() / (sigma * sigma)));
      pixels_.push_back(pixel);
    }
}

PatchFit Patch::align(const GradientPicture& picture, const PatchWarp& start) const {
  PatchFit fit;
  fit.warp = start;
  fit.sigma = std::numeric_limits<double>::infinity();
  double gain = 1, bias[3] = {0, 0, 0};
  double total = 0;
  for (const Pixel& p : pixels_) total += p.weight;
  for (int iteration = 0; iteration <= options_.iterations; ++iteration) {
    Normal normal[3];
    Columns sum[3];
    for (int c = 0; c < 3; ++c) {
      normal[c].setZero();
      sum[c].setZero();
    }
    double weight_sum = 0, inside = 0;
    for (const Pixel& p : pixels_) {
      const Vector2d at = fit.warp.position + fit.warp.linear * p.offset;
      float value[9];
      if (!picture.sample(at.x(), at.y(), value)) continue;
      inside += p.weight;
      double weight = p.weight;
      if (iteration > 0) {
        double difference = 0;
        for (int c = 0; c < 3; ++c) difference += std::pow(value[c] - gain * p.colour[c] - bias[c], 2);
        const double ratio = 1 + difference / (options_.robust_scale * options_.robust_scale);
        weight /= ratio * ratio;
      }
      weight_sum += weight;
      for (int c = 0; c < 3; ++c) {
        const double du = value[3 + c], dv = value[6 + c];
        Columns column;
        column << du, dv, du * p.offset.x(), du * p.offset.y(), dv * p.offset.x(), dv * p.offset.y(), -p.colour[c],
            value[c];
        normal[c].noalias() += weight * column * column.transpose();
        sum[c] += weight * column;
      }
    }
    fit.inside = inside > 0.5 * total && total > 0;
    if (!fit.inside || !(weight_sum > 0.05 * total)) return fit;

    // The bias of each colour is eliminated: what remains are covariances.
    Normal covariance = Normal::Zero();
    for (int c = 0; c < 3; ++c) covariance += normal[c] - sum[c] * sum[c].transpose() / weight_sum;
    const double of_patch = covariance(6, 6), of_picture = covariance(7, 7);
    if (!(of_patch > kLeastContrast * weight_sum)) return fit;
    fit.correlation = of_picture > 0 ? -covariance(6, 7) / std::sqrt(of_patch * of_picture) : 0;
    Eigen::Matrix<double, kUnknowns, kUnknowns> H = covariance.topLeftCorner<kUnknowns, kUnknowns>();
    Eigen::Matrix<double, kUnknowns, 1> right = -covariance.topRightCorner<kUnknowns, 1>();
    const double prior = kLinearPrior * weight_sum * kNoiseFloor;
    for (int k = 2; k < 6; ++k) {
      H(k, k) += prior;
      right[k] += prior * (start.linear((k - 2) / 2, k % 2) - fit.warp.linear((k - 2) / 2, k % 2));
    }
    H.diagonal().array() += 1e-12 * weight_sum;
    const Eigen::Matrix<double, kUnknowns, 1> step = solve_symmetric(H, right);
    const double square = std::max(0.0, of_picture + 2 * gain * covariance(6, 7) + gain * gain * of_patch) / weight_sum;
    const Eigen::Matrix2d position_covariance =
        solve_symmetric(H, Eigen::MatrixXd::Identity(kUnknowns, 2)).topRows(2) * (square + kNoiseFloor * kNoiseFloor);
    fit.sigma = std::sqrt(0.5 * position_covariance.trace());
    if (!step.allFinite() || iteration == options_.iterations) return fit;

    gain = std::clamp(step[6], 0.3, 3.0);
    for (int c = 0; c < 3; ++c) bias[c] = (sum[c][7] + gain * sum[c][6]) / weight_sum;
    // A step longer than the slopes of the texture is not to be trusted.
    const double length = step.head<2>().norm(), limit = 0.3 * options_.radius;
    const double share = length > limit ? limit / length : 1;
    fit.warp.position += share * step.head<2>();
    fit.warp.linear(0, 0) += share * step[2];
    fit.warp.linear(0, 1) += share * step[3];
    fit.warp.linear(1, 0) += share * step[4];
    fit.warp.linear(1, 1) += share * step[5];
    if (length < options_.enough && iteration > 1) iteration = std::max(iteration, options_.iterations - 1);
  }
  return fit;
}

}  // namespace pliant

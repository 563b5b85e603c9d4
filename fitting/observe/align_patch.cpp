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

/// Sums over pixels of the products of those columns.  The columns of position and linear part are a slope times 1, x
/// or y of the pixel, so that few products make up all of them.
struct NormalSums {
  double slopes[3][6] = {};     // uu, uv, vv times 1, x, y, xx, xy, yy
  double colours[4][3] = {};    // slopes u, v times colour of the patch, then of the picture; times 1, x, y
  double pairs[3] = {};         // colours: patch patch, patch picture, picture picture
  double of_colour[3][8] = {};  // sums of the columns themselves, of each colour

  void add(double weight, double x, double y, const float (&value)[9], const float (&patch)[3]) {
    double uu = 0, uv = 0, vv = 0, mixed[4] = {}, both[3] = {};
    for (int c = 0; c < 3; ++c) {
      const double du = value[3 + c], dv = value[6 + c], p = patch[c], v = value[c], u_weighted = weight * du,
                   v_weighted = weight * dv;
      uu += u_weighted * du;
      uv += u_weighted * dv;
      vv += v_weighted * dv;
      mixed[0] += u_weighted * p;
      mixed[1] += v_weighted * p;
      mixed[2] += u_weighted * v;
      mixed[3] += v_weighted * v;
      both[0] += weight * p * p;
      both[1] += weight * p * v;
      both[2] += weight * v * v;
      double* sum = of_colour[c];
      sum[0] += u_weighted;
      sum[1] += v_weighted;
      sum[2] += u_weighted * x;
      sum[3] += u_weighted * y;
      sum[4] += v_weighted * x;
      sum[5] += v_weighted * y;
      sum[6] -= weight * p;
      sum[7] += weight * v;
    }
    const double monomials[6] = {1, x, y, x * x, x * y, y * y};
    for (int k = 0; k < 6; ++k) {
      slopes[0][k] += uu * monomials[k];
      slopes[1][k] += uv * monomials[k];
      slopes[2][k] += vv * monomials[k];
    }
    for (int k = 0; k < 3; ++k) {
      for (int j = 0; j < 4; ++j) colours[j][k] += mixed[j] * monomials[k];
      pairs[k] += both[k];
    }
  }

  /// Sums of the products of the columns over pixels and colours.
  Normal normal() const {
    // Columns 0 to 5: slope (u 0, v 1) and factor (1, x, y) of each.
    constexpr int kSlope[6] = {0, 1, 0, 0, 1, 1}, kFactor[6] = {0, 0, 1, 2, 1, 2};
    constexpr int kProduct[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
    Normal out;
    for (int i = 0; i < 6; ++i) {
      for (int j = 0; j < 6; ++j) out(i, j) = slopes[kSlope[i] + kSlope[j]][kProduct[kFactor[i]][kFactor[j]]];
      out(i, 6) = out(6, i) = -colours[kSlope[i]][kFactor[i]];
      out(i, 7) = out(7, i) = colours[2 + kSlope[i]][kFactor[i]];
    }
    out(6, 6) = pairs[0];
    out(6, 7) = out(7, 6) = -pairs[1];
    out(7, 7) = pairs[2];
    return out;
  }
  Columns sum_of(int colour) const { return Eigen::Map<const Columns>(of_colour[colour]); }
};

}  // namespace

GradientPicture::GradientPicture(const ImageF& picture) : data_(picture.width, picture.height, 9) {
  CHECK(picture.channels == 3);
  const cv::Mat given(picture.height, picture.width, CV_32FC3, const_cast<float*>(picture.data.data()));
  cv::Mat smooth;
  cv::GaussianBlur(given, smooth, cv::Size(7, 7), kSmoothing, kSmoothing, cv::BORDER_REPLICATE);
  // The derivative of the sampled signal, not smoothed further; the border is continued.
  const int last_x = data_.width - 1, last_y = data_.height - 1;
  for (int y = 0; y <= last_y; ++y) {
    const float *row = smooth.ptr<float>(y), *above = smooth.ptr<float>(std::max(0, y - 1)),
                *below = smooth.ptr<float>(std::min(last_y, y + 1));
    for (int x = 0; x <= last_x; ++x) {
      const float *left = row + 3 * std::max(0, x - 1), *right = row + 3 * std::min(last_x, x + 1);
      float* out = data_.at(x, y);
      for (int c = 0; c < 3; ++c) {
        out[c] = row[3 * x + c];
        out[3 + c] = 0.5f * (right[c] - left[c]);
        out[6 + c] = 0.5f * (below[3 * x + c] - above[3 * x + c]);
      }
    }
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
    NormalSums sums;
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
      sums.add(weight, p.offset.x(), p.offset.y(), value, p.colour);
    }
    fit.inside = inside > 0.5 * total && total > 0;
    if (!fit.inside || !(weight_sum > 0.05 * total)) return fit;

    // The bias of each colour is eliminated: what remains are covariances.
    Normal covariance = sums.normal();
    for (int c = 0; c < 3; ++c) covariance -= sums.sum_of(c) * sums.sum_of(c).transpose() / weight_sum;
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
    for (int c = 0; c < 3; ++c) bias[c] = (sums.of_colour[c][7] + gain * sums.of_colour[c][6]) / weight_sum;
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

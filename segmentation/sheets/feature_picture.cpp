#include "segmentation/sheets/feature_picture.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "gaussians/base/error.h"
#include "gaussians/base/linear_algebra.h"
#include "gaussians/base/quantile.h"
#include "gaussians/render/render.h"

namespace pliant {
namespace {

constexpr int kY = kSemanticChannels, kFeatureGap = 8, kWidest = 480;
using Attribute = Eigen::Matrix<double, kY, 1>;
using ConstRow = Eigen::Map<const Eigen::Matrix<float, kY, 1>>;

/// Puts `picture`, scaled to `width`, at (x, y) of the sheet.
void put(const ImageF& picture, int x, int y, int width, int height, ImageF& sheet) {
  const cv::Mat from(picture.height, picture.width, CV_32FC3, const_cast<float*>(picture.data.data()));
  cv::Mat to(sheet.height, sheet.width, CV_32FC3, sheet.data.data());
  cv::Mat cell = to(cv::Rect(x, y, width, height));
  cv::resize(from, cell, cell.size(), 0, 0, width < picture.width ? cv::INTER_AREA : cv::INTER_LINEAR);
}

}  // namespace

PrincipalColors PrincipalColors::of(std::span<const float> samples) {
  PrincipalColors colors;
  const size_t n = samples.size() / kY;
  if (n == 0) return colors;
  for (size_t i = 0; i < n; ++i) colors.mean += ConstRow(samples.data() + i * kY).cast<double>();
  colors.mean /= static_cast<double>(n);
  Eigen::Matrix<double, kY, kY> covariance = Eigen::Matrix<double, kY, kY>::Zero();
  for (size_t i = 0; i < n; ++i) {
    const Attribute d = ConstRow(samples.data() + i * kY).cast<double>() - colors.mean;
    covariance.selfadjointView<Eigen::Lower>().rankUpdate(d);
  }
  const SymmetricEigen axes = symmetric_eigen(
      Eigen::MatrixXd(Eigen::MatrixXd(covariance.selfadjointView<Eigen::Lower>()) / static_cast<double>(n)));
  const double total = axes.values.sum();
  std::vector<double> scores(n);
  for (int k = 0; k < 3; ++k) {
    if (!(axes.values[kY - 1 - k] > 1e-9 * total)) continue;
    Attribute axis = axes.vectors.col(kY - 1 - k);
    double third = 0;
    for (size_t i = 0; i < n; ++i) {
      scores[i] = axis.dot(ConstRow(samples.data() + i * kY).cast<double>() - colors.mean);
      third += scores[i] * scores[i] * scores[i];
    }
    if (third < 0) {
      axis = -axis;
      for (double& score : scores) score = -score;
    }
    colors.axes.col(k) = axis;
    colors.low[k] = quantile(scores, 0.01);
    colors.high[k] = quantile(scores, 0.99);
  }
  return colors;
}

Vec3f PrincipalColors::color(const float* attribute) const {
  const Vec3d score = axes.transpose() * (ConstRow(attribute).cast<double>() - mean);
  Vec3f out = Vec3f::Constant(0.5f);
  for (int k = 0; k < 3; ++k)
    if (high[k] > low[k]) out[k] = static_cast<float>(std::clamp((score[k] - low[k]) / (high[k] - low[k]), 0.0, 1.0));
  return out;
}

ImageF features_sheet(const std::vector<float>& attribute, const GaussianCloud& cloud,
                      const std::vector<Camera>& cameras, const std::function<ImageF(int camera)>& picture,
                      bool antialiased, int views) {
  CHECK(!cameras.empty() && attribute.size() == cloud.size() * kY);
  const int shown = std::min<int>(views, static_cast<int>(cameras.size()));
  RenderOptions options;
  options.antialiased = antialiased;
  std::vector<int> chosen;
  for (int v = 0; v < shown; ++v) chosen.push_back(static_cast<int>(static_cast<size_t>(v) * cameras.size() / shown));
  const int width = std::min(kWidest, cameras[chosen[0]].width);
  const auto height_of = [&](int c) { return std::max(1, width * cameras[c].height / cameras[c].width); };
  std::vector<RenderResult> blended;
  std::vector<float> samples;
  for (const int c : chosen) {
    const Camera& camera = cameras[c];
    blended.push_back(
        render(cloud, camera.width > width ? camera.resized(width, height_of(c)) : camera, options, attribute, kY));
    const RenderResult& view = blended.back();
    for (size_t i = 0; i < view.alpha.pixels(); ++i)
      if (view.alpha.data[i] >= 0.5f)
        samples.insert(samples.end(), view.features.data.data() + i * kY, view.features.data.data() + (i + 1) * kY);
  }
  const PrincipalColors colors = PrincipalColors::of(samples);

  int height = 0;
  for (const int c : chosen) height = std::max(height, height_of(c));
  ImageF sheet(shown * (width + kFeatureGap) + kFeatureGap, 2 * (height + kFeatureGap) + kFeatureGap, 3, 0.1f);
  for (int v = 0; v < shown; ++v) {
    const RenderResult& view = blended[v];
    ImageF features(view.alpha.width, view.alpha.height, 3);
    for (size_t i = 0; i < features.pixels(); ++i)
      if (view.alpha.data[i] >= 0.5f)
        Eigen::Map<Vec3f>(features.data.data() + 3 * i) = colors.color(view.features.data.data() + i * kY);
    const int x = kFeatureGap + v * (width + kFeatureGap), own = height_of(chosen[v]);
    put(picture(chosen[v]), x, kFeatureGap, width, own, sheet);
    put(features, x, 2 * kFeatureGap + height, width, own, sheet);
  }
  return sheet;
}

}  // namespace pliant

#include "segmentation/graph/color_model.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "gaussians/base/error.h"
#include "gaussians/base/random.h"

namespace pliant {
namespace {

constexpr double kNothing = -60;  // log of a share that adds nothing to sums in double

float linear_of_srgb(float c) {
  c = std::clamp(c, 0.0f, 1.0f);
  return c <= 0.04045f ? c / 12.92f : std::pow((c + 0.055f) / 1.055f, 2.4f);
}

float lab_curve(float t) { return t > 0.008856f ? std::cbrt(t) : 7.787f * t + 16.0f / 116.0f; }

/// Centres drawn one after another with probability proportional to the squared distance to those drawn before.
std::vector<Vec3f> spread_centres(int count, std::span<const Vec3f> colors, std::span<const float> weights,
                                  uint64_t seed) {
  Random random(seed, colors.size());
  std::vector<double> chance(colors.size());
  std::vector<Vec3f> centres;
  for (int k = 0; k < count; ++k) {
    double total = 0;
    for (size_t i = 0; i < colors.size(); ++i) {
      float nearest = centres.empty() ? 1.0f : INFINITY;
      for (const Vec3f& centre : centres) nearest = std::min(nearest, (colors[i] - centre).squaredNorm());
      total += chance[i] = nearest * weights[i];
    }
    double left = random.uniform() * total;
    size_t pick = 0;
    while (pick + 1 < colors.size() && (left -= chance[pick]) > 0) ++pick;
    if (total > 0 || centres.empty()) centres.push_back(colors[pick]);
  }
  return centres;
}

}  // namespace

Vec3f lab_of_rgb(const Vec3f& rgb) {
  const float r = linear_of_srgb(rgb.x()), g = linear_of_srgb(rgb.y()), b = linear_of_srgb(rgb.z());
  const float x = lab_curve((0.412453f * r + 0.357580f * g + 0.180423f * b) / 0.950456f);
  const float y = lab_curve(0.212671f * r + 0.715160f * g + 0.072169f * b);
  const float z = lab_curve((0.019334f * r + 0.119193f * g + 0.950227f * b) / 1.088754f);
  return Vec3f(1.16f * y - 0.16f, 5.0f * (x - y), 2.0f * (y - z));
}

inline float ColorModel::log_of_component(size_t k, const Vec3f& color) const {
  return evaluated_[k].log_factor - 0.5f * (evaluated_[k].whitening * (color - components_[k].mean)).squaredNorm();
}

ColorModel ColorModel::fit(const ColorModelOptions& options, std::span<const Vec3f> all,
                           std::span<const float> all_weights, const ColorModel* start) {
  CHECK(options.components > 0 && (all_weights.empty() || all_weights.size() == all.size()));
  ColorModel model;
  const size_t step = std::max<size_t>(1, (all.size() + options.most_samples - 1) / options.most_samples);
  std::vector<Vec3f> colors;
  std::vector<float> weights;
  double total = 0;
  for (size_t i = 0; i < all.size(); i += step) {
    const float weight = all_weights.empty() ? 1.0f : all_weights[i];
    if (weight > 0) {
      colors.push_back(all[i]);
      weights.push_back(weight);
      total += weight;
    }
  }
  if (colors.empty()) return model;

  if (start && !start->empty()) {
    model = *start;
  } else {
    for (const Vec3f& centre : spread_centres(options.components, colors, weights, options.seed))
      model.components_.push_back({0, centre, 0.01f * Mat3f::Identity()});
    for (Component& c : model.components_) c.weight = 1.0f / static_cast<float>(model.components_.size());
    model.prepare();
  }
  std::vector<double> share(model.components_.size());
  struct Moments {
    double weight = 0;
    Vec3d first = Vec3d::Zero();
    Mat3d second = Mat3d::Zero();  // below the diagonal
  };
  for (int round = 0; round < options.rounds; ++round) {
    std::vector<Moments> moments(model.components_.size());
    for (size_t i = 0; i < colors.size(); ++i) {
      double most = -INFINITY, sum = 0;
      for (size_t k = 0; k < share.size(); ++k) most = std::max(most, share[k] = model.log_of_component(k, colors[i]));
      for (double& s : share) sum += s = s - most > kNothing ? std::exp(s - most) : 0;
      const Vec3d x = colors[i].cast<double>();
      for (size_t k = 0; k < share.size(); ++k) {
        if (share[k] == 0) continue;
        const double w = weights[i] * share[k] / sum;
        const Vec3d wx = w * x;
        moments[k].weight += w;
        moments[k].first += wx;
        for (int c = 0; c < 3; ++c)
          for (int r = c; r < 3; ++r) moments[k].second(r, c) += wx[r] * x[c];
      }
    }
    for (size_t k = 0; k < share.size(); ++k) {
      Component& c = model.components_[k];
      c.weight = static_cast<float>(moments[k].weight / total);
      if (!(moments[k].weight > 1e-6 * total)) continue;  // a component that lost its colours keeps its place
      const Vec3d mean = moments[k].first / moments[k].weight;
      const Mat3d second = moments[k].second.selfadjointView<Eigen::Lower>();
      c.mean = mean.cast<float>();
      c.covariance =
          (second / moments[k].weight - mean * mean.transpose()).cast<float>() + options.ridge * Mat3f::Identity();
    }
    model.prepare();
  }
  return model;
}

void ColorModel::prepare() {
  evaluated_.clear();
  for (const Component& c : components_) {
    const Mat3f L = Eigen::LLT<Mat3f>(c.covariance).matrixL();
    const float log_determinant = 2 * std::log(L.diagonal().prod());
    evaluated_.push_back({L.inverse(), std::log(std::max(c.weight, 1e-12f)) - 0.5f * log_determinant - 2.756816f});
  }
}

float ColorModel::log_density(const Vec3f& color) const {
  float most = -INFINITY, sum = 0;
  for (size_t k = 0; k < components_.size(); ++k) most = std::max(most, log_of_component(k, color));
  if (components_.empty()) return 0;
  for (size_t k = 0; k < components_.size(); ++k) sum += std::exp(log_of_component(k, color) - most);
  return most + std::log(sum);
}

}  // namespace pliant

#include "segmentation/graph/color_model.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "gaussians/base/error.h"
#include "gaussians/base/random.h"

namespace pliant {
namespace {

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

constexpr int kBatch = 64;  // colours at a time, as many of which as a processor takes are worked on at once
using Batch = Eigen::Array<float, kBatch, 1>;

struct Block {
  Batch x = Batch::Zero(), y = Batch::Zero(), z = Batch::Zero();
  Batch weight = Batch::Zero();
};

std::vector<Block> blocks_of(std::span<const Vec3f> colors, std::span<const float> weights) {
  std::vector<Block> blocks((colors.size() + kBatch - 1) / kBatch);
  for (size_t i = 0; i < colors.size(); ++i) {
    Block& block = blocks[i / kBatch];
    const auto at = static_cast<Eigen::Index>(i % kBatch);
    block.x[at] = colors[i].x();
    block.y[at] = colors[i].y();
    block.z[at] = colors[i].z();
    block.weight[at] = weights.empty() ? 1.0f : weights[i];
  }
  return blocks;
}

/// Sums over the colours of a component, about its last mean: with large means little would be left of the digits.
struct Moments {
  double weight = 0;
  Vec3d first = Vec3d::Zero();
  Mat3d second = Mat3d::Zero();  ///< below the diagonal

  void add(const Block& block, const Vec3f& mean, const Batch& share) {
    const Batch d[3] = {block.x - mean.x(), block.y - mean.y(), block.z - mean.z()};
    weight += share.sum();
    for (int c = 0; c < 3; ++c) {
      const Batch weighted = share * d[c];
      first[c] += weighted.sum();
      for (int r = c; r < 3; ++r) second(r, c) += (weighted * d[r]).sum();
    }
  }
};

}  // namespace

Vec3f lab_of_rgb(const Vec3f& rgb) {
  const float r = linear_of_srgb(rgb.x()), g = linear_of_srgb(rgb.y()), b = linear_of_srgb(rgb.z());
  const float x = lab_curve((0.412453f * r + 0.357580f * g + 0.180423f * b) / 0.950456f);
  const float y = lab_curve(0.212671f * r + 0.715160f * g + 0.072169f * b);
  const float z = lab_curve((0.019334f * r + 0.119193f * g + 0.950227f * b) / 1.088754f);
  return Vec3f(1.16f * y - 0.16f, 5.0f * (x - y), 2.0f * (y - z));
}

template <class Real>
Real ColorModel::Evaluated::log_density(const Real& x, const Real& y, const Real& z) const {
  const Real dx = x - mean.x(), dy = y - mean.y(), dz = z - mean.z();
  const Mat3f& W = whitening;
  const Real u = W(0, 0) * dx, v = W(1, 0) * dx + W(1, 1) * dy, w = W(2, 0) * dx + W(2, 1) * dy + W(2, 2) * dz;
  return log_factor - 0.5f * (u * u + v * v + w * w);
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
  const std::vector<Block> blocks = blocks_of(colors, weights);
  std::vector<Batch> part(model.components_.size());
  for (int round = 0; round < options.rounds; ++round) {
    std::vector<Moments> moments(model.components_.size());
    for (const Block& block : blocks) {
      Batch most = Batch::Constant(-INFINITY), sum = Batch::Zero();
      for (size_t k = 0; k < moments.size(); ++k)
        most = most.max(part[k] = model.evaluated_[k].log_density(block.x, block.y, block.z));
      for (Batch& p : part) sum += p = (p - most).exp();
      const Batch share = block.weight / sum;
      for (size_t k = 0; k < moments.size(); ++k) moments[k].add(block, model.components_[k].mean, part[k] * share);
    }
    for (size_t k = 0; k < moments.size(); ++k) {
      Component& c = model.components_[k];
      c.weight = static_cast<float>(moments[k].weight / total);
      if (!(moments[k].weight > 1e-6 * total)) continue;  // a component that lost its colours keeps its place
      const Vec3d shift = moments[k].first / moments[k].weight;
      const Mat3d second = moments[k].second.selfadjointView<Eigen::Lower>();
      c.mean += shift.cast<float>();
      c.covariance =
          (second / moments[k].weight - shift * shift.transpose()).cast<float>() + options.ridge * Mat3f::Identity();
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
    evaluated_.push_back(
        {c.mean, L.inverse(), std::log(std::max(c.weight, 1e-12f)) - 0.5f * log_determinant - 2.756816f});
  }
}

float ColorModel::log_density(const Vec3f& color) const {
  if (components_.empty()) return 0;
  float most = -INFINITY, sum = 0;
  for (const Evaluated& c : evaluated_) most = std::max(most, c.log_density(color.x(), color.y(), color.z()));
  for (const Evaluated& c : evaluated_) sum += std::exp(c.log_density(color.x(), color.y(), color.z()) - most);
  return most + std::log(sum);
}

std::vector<float> ColorModel::log_density(std::span<const Vec3f> colors) const {
  std::vector<float> out(colors.size(), 0.0f);
  if (components_.empty()) return out;
  std::vector<Batch> part(evaluated_.size());
  size_t first = 0;
  for (const Block& block : blocks_of(colors, {})) {
    Batch most = Batch::Constant(-INFINITY), sum = Batch::Zero();
    for (size_t k = 0; k < part.size(); ++k)
      most = most.max(part[k] = evaluated_[k].log_density(block.x, block.y, block.z));
    for (const Batch& p : part) sum += (p - most).exp();
    const Batch density = most + sum.log();
    for (int i = 0; i < kBatch && first < out.size(); ++i) out[first++] = density[i];
  }
  return out;
}

}  // namespace pliant

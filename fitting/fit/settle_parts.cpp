#include "fitting/fit/settle_parts.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "fitting/fit/parts.h"
#include "gaussians/base/error.h"
#include "gaussians/base/nearest.h"

namespace pliant {
namespace {

using Ratios = Eigen::Vector2d;  // logarithms of red and blue against green

/// -log likelihood of a look, but for a constant: a Gaussian of the ratios, and a share of what is thin.
class LookOfPart {
 public:
  LookOfPart(const std::vector<Ratios>& ratios, const std::vector<bool>& thin, std::span<const uint32_t> part,
             uint32_t p, double spread) {
    Eigen::Matrix2d square = Eigen::Matrix2d::Zero();
    double count = 0, of_thin = 0;
    for (size_t i = 0; i < ratios.size(); ++i)
      if (part[i] == p) {
        mean_ += ratios[i];
        square += ratios[i] * ratios[i].transpose();
        count += 1;
        of_thin += thin[i];
      }
    known_ = count > 0;
    if (!known_) return;
    mean_ /= count;
    const Eigen::Matrix2d covariance =
        square / count - mean_ * mean_.transpose() + spread * spread * Eigen::Matrix2d::Identity();
    inverse_ = covariance.inverse();
    half_log_ = 0.5 * std::log(covariance.determinant());
    of_thin_ = -std::log((of_thin + 1) / (count + 2));
    of_thick_ = -std::log((count - of_thin + 1) / (count + 2));
  }
  double cost(const Ratios& ratios, bool thin) const {
    return known_ ? 0.5 * (ratios - mean_).dot(inverse_ * (ratios - mean_)) + half_log_ + (thin ? of_thin_ : of_thick_)
                  : INFINITY;
  }

 private:
  bool known_ = false;
  Ratios mean_ = Ratios::Zero();
  Eigen::Matrix2d inverse_;
  double half_log_ = 0, of_thin_ = 0, of_thick_ = 0;
};

}  // namespace

std::vector<uint32_t> settle_parts(const SettleOptions& options, std::vector<uint32_t> part,
                                   std::span<const Vec3f> position, std::span<const Vec3f> color,
                                   std::span<const uint8_t> thin, std::span<const uint8_t> held) {
  CHECK(part.size() == position.size() && part.size() == color.size() && part.size() == thin.size() &&
        (held.empty() || held.size() == part.size()));
  std::vector<size_t> free;
  for (size_t i = 0; i < part.size(); ++i)
    if (held.empty() || !held[i]) free.push_back(i);
  if (free.empty()) return part;
  std::vector<Vec3f> place;
  std::vector<Ratios> ratios;
  std::vector<bool> is_thin;
  std::vector<uint32_t> of;
  for (const size_t i : free) {
    const Eigen::Array3d c = color[i].cast<double>().array() + options.dark;
    place.push_back(position[i]);
    of.push_back(part[i]);
    ratios.push_back({std::log(c[0] / c[1]), std::log(c[2] / c[1])});
    is_thin.push_back(thin[i]);
  }
  const int k = std::min<int>(options.neighbours + 1, static_cast<int>(free.size()));
  const std::vector<int> neighbour = k_nearest(place, place, k);  // itself among them
  const uint32_t parts = *std::max_element(of.begin(), of.end()) + 1;
  for (int round = 0; round < options.rounds; ++round) {
    std::vector<LookOfPart> looks;
    for (uint32_t p = 0; p < parts; ++p) looks.emplace_back(ratios, is_thin, of, p, options.spread);
    bool moved = false;
    for (size_t i = 0; i < of.size(); ++i) {
      std::vector<double> cost(parts);
      for (uint32_t p = 0; p < parts; ++p) cost[p] = looks[p].cost(ratios[i], is_thin[i]);
      for (int j = 0; j < k; ++j)
        if (const size_t n = neighbour[i * k + j]; n != i) cost[of[n]] -= options.like;
      const uint32_t best = static_cast<uint32_t>(std::min_element(cost.begin(), cost.end()) - cost.begin());
      moved |= best != of[i];
      of[i] = best;
    }
    if (!moved) break;
  }
  for (size_t f = 0; f < free.size(); ++f) part[free[f]] = of[f];
  return numbered(std::move(part));
}

}  // namespace pliant

#include "fitting/fit/parts.h"

#include <algorithm>
#include <cmath>

#include "gaussians/base/error.h"

namespace pliant {
namespace {

using Feature = Eigen::Matrix<double, 6, 1>;

size_t nearest(const std::vector<Feature>& centres, const Feature& x, double& square) {
  size_t best = 0;
  square = INFINITY;
  for (size_t c = 0; c < centres.size(); ++c)
    if (const double d = (centres[c] - x).squaredNorm(); d < square) {
      square = d;
      best = c;
    }
  return best;
}

}  // namespace

std::vector<uint32_t> numbered(std::vector<uint32_t> part) {
  std::vector<int> number(part.empty() ? 0 : *std::max_element(part.begin(), part.end()) + 1, -1);
  int next = 0;
  for (uint32_t& p : part) {
    if (number[p] < 0) number[p] = next++;
    p = static_cast<uint32_t>(number[p]);
  }
  return part;
}

std::vector<uint32_t> find_parts(const PartsOptions& options, std::span<const Vec3f> position,
                                 std::span<const Vec3f> color, std::span<const uint8_t> held) {
  CHECK(position.size() == color.size() && options.count >= 1 && (held.empty() || held.size() == position.size()));
  const auto free = [&](size_t i) { return held.empty() || !held[i]; };
  Box box;
  for (size_t i = 0; i < position.size(); ++i)
    if (free(i)) box.add(position[i]);
  const double extent = box.empty() ? 1 : std::max(1e-12f, box.size().maxCoeff());
  std::vector<Feature> points(position.size());
  Feature mean = Feature::Zero();
  double counted = 0;
  for (size_t i = 0; i < points.size(); ++i) {
    points[i] << position[i].cast<double>() / extent, options.color_weight * color[i].cast<double>();
    if (free(i)) {
      mean += points[i];
      counted += 1;
    }
  }
  mean /= std::max(1.0, counted);
  // First the point farthest from the middle, then each time the one farthest from all centres so far.
  std::vector<Feature> centres;
  while (static_cast<int>(centres.size()) < options.count) {
    double farthest = 1e-12;
    const Feature* next = nullptr;
    for (size_t i = 0; i < points.size(); ++i) {
      if (!free(i)) continue;
      double square = (points[i] - mean).squaredNorm();
      if (!centres.empty()) nearest(centres, points[i], square);
      if (square > farthest) {
        farthest = square;
        next = &points[i];
      }
    }
    if (!next) break;
    centres.push_back(*next);
  }
  if (centres.empty()) centres.push_back(mean);
  std::vector<uint32_t> part(points.size(), 0);
  for (int round = 0; round < options.iterations; ++round) {
    bool moved = false;
    std::vector<Feature> sum(centres.size(), Feature::Zero());
    std::vector<double> count(centres.size(), 0.0);
    for (size_t i = 0; i < points.size(); ++i) {
      double square;
      const uint32_t c = static_cast<uint32_t>(nearest(centres, points[i], square));
      moved |= c != part[i] || round == 0;
      part[i] = c;
      if (free(i)) {
        sum[c] += points[i];
        count[c] += 1;
      }
    }
    for (size_t c = 0; c < centres.size(); ++c)
      if (count[c] > 0) centres[c] = sum[c] / count[c];
    if (!moved) break;
  }
  return numbered(std::move(part));
}

std::optional<std::vector<uint32_t>> join_alike(const PartsOptions& options, std::span<const uint32_t> part,
                                                std::span<const Vec3f> color, std::span<const uint8_t> thin,
                                                std::span<const uint8_t> held) {
  CHECK(part.size() == color.size() && part.size() == thin.size() && (held.empty() || held.size() == part.size()));
  struct Look {
    Eigen::Vector4d sum = Eigen::Vector4d::Zero();
    double count = 0;
    std::vector<uint32_t> members;
    Eigen::Vector4d mean() const { return sum / count; }
  };
  const size_t parts = part.empty() ? 0 : *std::max_element(part.begin(), part.end()) + 1;
  std::vector<Look> looks(parts);
  for (size_t i = 0; i < part.size(); ++i) {
    if (!held.empty() && held[i]) continue;
    Eigen::Vector4d look;
    look << color[i].cast<double>(), options.thin_weight * (thin[i] ? 1 : 0);
    looks[part[i]].sum += look;
    looks[part[i]].count += 1;
  }
  for (uint32_t p = 0; p < parts; ++p) looks[p].members = {p};
  std::erase_if(looks, [](const Look& look) { return look.count == 0; });
  while (looks.size() > 1) {
    double least = INFINITY;
    size_t first = 0, second = 0;
    for (size_t a = 0; a < looks.size(); ++a)
      for (size_t b = a + 1; b < looks.size(); ++b)
        if (const double d = (looks[a].mean() - looks[b].mean()).norm(); d < least) {
          least = d;
          first = a;
          second = b;
        }
    if (!(least < options.alike)) break;
    Look& kept = looks[first];
    kept.sum += looks[second].sum;
    kept.count += looks[second].count;
    kept.members.insert(kept.members.end(), looks[second].members.begin(), looks[second].members.end());
    looks.erase(looks.begin() + static_cast<std::ptrdiff_t>(second));
  }
  if (looks.size() < 2) return std::nullopt;
  std::vector<uint32_t> out(part.begin(), part.end());
  std::vector<uint32_t> material(parts, 0);
  for (uint32_t m = 0; m < looks.size(); ++m)
    for (const uint32_t p : looks[m].members) material[p] = m;
  for (uint32_t& p : out) p = material[p];
  return numbered(std::move(out));
}

}  // namespace pliant

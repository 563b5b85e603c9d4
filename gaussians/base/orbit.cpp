#include "gaussians/base/orbit.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <tuple>

#include "gaussians/base/error.h"

namespace pliant {
namespace {

constexpr double kTail = 0.02;
constexpr double kMostGrowth = 0.25;   // of the box by area beyond the box by opacity / its extent
constexpr float kLargestSize = 0.02f;  // of a standard deviation that counts / diagonal of the box by opacity
constexpr double kDegree = M_PI / 180;

}  // namespace

double weighted_percentile(std::span<const float> value, std::span<const float> weight, double fraction) {
  CHECK(!value.empty() && (weight.empty() || weight.size() == value.size()));
  struct Item {
    float value, weight;
  };
  std::vector<Item> items;
  items.reserve(value.size());
  double total = 0;
  for (size_t i = 0; i < value.size(); ++i) {
    items.push_back({value[i], weight.empty() ? 1.0f : weight[i]});
    total += items.back().weight;
  }
  // Halves the range that holds it: all before `begin` are smaller and weigh `below`.
  double below = 0;
  auto begin = items.begin(), end = items.end();
  while (end - begin > 1) {
    const auto middle = begin + (end - begin) / 2;
    std::nth_element(begin, middle, end, [](const Item& a, const Item& b) { return a.value < b.value; });
    const double sum = std::accumulate(begin, middle, 0.0, [](double s, const Item& item) { return s + item.weight; });
    if (below + sum >= fraction * total) {
      end = middle;
    } else {
      below += sum;
      begin = middle;
    }
  }
  return begin->value;
}

namespace {

/// 2 and 98 % percentiles of the positions along the axes.
std::pair<Eigen::Vector3d, Eigen::Vector3d> percentile_box(const GaussianCloud& cloud, const Eigen::Matrix3d& axes,
                                                           const std::vector<float>& weight) {
  std::vector<float> value(cloud.size());
  Eigen::Vector3d low, high;
  for (int axis = 0; axis < 3; ++axis) {
    const Vec3f direction = axes.col(axis).cast<float>();
    for (size_t i = 0; i < cloud.size(); ++i) value[i] = direction.dot(cloud.position[i]);
    low[axis] = weighted_percentile(value, weight, kTail);
    high[axis] = weighted_percentile(value, weight, 1 - kTail);
  }
  return {low, high};
}

std::vector<float> opacities(const GaussianCloud& cloud) {
  std::vector<float> opacity(cloud.size());
  for (size_t i = 0; i < cloud.size(); ++i) opacity[i] = sigmoid(cloud.opacity_logit[i]);
  return opacity;
}

/// Opacity times the product of the two largest standard deviations, each at most `largest`.
std::vector<float> areas(const GaussianCloud& cloud, float largest) {
  std::vector<float> area = opacities(cloud);
  for (size_t i = 0; i < cloud.size(); ++i) {
    const Vec3f size = cloud.log_scale[i].array().exp().min(largest);
    Eigen::Index least;
    size.minCoeff(&least);
    area[i] *= size[(least + 1) % 3] * size[(least + 2) % 3];
  }
  return area;
}

}  // namespace

std::vector<float> visible_area(const GaussianCloud& cloud) {
  const auto [low, high] = percentile_box(cloud, Eigen::Matrix3d::Identity(), opacities(cloud));
  return areas(cloud, kLargestSize * static_cast<float>((high - low).norm()));
}

Framing robust_framing(const GaussianCloud& cloud, const Eigen::Vector3d& up) {
  CHECK(cloud.size() > 0 && up.norm() > 0);
  Framing framing;
  const Eigen::Vector3d vertical = up.normalized();
  // The horizontal axes follow the world axis that is least vertical, so that they do not jump with small tilts.
  int least = 0;
  vertical.cwiseAbs().minCoeff(&least);
  const Eigen::Vector3d forward = vertical.cross(Eigen::Vector3d::Unit(least)).normalized();
  framing.axes << forward.cross(vertical), forward, vertical;

  std::tie(framing.low, framing.high) = percentile_box(cloud, framing.axes, opacities(cloud));
  // Plain surfaces have few but large Gaussians, fine things many small ones: neither may be cut off.
  const Eigen::Vector3d extent = framing.high - framing.low;
  const auto [low, high] =
      percentile_box(cloud, framing.axes, areas(cloud, kLargestSize * static_cast<float>(extent.norm())));
  framing.low = framing.low.cwiseMin(low.cwiseMax(framing.low - kMostGrowth * extent));
  framing.high = framing.high.cwiseMax(high.cwiseMin(framing.high + kMostGrowth * extent));
  return framing;
}

double seen_beyond(const GaussianCloud& cloud, double diagonal) {
  constexpr double kReach = 2;  // standard deviations, to either side
  std::vector<float> size(cloud.size());
  for (size_t i = 0; i < cloud.size(); ++i) size[i] = std::exp(cloud.log_scale[i].maxCoeff());
  const double reach = kReach * weighted_percentile(size, opacities(cloud), 0.5);
  return diagonal < 2 * reach ? reach : 0;
}

std::vector<Camera> orbit_cameras(const OrbitOptions& options, const GaussianCloud& cloud, const Eigen::Vector3d& up) {
  CHECK(options.views > 0 && !options.elevations.empty());
  Framing framing = robust_framing(cloud, up);
  if (const double reach = seen_beyond(cloud, framing.diagonal()); reach > 0) {
    framing.low.array() -= reach;
    framing.high.array() += reach;
  }
  const Eigen::Vector3d centre = framing.centre(), vertical = framing.axes.col(2);
  const double focal = 0.5 * std::max(options.width, options.height) / std::tan(0.5 * options.field_of_view * kDegree);
  std::vector<Eigen::Vector3d> direction(options.views);
  for (int i = 0; i < options.views; ++i) {
    const double azimuth = 2 * M_PI * i / options.views;
    const double elevation = options.elevations[i % options.elevations.size()] * kDegree;
    direction[i] = framing.axes * Eigen::Vector3d(std::cos(elevation) * std::sin(azimuth),
                                                  -std::cos(elevation) * std::cos(azimuth), std::sin(elevation));
  }
  // A corner at offset p from the centre is inside the picture if |p . right| <= (distance + p . forward) * slope.
  const double slope_x = 0.5 * options.width / focal, slope_y = 0.5 * options.height / focal;
  double distance = 1e-3;
  for (const Eigen::Vector3d& back : direction) {
    const Camera camera = look_at(back, Eigen::Vector3d::Zero(), vertical, options.width, options.height, focal);
    for (int corner = 0; corner < 8; ++corner) {
      const Eigen::Vector3d pick(corner & 1, (corner >> 1) & 1, corner >> 2);
      const Eigen::Vector3d world =
          framing.axes * (framing.low + pick.cwiseProduct(framing.high - framing.low)) - centre;
      const Eigen::Vector3d p = camera.cam_from_world.linear() * world;
      distance = std::max({distance, std::abs(p.x()) / slope_x - p.z(), std::abs(p.y()) / slope_y - p.z()});
    }
  }
  std::vector<Camera> cameras;
  for (int i = 0; i < options.views; ++i) {
    cameras.push_back(look_at(centre + options.margin * distance * direction[i], centre, vertical, options.width,
                              options.height, focal));
    char name[32];
    std::snprintf(name, sizeof name, "orbit_%03d", i);
    cameras.back().name = name;
  }
  return cameras;
}

std::vector<Camera> orbit_path(const OrbitPathOptions& options, const Camera& first, const Eigen::Vector3d& pivot,
                               const Eigen::Vector3d& up) {
  CHECK(options.frames > 0 && up.norm() > 0);
  std::vector<Camera> path;
  for (int i = 0; i < options.frames; ++i) {
    const double phase = 2 * M_PI * i / options.frames;
    const double angle = options.degrees >= 360 ? phase : options.degrees * kDegree * std::sin(phase);
    const Eigen::Isometry3d turn =
        Eigen::Translation3d(pivot) * Eigen::AngleAxisd(-angle, up.normalized()) * Eigen::Translation3d(-pivot);
    Camera camera = first;
    camera.cam_from_world = first.cam_from_world * turn;
    camera.photo.clear();
    char name[32];
    std::snprintf(name, sizeof name, "path_%04d", i);
    camera.name = name;
    path.push_back(camera);
  }
  return path;
}

}  // namespace pliant

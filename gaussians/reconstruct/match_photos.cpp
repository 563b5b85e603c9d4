#include "gaussians/reconstruct/match_photos.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <set>

#include "gaussians/base/quantile.h"

namespace pliant {
namespace {

// OpenCV finds features in a copy of twice the size whose pixel centres it takes for those of the photo: they come out
// a quarter of a pixel too far right and down.
constexpr float kSiftShift = 0.25f;
constexpr double kWidestAngle = 75 * M_PI / 180;  // between the directions of two photos that are matched
constexpr double kAngleUnit = 20 * M_PI / 180;    // as far apart as two neighbouring places

int squared_distance(const std::array<uint8_t, 128>& a, const std::array<uint8_t, 128>& b) {
  int sum = 0;
  for (size_t k = 0; k < a.size(); ++k) {
    const int d = static_cast<int>(a[k]) - static_cast<int>(b[k]);
    sum += d * d;
  }
  return sum;
}

/// The two nearest descriptors met so far.
struct Best {
  int index = -1, distance = INT32_MAX, second = INT32_MAX;

  void add(int candidate, int d) {
    if (d < distance) {
      second = distance;
      distance = d;
      index = candidate;
    } else if (d < second) {
      second = d;
    }
  }
  bool clear(double squared_ratio) const { return index >= 0 && distance < squared_ratio * second; }
};

/// Points of a picture by cells of a square grid, so that those near a line are found without looking at all.
class FeatureGrid {
 public:
  explicit FeatureGrid(const std::vector<Vec2f>& points) : points_(points) {
    for (const Vec2f& p : points) {
      columns_ = std::max(columns_, cell(p.x()) + 1);
      rows_ = std::max(rows_, cell(p.y()) + 1);
    }
    first_.assign(static_cast<size_t>(columns_) * rows_ + 1, 0);
    for (const Vec2f& p : points) ++first_[number(cell(p.x()), cell(p.y())) + 1];
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    members_.resize(points.size());
    std::vector<int> next(first_.begin(), first_.end() - 1);
    for (size_t i = 0; i < points.size(); ++i) {
      members_[next[number(cell(points[i].x()), cell(points[i].y()))]++] = static_cast<int>(i);
    }
  }

  /// The points within `band` of the line l.x u + l.y v + l.z = 0, whose normal is a unit vector.
  void near_line(const Vec3f& l, float band, std::vector<int>& found) const {
    found.clear();
    const bool flat = std::abs(l.y()) > std::abs(l.x());  // nearer to horizontal: cells are walked along u
    const int main = flat ? 0 : 1, other = 1 - main;
    if (!(std::abs(l[other]) > 0)) return;
    const int steps = flat ? columns_ : rows_, width = flat ? rows_ : columns_;
    const float margin = band / std::abs(l[other]);
    for (int step = 0; step < steps; ++step) {
      const float a = -(l[main] * kCell * step + l.z()) / l[other], b = a - l[main] * kCell / l[other];
      const float low = std::min(a, b) - margin, high = std::max(a, b) + margin;
      if (!(high >= 0 && low < kCell * width)) continue;
      for (int k = cell(low); k <= std::min(width - 1, cell(high)); ++k) {
        const size_t n = flat ? number(step, k) : number(k, step);
        for (int m = first_[n]; m < first_[n + 1]; ++m) {
          const Vec2f& p = points_[members_[m]];
          if (std::abs(l.x() * p.x() + l.y() * p.y() + l.z()) < band) found.push_back(members_[m]);
        }
      }
    }
  }

 private:
  static constexpr float kCell = 24;
  static int cell(float x) { return static_cast<int>(std::clamp(x / kCell, 0.0f, 1e6f)); }
  size_t number(int column, int row) const { return static_cast<size_t>(row) * columns_ + column; }

  const std::vector<Vec2f>& points_;
  int columns_ = 0, rows_ = 0;
  std::vector<int> first_, members_;
};

}  // namespace

PhotoFeatures find_features(const FeatureOptions& options, const TrainingPhoto& photo) {
  const ImageU8& pixels = photo.pixels;
  if (pixels.empty()) return {};
  const cv::Mat color(pixels.height, pixels.width, CV_8UC3, const_cast<uint8_t*>(pixels.data.data()));
  cv::Mat grey;
  cv::cvtColor(color, grey, cv::COLOR_RGB2GRAY);
  const int longest = std::max(grey.cols, grey.rows);
  if (longest > options.longest_side) {
    const double scale = static_cast<double>(options.longest_side) / longest;
    cv::resize(grey, grey, cv::Size(), scale, scale, cv::INTER_AREA);
  }
  const float across = static_cast<float>(pixels.width) / grey.cols,
              down = static_cast<float>(pixels.height) / grey.rows;
  std::vector<cv::KeyPoint> points;
  cv::Mat descriptors;
  cv::SIFT::create(options.most, 3, options.contrast)->detectAndCompute(grey, cv::noArray(), points, descriptors);
  std::vector<int> order(points.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return points[a].response > points[b].response; });

  PhotoFeatures features;
  for (const int i : order) {
    const Vec2f pixel((points[i].pt.x + 0.5f - kSiftShift) * across, (points[i].pt.y + 0.5f - kSiftShift) * down);
    const int x = std::clamp(static_cast<int>(pixel.x()), 0, pixels.width - 1);
    const int y = std::clamp(static_cast<int>(pixel.y()), 0, pixels.height - 1);
    if (!photo.weight.empty() && photo.weight(x, y) == 0) continue;
    if (static_cast<int>(features.size()) == options.most) break;  // equal responses give a few more
    const float* raw = descriptors.ptr<float>(i);
    const float sum = std::max(1e-6f, std::accumulate(raw, raw + 128, 0.0f));
    std::array<uint8_t, 128> root;
    for (int k = 0; k < 128; ++k)
      root[k] = static_cast<uint8_t>(std::min(255.0f, 512 * std::sqrt(raw[k] / sum) + 0.5f));
    features.pixel.push_back(pixel);
    features.descriptor.push_back(root);
  }
  return features;
}

std::vector<PhotoPair> overlapping_pairs(const std::vector<Camera>& cameras, int neighbours) {
  const int n = static_cast<int>(cameras.size());
  std::vector<Vec3d> centre, forward;
  for (const Camera& camera : cameras) {
    centre.push_back(camera.centre());
    forward.push_back(camera.forward());
  }
  // The unit of distance: how far neighbouring places typically are from each other.
  std::vector<double> nearest;
  for (int i = 0; i < n; ++i) {
    std::vector<double> distance;
    for (int j = 0; j < n; ++j) {
      if (j != i) distance.push_back((centre[j] - centre[i]).norm());
    }
    if (distance.empty()) return {};
    const auto fourth = distance.begin() + std::min<std::ptrdiff_t>(3, distance.size() - 1);
    std::nth_element(distance.begin(), fourth, distance.end());
    nearest.push_back(*fourth);
  }
  const double unit = quantile(nearest, 0.5);
  if (!(unit > 0)) return {};

  std::set<std::pair<int, int>> pairs;
  for (int i = 0; i < n; ++i) {
    std::vector<std::pair<double, int>> candidates;
    for (int j = 0; j < n; ++j) {
      const double angle = std::acos(std::clamp(forward[i].dot(forward[j]), -1.0, 1.0));
      const double distance = (centre[j] - centre[i]).norm();
      if (j == i || angle > kWidestAngle || distance < 1e-3 * unit) continue;
      candidates.emplace_back(std::hypot(distance / unit, angle / kAngleUnit), j);
    }
    std::sort(candidates.begin(), candidates.end());
    // Ranks 0, 1, 2, 3, 5, 7, 9, 12, ...: steps grow, so that both many common features and parallax are found.
    size_t rank = 0;
    for (int k = 0; k < neighbours && rank < candidates.size(); ++k, rank += 1 + static_cast<size_t>(k) / 4) {
      const int j = candidates[rank].second;
      pairs.emplace(std::min(i, j), std::max(i, j));
    }
  }
  std::vector<PhotoPair> result;
  for (const auto& [i, j] : pairs) result.push_back({i, j});
  return result;
}

Mat3d essential_matrix(const Eigen::Isometry3d& cam1_from_world, const Eigen::Isometry3d& cam2_from_world) {
  const Eigen::Isometry3d relative = cam2_from_world * cam1_from_world.inverse();
  const Vec3d t = relative.translation();
  Mat3d cross;
  cross << 0, -t.z(), t.y(), t.z(), 0, -t.x(), -t.y(), t.x(), 0;
  return cross * relative.linear();
}

Mat3d fundamental_matrix(const Camera& camera1, const Camera& camera2) {
  const auto inverse_intrinsics = [](const Camera& c) {
    Mat3d K;
    K << 1 / c.fx, 0, -c.cx / c.fx, 0, 1 / c.fy, -c.cy / c.fy, 0, 0, 1;
    return K;
  };
  return inverse_intrinsics(camera2).transpose() * essential_matrix(camera1.cam_from_world, camera2.cam_from_world) *
         inverse_intrinsics(camera1);
}

double sampson_distance(const Mat3d& F, const Vec2f& u1, const Vec2f& u2) {
  const Vec3d a(u1.x(), u1.y(), 1), b(u2.x(), u2.y(), 1);
  const Vec3d line2 = F * a, line1 = F.transpose() * b;
  const double slope = line2.head<2>().squaredNorm() + line1.head<2>().squaredNorm();
  return slope > 0 ? std::abs(b.dot(line2)) / std::sqrt(slope) : INFINITY;
}

std::vector<FeatureMatch> match_features(const MatchOptions& options, const PhotoFeatures& features1,
                                         const PhotoFeatures& features2, const Mat3d* F) {
  const int n1 = static_cast<int>(features1.size()), n2 = static_cast<int>(features2.size());
  std::vector<Best> best1(n1), best2(n2);
  std::vector<int> partners(n2);
  std::iota(partners.begin(), partners.end(), 0);
  const std::vector<Vec2f> none;
  const FeatureGrid grid(F ? features2.pixel : none);
  for (int i = 0; i < n1; ++i) {
    if (F) {
      const Vec3d line = *F * Vec3d(features1.pixel[i].x(), features1.pixel[i].y(), 1);
      grid.near_line((line / std::max(line.head<2>().norm(), 1e-300)).cast<float>(), static_cast<float>(options.band),
                     partners);
    }
    for (const int j : partners) {
      const int d = squared_distance(features1.descriptor[i], features2.descriptor[j]);
      best1[i].add(j, d);
      best2[j].add(i, d);
    }
  }
  const double squared_ratio = options.ratio * options.ratio;
  std::vector<FeatureMatch> matches;
  for (int i = 0; i < n1; ++i) {
    if (!best1[i].clear(squared_ratio)) continue;
    const Best& back = best2[best1[i].index];
    if (back.index == i && back.clear(squared_ratio)) matches.push_back({i, best1[i].index, best1[i].distance});
  }
  return matches;
}

}  // namespace pliant

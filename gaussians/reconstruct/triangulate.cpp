#include "gaussians/reconstruct/triangulate.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "gaussians/base/lens.h"
#include "gaussians/base/portable.h"
#include "gaussians/base/random.h"

namespace pliant {
namespace {

constexpr int kGaussNewtonSteps = 5;
constexpr int kMostHypotheses = 30;  // pairs of sightings that are tried for a track
constexpr size_t kLongestTrack = 400;

struct Feature {
  int photo, index;
};

/// A track that was triangulated: the sightings that agree with it.
struct Point {
  Vec3d position;
  std::vector<Feature> features;
};

/// Disjoint sets with the smallest member as representative.
class Sets {
 public:
  explicit Sets(int n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), 0); }
  int find(int i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void unite(int i, int j) {
    i = find(i), j = find(j);
    parent_[std::max(i, j)] = std::min(i, j);
  }

 private:
  std::vector<int> parent_;
};

double squared_error(const Sighting& sighting, const Vec3d& point) {
  const auto pixel = project(*sighting.camera, point);
  return pixel ? (*pixel - sighting.pixel.cast<double>()).squaredNorm() : INFINITY;
}

double widest_angle(const std::vector<Sighting>& sightings, const Vec3d& point) {
  double smallest_cosine = 1;
  for (size_t i = 0; i < sightings.size(); ++i) {
    for (size_t j = 0; j < i; ++j) {
      const Vec3d a = (point - sightings[i].camera->centre()).normalized();
      const Vec3d b = (point - sightings[j].camera->centre()).normalized();
      smallest_cosine = std::min(smallest_cosine, a.dot(b));
    }
  }
  return std::acos(std::clamp(smallest_cosine, -1.0, 1.0));
}

/// Finds the points of one set of photos.
class Triangulation {
 public:
  Triangulation(const TriangulateOptions& options, const TrainingPhotos& photos) : options_(options), photos_(photos) {
    for (size_t i = 0; i < photos.photos.size(); ++i) {
      if (!photos.photos[i].held_out) used_.push_back(static_cast<int>(i));
    }
    fewest_views_ = used_.size() < 8 ? std::min(2, options.fewest_views) : options.fewest_views;
    find_all_features();
  }

  SparsePoints run() {
    std::vector<std::vector<Feature>> tracks = merge(match_pairs());
    std::vector<Point> points(tracks.size());
    parallel_for(
        static_cast<std::ptrdiff_t>(tracks.size()),
        [&](std::ptrdiff_t t) { points[t] = triangulate_track(tracks[t], static_cast<uint64_t>(t)); }, 64);
    return collect(points);
  }

 private:
  const TrainingPhoto& photo(int used) const { return photos_.photos[used_[used]]; }
  double scale(int used) const { return std::max(photo(used).pixels.width, photo(used).pixels.height) / 1000.0; }

  void find_all_features() {
    features_.resize(used_.size());
    parallel_for(static_cast<std::ptrdiff_t>(used_.size()),
                 [&](std::ptrdiff_t i) { features_[i] = find_features(options_.features, photo(static_cast<int>(i))); });
    first_.assign(1, 0);
    for (const PhotoFeatures& features : features_) first_.push_back(first_.back() + static_cast<int>(features.size()));
  }

  /// Pairs of features, numbered through all photos.
  std::vector<std::array<int, 2>> match_pairs() {
    std::vector<Camera> cameras;
    for (size_t i = 0; i < used_.size(); ++i) cameras.push_back(photo(static_cast<int>(i)).camera);
    const std::vector<PhotoPair> pairs = overlapping_pairs(cameras, options_.neighbours);
    pairs_ = pairs.size();
    std::vector<std::vector<std::array<int, 2>>> found(pairs.size());
    parallel_for(static_cast<std::ptrdiff_t>(pairs.size()), [&](std::ptrdiff_t p) {
      const auto [i, j] = pairs[p];
      const Mat3d F = fundamental_matrix(cameras[i], cameras[j]);
      MatchOptions options = options_.matches;
      options.band *= scale(j);
      found[p] = match_features(options, features_[i], features_[j], &F);
      for (auto& [a, b] : found[p]) a += first_[i], b += first_[j];
    });
    std::vector<std::array<int, 2>> matches;
    for (const auto& some : found) matches.insert(matches.end(), some.begin(), some.end());
    return matches;
  }

  std::vector<std::vector<Feature>> merge(const std::vector<std::array<int, 2>>& matches) {
    Sets sets(first_.back());
    for (const auto& [a, b] : matches) sets.unite(a, b);
    std::map<int, std::vector<Feature>> members;
    for (size_t i = 0; i < features_.size(); ++i) {
      for (int k = first_[i]; k < first_[i + 1]; ++k) members[sets.find(k)].push_back({static_cast<int>(i), k - first_[i]});
    }
    std::vector<std::vector<Feature>> tracks;
    for (auto& [root, features] : members) {
      // A longer chain is repeated texture that was strung together.
      if (features.size() >= 2 && features.size() <= kLongestTrack) tracks.push_back(std::move(features));
    }
    return tracks;
  }

  Sighting sighting(const Feature& f) const { return {&photo(f.photo).camera, features_[f.photo].pixel[f.index]}; }

  /// The features that see `point`, in each photo the nearest one.
  std::vector<Feature> agreeing(const std::vector<Feature>& track, const Vec3d& point) const {
    std::vector<Feature> result;
    double last_error = 0;
    for (const Feature& f : track) {
      const double error = squared_error(sighting(f), point), most = options_.reprojection * scale(f.photo);
      if (!(error < most * most)) continue;
      if (!result.empty() && result.back().photo == f.photo) {
        if (error >= last_error) continue;
        result.pop_back();
      }
      result.push_back(f), last_error = error;
    }
    return result;
  }

  Point triangulate_track(const std::vector<Feature>& track, uint64_t number) const {
    Point best;
    Random random(0, number);
    const uint64_t n = track.size(), pairs = n * (n - 1) / 2;
    const double smallest_angle = options_.smallest_angle * M_PI / 180;
    for (uint64_t h = 0; h < std::min<uint64_t>(pairs, kMostHypotheses); ++h) {
      // Pair number k of the triangle j < i.
      const uint64_t k = pairs <= kMostHypotheses ? h : random.below(pairs);
      const auto i = static_cast<uint64_t>((1 + std::sqrt(1 + 8.0 * static_cast<double>(k))) / 2), j = k - i * (i - 1) / 2;
      if (track[i].photo == track[j].photo) continue;
      Vec3d point;
      const Sighting two[] = {sighting(track[i]), sighting(track[j])};
      if (!triangulate_point(two, point)) continue;
      std::vector<Feature> features = agreeing(track, point);
      if (features.size() > best.features.size()) best = {point, std::move(features)};
    }
    // The position from all of them, and those that agree with it.
    for (int round = 0; round < 2 && static_cast<int>(best.features.size()) >= fewest_views_; ++round) {
      std::vector<Sighting> sightings;
      for (const Feature& f : best.features) sightings.push_back(sighting(f));
      if (!triangulate_point(sightings, best.position) || widest_angle(sightings, best.position) < smallest_angle) return {};
      best.features = agreeing(track, best.position);
    }
    return static_cast<int>(best.features.size()) >= fewest_views_ ? best : Point();
  }

  SparsePoints collect(const std::vector<Point>& points) const {
    SparsePoints result;
    std::vector<double> errors;
    for (const Point& point : points) {
      if (point.features.empty()) continue;
      Vec3f color = Vec3f::Zero();
      for (const Feature& f : point.features) {
        const ImageU8& pixels = photo(f.photo).pixels;
        const Sighting s = sighting(f);
        const uint8_t* rgb = pixels.at(std::clamp(static_cast<int>(s.pixel.x()), 0, pixels.width - 1),
                                       std::clamp(static_cast<int>(s.pixel.y()), 0, pixels.height - 1));
        color += Vec3f(rgb[0], rgb[1], rgb[2]) / 255;
        result.observations.push_back({static_cast<int>(result.position.size()), used_[f.photo], s.pixel});
        errors.push_back(std::sqrt(squared_error(s, point.position)));
      }
      result.position.push_back(point.position.cast<float>());
      result.color.push_back(color / static_cast<float>(point.features.size()));
    }
    std::string error = "0";
    if (!errors.empty()) {
      std::nth_element(errors.begin(), errors.begin() + errors.size() / 2, errors.end());
      error = std::to_string(errors[errors.size() / 2]).substr(0, 4);
    }
    result.source = std::to_string(result.position.size()) + " points triangulated from features of " +
                    std::to_string(used_.size()) + " photos (" + std::to_string(pairs_) +
                    " pairs matched; median reprojection error " + error + " px)";
    return result;
  }

  const TriangulateOptions& options_;
  const TrainingPhotos& photos_;
  std::vector<int> used_;  // photos that are trained on
  std::vector<PhotoFeatures> features_;
  std::vector<int> first_;  // number of the first feature of each of them
  int fewest_views_ = 2;
  size_t pairs_ = 0;
};

}  // namespace

bool triangulate_point(std::span<const Sighting> sightings, Vec3d& point) {
  // Nearest to all rays: sum of (I - d dᵀ)(x - c) = 0.
  Mat3d A = Mat3d::Zero();
  Vec3d b = Vec3d::Zero();
  for (const Sighting& s : sightings) {
    const Vec3d d = s.camera->ray(s.pixel.x(), s.pixel.y());
    const Mat3d across = Mat3d::Identity() - d * d.transpose();
    A += across, b += across * s.camera->centre();
  }
  const Eigen::LDLT<Mat3d> solver(A);
  if (!(solver.vectorD().minCoeff() > 1e-10)) return false;
  point = solver.solve(b);
  for (int step = 0; step <= kGaussNewtonSteps; ++step) {
    Mat3d JtJ = Mat3d::Zero();
    Vec3d Jtr = Vec3d::Zero();
    for (const Sighting& s : sightings) {
      const Vec3d p = s.camera->cam_from_world * point;
      if (!(p.z() > 0)) return false;
      const double x = p.x() / p.z(), y = p.y() / p.z();
      Eigen::Matrix<double, 2, 3> J;
      J << s.camera->fx, 0, -s.camera->fx * x, 0, s.camera->fy, -s.camera->fy * y;
      J = (J / p.z() * s.camera->cam_from_world.linear()).eval();
      const Eigen::Vector2d r(s.camera->fx * x + s.camera->cx - s.pixel.x(), s.camera->fy * y + s.camera->cy - s.pixel.y());
      JtJ += J.transpose() * J, Jtr += J.transpose() * r;
    }
    // The last round only looks whether the point lies in front of all cameras.
    if (step < kGaussNewtonSteps) point -= JtJ.ldlt().solve(Jtr);
  }
  return point.allFinite();
}

SparsePoints triangulate_photos(const TriangulateOptions& options, const TrainingPhotos& photos) {
  return Triangulation(options, photos).run();
}

}  // namespace pliant

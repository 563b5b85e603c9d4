#include "gaussians/reconstruct/triangulate.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "gaussians/base/lens.h"
#include "gaussians/base/portable.h"
#include "gaussians/base/quantile.h"
#include "gaussians/base/random.h"

namespace pliant {
namespace {

constexpr int kGaussNewtonSteps = 5;
constexpr double kFewSightings = 0.05;  // of the median number of points that photos see
constexpr int kMostHypotheses = 30;     // pairs of sightings that are tried for a track

struct Feature {
  int photo, index;
};

/// A track that was triangulated: the sightings that agree with it.
struct Point {
  Vec3d position;
  std::vector<Feature> features;
};

/// Disjoint sets of features, none with two features of one photo; the smallest member represents a set.
class Tracks {
 public:
  explicit Tracks(const std::vector<int>& photo_of) : parent_(photo_of.size()), photos_(photo_of.size()) {
    std::iota(parent_.begin(), parent_.end(), 0);
    for (size_t i = 0; i < photo_of.size(); ++i) photos_[i] = {photo_of[i]};
  }
  int find(int i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  /// Joins two sets that have no photo in common.
  void unite(int i, int j) {
    i = find(i);
    j = find(j);
    if (i == j) return;
    if (i > j) std::swap(i, j);
    std::vector<int> both;
    std::set_union(photos_[i].begin(), photos_[i].end(), photos_[j].begin(), photos_[j].end(),
                   std::back_inserter(both));
    if (both.size() != photos_[i].size() + photos_[j].size()) return;
    parent_[j] = i;
    photos_[i] = std::move(both);
    photos_[j] = {};
  }

 private:
  std::vector<int> parent_;
  std::vector<std::vector<int>> photos_;  // of representatives, ascending
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
    parallel_for(static_cast<std::ptrdiff_t>(used_.size()), [&](std::ptrdiff_t i) {
      features_[i] = find_features(options_.features, photo(static_cast<int>(i)));
    });
    first_.assign(1, 0);
    for (const PhotoFeatures& features : features_) first_.push_back(first_.back() + static_cast<int>(features.size()));
  }

  /// Matches of features that are numbered through all photos, the most certain first.
  std::vector<FeatureMatch> match_pairs() {
    std::vector<Camera> cameras;
    for (size_t i = 0; i < used_.size(); ++i) cameras.push_back(photo(static_cast<int>(i)).camera);
    const std::vector<PhotoPair> pairs = overlapping_pairs(cameras, options_.neighbours);
    pairs_ = pairs.size();
    std::vector<std::vector<FeatureMatch>> found(pairs.size());
    parallel_for(static_cast<std::ptrdiff_t>(pairs.size()), [&](std::ptrdiff_t p) {
      const auto [i, j] = pairs[p];
      const Mat3d F = fundamental_matrix(cameras[i], cameras[j]);
      MatchOptions options = options_.matches;
      options.band *= scale(j);
      found[p] = match_features(options, features_[i], features_[j], &F);
      for (FeatureMatch& m : found[p]) {
        m.first += first_[i];
        m.second += first_[j];
      }
    });
    std::vector<FeatureMatch> matches;
    for (const auto& some : found) matches.insert(matches.end(), some.begin(), some.end());
    std::stable_sort(matches.begin(), matches.end(),
                     [](const FeatureMatch& a, const FeatureMatch& b) { return a.distance < b.distance; });
    return matches;
  }

  std::vector<std::vector<Feature>> merge(const std::vector<FeatureMatch>& matches) {
    std::vector<int> photo_of;
    for (size_t i = 0; i < features_.size(); ++i)
      photo_of.insert(photo_of.end(), features_[i].size(), static_cast<int>(i));
    Tracks sets(photo_of);
    for (const FeatureMatch& m : matches) sets.unite(m.first, m.second);
    std::map<int, std::vector<Feature>> members;
    for (size_t i = 0; i < features_.size(); ++i) {
      for (int k = first_[i]; k < first_[i + 1]; ++k)
        members[sets.find(k)].push_back({static_cast<int>(i), k - first_[i]});
    }
    std::vector<std::vector<Feature>> tracks;
    for (auto& [root, features] : members) {
      if (static_cast<int>(features.size()) >= fewest_views_) tracks.push_back(std::move(features));
    }
    return tracks;
  }

  Sighting sighting(const Feature& f) const { return {&photo(f.photo).camera, features_[f.photo].pixel[f.index]}; }

  /// The features of the track that see `point`.
  std::vector<Feature> agreeing(const std::vector<Feature>& track, const Vec3d& point) const {
    std::vector<Feature> result;
    for (const Feature& f : track) {
      const double most = options_.reprojection * scale(f.photo);
      if (squared_error(sighting(f), point) < most * most) result.push_back(f);
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
      const auto i = static_cast<uint64_t>((1 + std::sqrt(1 + 8.0 * static_cast<double>(k))) / 2),
                 j = k - i * (i - 1) / 2;
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
      if (!triangulate_point(sightings, best.position) || widest_angle(sightings, best.position) < smallest_angle)
        return {};
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
    if (!errors.empty()) error = std::to_string(quantile(errors, 0.5)).substr(0, 4);
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
    A += across;
    b += across * s.camera->centre();
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
      const Eigen::Vector2d r(s.camera->fx * x + s.camera->cx - s.pixel.x(),
                              s.camera->fy * y + s.camera->cy - s.pixel.y());
      JtJ += J.transpose() * J;
      Jtr += J.transpose() * r;
    }
    // The last round only looks whether the point lies in front of all cameras.
    if (step < kGaussNewtonSteps) point -= JtJ.ldlt().solve(Jtr);
  }
  return point.allFinite();
}

SparsePoints triangulate_photos(const TriangulateOptions& options, const TrainingPhotos& photos) {
  return Triangulation(options, photos).run();
}

std::vector<std::string> photos_without_points(const TrainingPhotos& photos, const SparsePoints& points) {
  std::vector<int> seen(photos.photos.size()), sorted;
  for (const SparsePoints::Observation& o : points.observations) ++seen[o.camera];
  for (size_t i = 0; i < seen.size(); ++i) {
    if (!photos.photos[i].held_out) sorted.push_back(seen[i]);
  }
  if (sorted.empty()) return {};
  const int middle = quantile(sorted, 0.5);
  std::vector<std::string> warnings;
  for (size_t i = 0; i < seen.size(); ++i) {
    const Camera& camera = photos.photos[i].camera;
    if (photos.photos[i].held_out || seen[i] >= kFewSightings * middle) continue;
    warnings.push_back((camera.photo.empty() ? camera.name : camera.photo) + ": sees " + std::to_string(seen[i]) +
                       " of the points, other photos typically " + std::to_string(middle) +
                       "; its pose may be wrong, or the photo rotated");
  }
  return warnings;
}

}  // namespace pliant

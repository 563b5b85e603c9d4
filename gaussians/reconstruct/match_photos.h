#pragma once

#include <array>
#include <span>
#include <vector>

#include "gaussians/base/types.h"
#include "gaussians/reconstruct/training_photos.h"

namespace pliant {

/// Local features of one photo.
struct PhotoFeatures {
  std::vector<Vec2f> pixel;                          ///< [N] in the pixels of the photo, strongest first
  std::vector<std::array<uint8_t, 128>> descriptor;  ///< [N] RootSIFT (Arandjelovic and Zisserman 2012) times 512

  size_t size() const { return pixel.size(); }
};

struct FeatureOptions {
  int most = 5000;          ///< features per photo, the strongest
  double contrast = 0.015;  ///< smallest difference of Gaussians of a feature, of the range of colours
  int longest_side = 1200;  ///< px; features of larger photos are found in a smaller copy
};

/// SIFT features (Lowe 2004) where the photo counts.
PhotoFeatures find_features(const FeatureOptions& options, const TrainingPhoto& photo);

struct PhotoPair {
  int first, second;  ///< first < second
};

/// Pairs of `cameras` that look at the same things from different places, as far as poses tell: for each camera a few
/// of its nearest neighbours in position and direction and, more thinly, of its farther ones.
std::vector<PhotoPair> overlapping_pairs(const std::vector<Camera>& cameras, int neighbours);

/// E with x2ᵀ E x1 = 0 for points of the planes z = 1 of the two camera frames.
Mat3d essential_matrix(const Eigen::Isometry3d& cam1_from_world, const Eigen::Isometry3d& cam2_from_world);
/// F with u2ᵀ F u1 = 0 for image points (u, v, 1) of two pinhole cameras.
Mat3d fundamental_matrix(const Camera& camera1, const Camera& camera2);

/// Distance of two image points from agreeing with F, to first order, in pixels (Sampson 1982).
double sampson_distance(const Mat3d& F, const Vec2f& u1, const Vec2f& u2);

struct MatchOptions {
  double ratio = 0.8;  ///< distance of the best / of the second-best descriptor, in both directions (Lowe 2004)
  double band = 0;     ///< px; with F, partners lie so near to their epipolar line; 0 = anywhere
};

struct FeatureMatch {
  int first, second;  ///< features
  int distance;       ///< of their descriptors, squared
};

/// Features of two photos that are each other's best partner, in the order of the first.
std::vector<FeatureMatch> match_features(const MatchOptions& options, const PhotoFeatures& features1,
                                         const PhotoFeatures& features2, const Mat3d* F = nullptr);

}  // namespace pliant

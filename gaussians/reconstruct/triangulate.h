#pragma once

#include <span>
#include <vector>

#include "gaussians/io/cameras/sparse_points.h"
#include "gaussians/reconstruct/match_photos.h"
#include "gaussians/reconstruct/training_photos.h"

namespace pliant {

struct TriangulateOptions {
  FeatureOptions features;
  int neighbours = 12;                               ///< photos with which each one is matched
  MatchOptions matches = {.ratio = 0.8, .band = 3};  ///< band for photos of 1000 px, others in proportion
  double reprojection = 2;                           ///< px, for photos of 1000 px, others in proportion
  double smallest_angle = 1.5;                       ///< degrees between the two most different rays to a point
  int fewest_views = 3;                              ///< that see a point; 2 when there are fewer than 8 photos
};

/// One ray to a point.
struct Sighting {
  const Camera* camera;  ///< pinhole
  Vec2f pixel;
};

/// The point that minimises the squared reprojection errors (Gauss-Newton from the point nearest to all rays); false
/// when it lies behind a camera or the rays are parallel.
bool triangulate_point(std::span<const Sighting> sightings, Vec3d& point);

/// Points seen in the photos that are trained on, in the world of their cameras, whose poses stay as they are: SIFT
/// features, matched between overlapping photos within a band around their epipolar lines, merged into tracks, each
/// triangulated by its largest set of sightings that agree.  Colours are means over the sightings.  Empty when the
/// photos share too little.  Equal bit for bit for any number of threads.
SparsePoints triangulate_photos(const TriangulateOptions& options, const TrainingPhotos& photos);

/// Warnings that name the photos (not held out) which see hardly any of the points, compared with the others: their
/// poses are probably wrong, or they lie upside down, or show something else.
std::vector<std::string> photos_without_points(const TrainingPhotos& photos, const SparsePoints& points);

}  // namespace pliant

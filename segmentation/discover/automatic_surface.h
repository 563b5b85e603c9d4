#pragma once

#include <vector>

#include "gaussians/base/camera.h"
#include "gaussians/base/gaussian_cloud.h"
#include "segmentation/associate/footprint.h"
#include "segmentation/discover/picture_segments.h"
#include "segmentation/graph/gaussian_graph.h"

namespace pliant {

struct SolidOptions {
  float opacity = 0.1f;    ///< fainter Gaussians are haze
  float largest = 8.0f;    ///< and so are those with a standard deviation above so many spacings
  int neighbours = 10;     ///< of the graph
  int most_views = 32;     ///< spread evenly, looked at
  int longest_side = 400;  ///< px; larger views are scaled down
  PictureSegmentOptions segments;
  FootprintOptions footprint;
};

/// The Gaussians that make surfaces, how they lie against each other, and what the views say of them.
struct SolidScene {
  std::vector<int> gaussian;     ///< [S] of the cloud, ascending
  GaussianCloud cloud;           ///< [S]
  GaussianGraph graph;           ///< over all S
  std::vector<Vec3f> normal;     ///< [S] of the surface around, unit, of either sign
  std::vector<float> mass;       ///< [S] blend weight, mean over the views [share of a picture]
  std::vector<float> agreement;  ///< [edges] share of the views that see both ends in which one segment holds both
  int views = 0;

  size_t size() const { return gaussian.size(); }
};

/// Every view is over-segmented by colour, normal and depth; segments reach the Gaussians by their blend weights
/// (footprints), and edges of the graph keep how many views join their ends.  Cameras in `held_out` are not looked at.
SolidScene solid_scene(const SolidOptions& options, const GaussianCloud& cloud, const std::vector<Camera>& cameras,
                       const std::vector<int>& held_out);

}  // namespace pliant

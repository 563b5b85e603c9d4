#pragma once

#include <vector>

#include "gaussians/base/camera.h"
#include "gaussians/base/gaussian_cloud.h"
#include "segmentation/graph/superpoints.h"
#include "segmentation/select/region_view.h"

namespace pliant {

struct PrepareOptions {
  int neighbours = 10;                ///< of the graph
  int part = 24, least_parts = 4000;  ///< most Gaussians of a superpoint, fewer where there would be fewer superpoints
  int most_views = 24;                ///< that are prepared, those that differ most
  int view_pixels = 480;              ///< longer side of a view
  RegionViewOptions view;
};

/// What selecting an object needs of a scene, whatever is selected.
struct PreparedScene {
  PrepareOptions options;
  GaussianGraph graph;            ///< of all Gaussians
  Adjacency adjacency;            ///< of the graph
  Superpoints parts;              ///< of the graph
  std::vector<RegionView> views;  ///< ascending cameras, whole pictures
  std::vector<float> shown;       ///< [N] blend weight in the views (px)
  float diagonal = 0;             ///< of the scene without floaters (scene units)

  /// The prepared view of a camera; null = there is none.
  const RegionView* view_of(int camera) const;
};

/// At most `most` cameras that look from directions and places that differ most, ascending; the first is among them.
/// Fewer are some of more: up to `most_views` all are prepared.
std::vector<int> different_cameras(const std::vector<Camera>& cameras, size_t most);

/// Equal for any number of threads.
PreparedScene prepare_scene(const PrepareOptions& options, const GaussianCloud& cloud,
                            const std::vector<Camera>& cameras);

/// The whole picture of a camera, `longest` px.
WindowView whole_picture(const std::vector<Camera>& cameras, int camera, int longest);

}  // namespace pliant

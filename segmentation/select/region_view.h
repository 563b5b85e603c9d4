#pragma once

#include <vector>

#include "segmentation/graph/min_cut.h"
#include "segmentation/select/window_view.h"

namespace pliant {

struct RegionViewOptions {
  float area = 20;      ///< px of a region
  float color = 0.1f;   ///< see superpixels
  float least = 2e-3f;  ///< of a region's area: weights of Gaussians below it are left out
  RenderOptions render;
};

/// A picture of the scene as regions of like colour, and which Gaussians make each of them.
struct RegionView {
  WindowView window;
  std::vector<uint16_t> region;     ///< [H * W]
  std::vector<Vec3f> lab;           ///< [R] mean colour, see lab_of_rgb
  std::vector<float> area;          ///< [R] px
  std::vector<Vec2f> middle;        ///< [R] px of the window
  std::vector<CutEdge> edges;       ///< between regions side by side: sum over pairs of pixels of
                                    ///< exp(-dLab^2 / (2 mean dLab^2)) / distance, see grab_cut
  std::vector<uint32_t> row_start;  ///< [R + 1] of
  std::vector<uint32_t> gaussian;   ///< the Gaussians that are seen in a region, ascending, and
  std::vector<float> weight;        ///< their blend weights, summed over its pixels

  size_t size() const { return lab.size(); }
};

RegionView region_view(const RegionViewOptions& options, const GaussianCloud& cloud, const WindowView& window);

}  // namespace pliant

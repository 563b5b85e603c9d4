#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "gaussians/base/camera.h"
#include "gaussians/base/gaussian_cloud.h"
#include "gaussians/render/blend_weights.h"
#include "segmentation/labels/mask_set.h"

namespace pliant {

/// Which Gaussians a view's masks stand on.  A mask's footprint is the blend weight [px] that its pixels put on
/// Gaussians; a Gaussian belongs to the mask that holds most of its weight in the view, or to none where it is shared.
struct ViewFootprints {
  int camera = -1;
  std::vector<uint32_t> id;        ///< of each mask, in the order of their first pixels
  std::vector<int> pixels;         ///< of each mask
  std::vector<uint32_t> gaussian;  ///< visible Gaussians, ascending
  std::vector<int> mask;           ///< of each of them; -1 = unlabelled or shared by several masks
  std::vector<float> mass;         ///< blend weight over all pixels of the view

  size_t masks() const { return id.size(); }
};

struct FootprintOptions {
  float least_mass = 0.02f;  ///< px; Gaussians that show less in a view are not visible in it
  float decisive = 0.6f;     ///< share of its weight that a Gaussian's mask holds
  float least_cover =
      0.05f;  ///< share of its pixels that the Gaussians of a mask cover; what shows less is empty space
  RenderOptions render;
};

/// Views that are not held out, in an order that does not depend on how they were given: by the cameras' names.
std::vector<size_t> used_views(const std::vector<int>& held_out, const std::vector<Camera>& cameras,
                               const MaskSet& masks);

/// Index of the mask of every pixel, in the order of the masks' first pixels; -1 = unlabelled.  `id` gets their ids.
std::vector<int> masks_of_pixels(const IdImage& ids, std::vector<uint32_t>& id);

ViewFootprints footprints(const FootprintOptions& options, const GaussianCloud& cloud, const Camera& camera,
                          const MaskSet::View& view);
/// The same from the view's blend weights on `gaussians` Gaussians.
ViewFootprints footprints(const FootprintOptions& options, const BlendWeights& weights, size_t gaussians,
                          const MaskSet::View& view);

/// How the masks of all views lie upon each other.  Masks are numbered through: first[v] + index in view v.
struct MaskRelations {
  static constexpr int kUnseen = -1;   ///< too little of the mask is labelled in that view
  static constexpr int kDivided = -2;  ///< no mask of that view holds it

  std::vector<int> first;  ///< [views + 1]
  std::vector<int>
      container;             ///< [masks, views] mask that holds `contained` of what both views see, or one of the above
  std::vector<int> nearest;  ///< [masks, views] mask of the largest weighted Jaccard index, or kUnseen

  int views() const { return static_cast<int>(first.size()) - 1; }
  int masks() const { return first.back(); }
  int container_of(int mask, int view) const { return container[static_cast<size_t>(mask) * views() + view]; }
  int nearest_of(int mask, int view) const { return nearest[static_cast<size_t>(mask) * views() + view]; }
};

struct RelationOptions {
  float observed = 0.2f;    ///< share of a footprint that another view must show under labels
  float contained = 0.8f;   ///< share of it that lies in one mask there
  double most_steps = 4e9;  ///< of comparisons; beyond it a sample of the Gaussians is compared
};

/// Compares every view with every other.  What two views have in common of a Gaussian is the smaller of its two masses:
/// I_ij = sum over Gaussians of masks i and j of min(mass_u, mass_v); Jaccard = I_ij / (I_i. + I_.j - I_ij).
/// Every pair of views has an owner, so the result does not depend on threads, nor, up to numbering, on their order.
MaskRelations relate(const RelationOptions& options, std::span<const ViewFootprints> views);

/// Share of (mask, other view) whose nearest mask there has the same id: near 1 when ids hold across views, near the
/// share of equal ids by chance otherwise; 1 when no two views see the same.
double id_consistency(const MaskRelations& relations, std::span<const ViewFootprints> views);

}  // namespace pliant

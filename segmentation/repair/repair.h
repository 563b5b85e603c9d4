#pragma once

#include <functional>
#include <string>

#include "segmentation/model_interfaces/inpainter.h"
#include "segmentation/repair/exemplar.h"
#include "segmentation/repair/hole.h"
#include "segmentation/repair/refine.h"
#include "segmentation/repair/shadow.h"

namespace pliant {

/// Filling of the hole that an extracted object leaves.
struct RepairOptions {
  RenderOptions render;  ///< as the scene is drawn, but before black, which is taken off what shines through
  HoleOptions hole;
  int longest_side = 800;  ///< px; larger views are scaled down, all lengths in pixels are of such views
  int max_views = 24;      ///< evenly chosen cameras that show the object and are looked at, whatever their order
  int ring = 14;           ///< width [pixels] of a hole's surroundings from which surfaces are taken
  int max_planes = 4;
  int max_view_patches = 6;  ///< views that may be filled one by one after the planes
  size_t min_pixels = 12;    ///< holes smaller than this are left to the rasteriser's soft edges
  ExemplarOptions exemplar;
  ShadowOptions shadow;
  RefineOptions refine;
  bool repair_shadow = true;  ///< false: a contact shadow is reported, not lifted
};

struct RepairSummary {
  std::vector<int> views;                       ///< cameras that were looked at
  bool object_seen = false;                     ///< in one of these views
  std::vector<size_t> hole_before, hole_after;  ///< pixels per view
  size_t planes = 0, plane_gaussians = 0, view_gaussians = 0;
  size_t inpainted_views = 0;  ///< that went through the inpainter
  RefineSummary refinement;
  size_t unobserved = 0;  ///< background Gaussians that no camera saw while the object was there
  float outside_change =
      0;  ///< largest mean colour change of a view outside its hole (3 pixels grown), the shadow aside
  Shadow::Verdict shadow = Shadow::Verdict::kNone;
  std::string shadow_doubt;  ///< why a darker surrounding was left
  bool shadow_lifted = false;
  float shadow_darkest = 1;     ///< light left beside the footprint
  size_t shadow_gaussians = 0;  ///< whose colour changed
  double seconds = 0;
  size_t before() const;
  size_t after() const;
  std::string describe() const;         ///< one sentence
  std::string describe_shadow() const;  ///< one sentence; empty when there is none
};

struct RepairResult {
  /// The given background without `replaced`, untouched but for colours in a lifted shadow, then the new Gaussians.
  GaussianCloud background;
  std::vector<int> replaced;  ///< Gaussians of the given background that nobody had observed and only the hole shows
  size_t first_new = 0;
  RepairSummary summary;
};

/// Fills the hole (design: pixels whose accumulated opacity falls below 0.9 after removal or whose front was never
/// observed, where the object was seen).  Never observed Gaussians that only the hole shows are taken out, and a plain
/// contact shadow on the plane under the object is taken off the colours there; all others stay bit for bit as they
/// are. Surfaces around the hole are continued as planes with their own texture, what is left is filled view by view,
/// largest hole first.  With an inpainter, the view with the largest hole is filled by it and carried to the others on
/// the planes (or at the depth of the surroundings), then what is still open in the view with most of it, and so on.
/// Last, the new Gaussians are refined against the filled views.  `progress` is called on the same thread; it may
/// throw.
RepairResult repair(const RepairOptions& options, const GaussianCloud& background, const GaussianCloud& removed,
                    const std::vector<Camera>& cameras, const std::function<void(double done)>& progress = {},
                    Inpainter* inpainter = nullptr);

/// Before/after sheet: for up to four views with the largest holes, with the object, without it, repaired; no larger
/// than the views that a repair looks at.
ImageF repair_sheet(const RepairResult& result, const GaussianCloud& background, const GaussianCloud& removed,
                    const std::vector<Camera>& cameras, const RenderOptions& render_options = {});

}  // namespace pliant

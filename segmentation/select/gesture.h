#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "segmentation/graph/gaussian_graph.h"
#include "segmentation/select/gesture_prompts.h"
#include "segmentation/select/grab_cut.h"
#include "segmentation/select/prepared_scene.h"
#include "segmentation/select/selection.h"
#include "segmentation/select/window_view.h"

namespace pliant {

struct GestureOptions {
  RenderOptions render;
  uint64_t seed = 1;
  // Pictures: the box and half a box on each side.
  float margin = 0.5f;  ///< of the box, on each side
  GrabCutOptions picture = {.color = {.ridge = 6e-3f}, .data = 0.5f, .levels = {}};
  int window = 320;  ///< px, longer side of the box with its margin: pictures are cut as if they were drawn so large
  // From pictures to Gaussians.
  float evidence = 3;   ///< log odds of a Gaussian that only pixels of the object show
  float confident = 1;  ///< px of blend weight from which on evidence counts fully
  GraphCutOptions cut = {.smoothness = 6, .color = 0.7f, .model = {}};
  float link =
      0.02f;  ///< edges above this connect parts; by nearness alone before planes that part a thing from the rest
  bool attach = true;  ///< parts of other colours that lie against the object belong to it
  // Refinement: masks of more views, started from the selection so far.
  int refine_rounds = 2, refine_views = 12, refine_window = 320, refine_band = 6;
  GrabCutOptions refine_picture = {.color = {.most_samples = 2000}, .data = 0.3f, .iterations = 3, .levels = {}};
  float refine_prior = 2;  ///< log odds in a picture of what the selection so far says
  GraphCutOptions refine_cut = {.smoothness = 2, .color = 0.5f, .rounds = 2, .model = {}};
  float support = 3;  ///< log odds against what lies in or below the plane the object stands on
  float unseen_prior =
      0.3f;                ///< share of refine_prior that holds for Gaussians on which the boxes' pictures say nothing
  float stroke_reach = 2;  ///< path in the graph over which a stroke outweighs the pictures; 0 = only what it covers
  bool apart_from_planes = true;  ///< what hangs together, does so apart from the planes behind it
  float enclosed = 0.005f;   ///< parts in the boxes that touch nothing but the object come back when they hold this
                             ///< share of its opacity; 1 = never
  bool one_by_one = true;    ///< beside boxes, a background stroke only takes away and a foreground one only adds
  Vec3f up = Vec3f::Zero();  ///< unit, of the scene; zero = unknown, no plane is looked for
};

/// Which rule took a Gaussian out of the selection.
enum class SelectionRule : uint8_t {
  kKept,
  kOutside,  ///< outside a box's frustum or the shape
  kCut,      ///< the cut of the graph from the given views
  kPart,     ///< not connected with the largest part
  kRefined   ///< the refinement over more views
};

struct GestureResult {
  std::vector<float> probability;   ///< [N] of being the object's; > 0.5 = selected
  std::vector<SelectionRule> rule;  ///< [N]
  struct Summary {
    size_t selected = 0, outside = 0, cut = 0, part = 0, refined = 0, added = 0;  ///< Gaussians; added: by refinement
    size_t enclosed = 0;            ///< Gaussians that came back, see GestureOptions::enclosed
    size_t seeds = 0;               ///< Gaussians fixed by strokes and clicks
    std::vector<int> refine_views;  ///< cameras
    double seconds = 0;
    std::vector<std::string> warnings;
    std::string describe() const;
  } summary;

  bool selected(size_t p) const { return probability[p] > 0.5f; }
};

/// What a gesture selected with its first strokes, so that the next question goes on from there.  One is for questions
/// about the same scene, with the same options and shape.
struct GestureSteps {
  struct Step {
    GestureResult result;   ///< not grown
    std::vector<int> part;  ///< see Selector::part
  };
  size_t most = 32;  ///< steps that are kept: 5 bytes per Gaussian each
  Gesture gesture = {};
  std::map<size_t, Step> steps = {};  ///< by the number of strokes
};

/// Object behind boxes, clicks and strokes.  1. GrabCut in every box's window. 2. Masks become evidence on Gaussians
/// through the blend weights; what lies outside a box's frustum (or outside `shape`) is background.  3. A minimum cut
/// of the graph of Gaussians, largest part.  4. Masks of more of the scene's views, started from what is selected, and
/// a second cut.  What strokes and clicks cover is fixed in pictures and in the graph, and they outweigh the pictures
/// nearby along the graph.  Where the rectangle around what step 3 leaves fits the boxes badly, what hangs together
/// with it takes its place if that fits them better (people draw boxes that a thing fills: Lempitsky et al. 2009).
/// 5. What lies in the boxes and touches nothing but the object is the object's, whatever its colour.  Without a box,
/// what hangs together with what was clicked, apart from the planes behind it, is the proposal; without such planes the
/// parts of the graph nearest to it.  Equal for any number of threads, and whatever is in `steps`: with it, only
/// strokes that are new cost time.  Throws Error{kUsage} when nothing is selected.
GestureResult select_by_gesture(const GestureOptions& options, const Gesture& gesture,
                                const std::optional<SelectionShape>& shape, const GaussianCloud& cloud,
                                const std::vector<Camera>& cameras, const PreparedScene& prepared,
                                GestureSteps* steps = nullptr);

/// What a click would select, about, in a fraction of the time: the superpoints that hang together with it [N].
std::vector<uint8_t> guess_by_click(const GestureOptions& options, const StrokePrompt& click,
                                    const GaussianCloud& cloud, const std::vector<Camera>& cameras,
                                    const PreparedScene& prepared);

}  // namespace pliant

#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/run/options.h"
#include "app/run/run_directory.h"
#include "app/segment/label_photos.h"
#include "gaussians/io/scene/scene.h"

namespace pliant {

/// segment: masks or a selection -> semantic attribute -> segmentation.h5, objects.json, objects.png; with gestures
/// also selection.png.
struct SegmentStage {
  std::string masks;       ///< folder; empty = the scene file's
  bool automatic = false;  ///< find free-standing objects from the Gaussians alone; masks are not read
  LabelStage label;        ///< masks made from the photos
  std::string associate =
      "auto";  ///< ids of the masks: auto (grouped anew when they do not agree between views), always, never
  std::vector<double> aabb, sphere;  ///< a selection instead of masks: x0,y0,z0,x1,y1,z1 or x,y,z,r (scene units)
  std::vector<std::string> boxes, clicks, strokes;  ///< gestures, see segmentation/lift/gesture_prompts.h
  double stroke_width = 8;                          ///< of strokes and clicks, px
  bool start_from_vote = true;
  std::optional<int> iterations;  ///< of the optimisation; 0 = vote only
  std::string physgaussian;       ///< file; the object is what this configuration of PhysGaussian simulates
  bool hold_out = false;          ///< leave every 8th photo out of the optimisation; held_out/ gets its id picture
  bool joint = false;             ///< the scene and its attribute were trained together: take that
  std::string gaussian_grouping;  ///< folder with the classifier of a Gaussian Grouping model, whose attribute is taken
  bool zero_is_background = false;  ///< id 0 of masks or of that classifier is an object like others, the background
};
/// Its options, bound to the fields of `stage`.
OptionTable options_of(SegmentStage& stage);
nlohmann::json run_segment(const Context& context, RunDirectory& run, const Scene& scene, const SegmentStage& stage);

}  // namespace pliant

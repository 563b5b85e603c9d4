#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/run/options.h"
#include "app/run/stage_inputs.h"
#include "app/segment/label_photos.h"
#include "gaussians/io/scene/scene.h"
#include "segmentation/select/gesture_prompts.h"

namespace pliant {

/// segment: masks or a selection -> semantic attribute -> segmentation.h5, objects.json, objects.png; with gestures
/// also selection.png.
struct SegmentStage {
  std::string masks;       ///< folder; empty = the scene file's
  bool automatic = false;  ///< find free-standing objects from the Gaussians alone; masks are not read
  LabelStage label;        ///< masks made from the photos
  std::string associate =
      "auto";  ///< ids of the masks: auto (grouped anew when they do not agree between views), always, never, gaga
  std::vector<double> aabb, sphere;  ///< a selection instead of masks: x0,y0,z0,x1,y1,z1 or x,y,z,r (scene units)
  std::vector<std::string> boxes, clicks, strokes;  ///< gestures, see segmentation/select/gesture_prompts.h
  double stroke_width = 8;                          ///< of strokes and clicks, px
  int grow = 0;                                     ///< see Gesture
  bool start_from_vote = true;
  std::optional<int> iterations;  ///< of the optimisation; 0 = vote only
  std::string physgaussian;       ///< file; the object is what this configuration of PhysGaussian simulates
  bool hold_out = false;          ///< leave every 8th photo out of the optimisation; held_out/ gets its id picture
  bool joint = false;             ///< the scene and its attribute were trained together: take that
  std::string gaussian_grouping;  ///< folder with the classifier of a Gaussian Grouping model, whose attribute is taken
  std::string mask_zero;          ///< what id 0 of masks is: background, an object like others; empty = unlabelled
};
/// Its options, bound to the fields of `stage`.
OptionTable options_of(SegmentStage& stage);
/// Cameras that --hold-out leaves out: every 8th in the order of names, as PhotoOptions::hold_out_every counts.
std::vector<int> held_out_cameras(const std::vector<Camera>& cameras);
/// `stage` without gestures on sheets (sheet_prompts.h), the photos labelled.
StageInputs<SegmentStage> inputs_of(const RunDirectory& run, const Scene& scene, const SegmentStage& stage,
                                    const std::vector<Camera>& sides = {});
/// The boxes, clicks and strokes of `stage`.
Gesture gesture_of(const SegmentStage& stage, const std::vector<Camera>& cameras);
nlohmann::json run_segment(const Context& context, RunDirectory& run, const Scene& scene, const SegmentStage& stage);

}  // namespace pliant

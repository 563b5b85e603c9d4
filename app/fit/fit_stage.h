#pragma once

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "app/run/options.h"
#include "app/run/stage_inputs.h"
#include "app/simulate/object_material.h"
#include "gaussians/io/scene/scene.h"

namespace pliant {

/// Markers on the object that were measured after it was let go from rest, instead of a video.
struct MarkerStage {
  std::string file;               ///< table, see fitting/observe/markers.h
  std::string axes = "x,y,z";     ///< columns along the scene's x, y and z, each with a sign if need be: "y,-x,z"
  std::string units = "metres";   ///< of the columns without a unit of their own: metres, or scene units
  std::vector<double> offset;     ///< [3] of the scene's frame, in those units; added to the markers; empty = none
  double reach = 0;               ///< m; farther from the material a marker is not on the object; 0 = two cells
  std::optional<double> rest;     ///< s of the recording, from which on the object is at rest; default: its begin
  std::optional<double> release;  ///< s of the recording; default: where motion sets in
  double window = 1;              ///< s after the release that the fit sees; as much again judges it
  std::string interactions;       ///< file; what acts from the release on; empty = gravity
};

/// An image-to-video model that makes the video, see fitting/observe/generate_video.h.
struct GenerateStage {
  std::string command;  ///< empty = none
  std::string prompt;
  int frames = 14;
};

/// What gradients through the simulation compare beside, or instead of, the points that are followed.
struct CompareStage {
  std::string loss;     ///< tracks, image, both; empty = the recipe's
  double lambda = 0.1;  ///< share of L1 in the loss of pictures; the rest is D-SSIM
  /// That this loss counts against the tracks' mean squared error in px; default: the recipe's.
  std::optional<double> picture_weight;
  double flow_weight =
      0;  ///< that the flow's mean squared error [px a frame] counts against it; 0 = flow is not compared
  std::optional<int> window;      ///< frames through which the gradient of E runs back; 0 = all; default: the recipe's
  std::optional<int> iterations;  ///< default: the recipe's
  bool poisson = false;           ///< Poisson's ratio is fitted too
  bool density = false;           ///< the density too
  std::string guide;         ///< a program that judges the drawn motion, see fitting/observe/guidance.h; empty = none
  double guide_weight = 1;   ///< of its loss
  double guide_limit = 300;  ///< s that it may take for a step; twice that until it is ready
  std::optional<int> guide_frames;  ///< without a video, that a clip for it has; default: the recipe's
  std::string load;                 ///< file, without a video: what acts; empty = one push sized to the stiffness
};

/// Instead of a camera's name: it is found by the video's first frame.
constexpr const char* kFindCamera = "find";

/// fit: a video of the moving object, or markers on it -> material.h5, velocity.h5, fit/.
struct FitStage {
  MarkerStage markers;               ///< no file: a video
  std::vector<std::string> videos;   ///< files or folders of the same motion, which begin at the same instant; none =
                                     ///< the scene file's
  std::vector<std::string> cameras;  ///< that took them, in their order, or kFindCamera; none = the scene file's
  std::vector<std::string> masks;    ///< pictures, or folders or videos of as many frames, in their order: pixels that
                                     ///< are dark there are not compared; "none": all are
  std::string pose;                  ///< file of cameras, one of which took the first, instead of a camera of the scene
  bool refine_camera = false;        ///< until the scene looks like the first frame
  GenerateStage generate;            ///< a program that makes the video instead
  CompareStage compare;
  bool beside = false;                   ///< that of a further video, of which the scene file tells nothing
  double first = 0, last = 0;            ///< s of the file, the part that is used; last 0 = to its end
  std::optional<double> released_young;  ///< Pa in PhysDreamer's cube, E0 of the fields in its scene folder, which are
                                         ///< taken instead of a fit
  double fps = 0;          ///< of a folder of frames, or against the file's; 0 = the scene file's, else the file's own
  double compare_fps = 0;  ///< frames a second that are compared, of all videos; 0 = the first one's own
  double from = -1;        ///< s of the file, from which on nothing pushes the object; negative = found
  double until = 0;        ///< s of the file; later frames only judge the fit; 0 = all are used
  std::string periods = "3.5";    ///< of the strongest mode that simulated motions are compared over, or "all"
  int points = 400;               ///< of the object's surface that are followed
  std::string field;              ///< E(x): uniform, parts, smooth, triplanes, kan; empty = the recipe's
  std::string recipe = "search";  ///< search: over stiffness, then Gauss-Newton; physdreamer: gradients alone, v0 first
                                  ///< (fit_physdreamer.h); physdreamer-code: as its released programs do it;
                                  ///< physics3d, dreamphysics: constants that a guide asks for (fit_distilled.h);
                                  ///< dreamgaussian4d: no physics, a motion alone (fit_deformation.h)
  int parts = 6;                  ///< patches of the object by place and colour; those that look alike are one part
  std::string part_labels;        ///< file with labels of the scene's Gaussians, that say the parts instead
  MaterialValues material;        ///< command line's; E is where the search starts
  std::string initial_material;   ///< file with E(x), nu(x) and rho(x) to start from instead, or kPredictedMaterial
  std::string solver = "auto";    ///< that of the roll-outs, see SimulateStage
  std::string prefix;             ///< of its options on the command line: "fit." in `run`
  bool physdreamer() const { return recipe.starts_with("physdreamer"); }
  bool distilled() const { return recipe == "physics3d" || recipe == "dreamphysics"; }
  bool kinematic() const { return recipe == "dreamgaussian4d"; }
  bool released_code() const { return recipe == "physdreamer-code"; }
  /// An option as the user writes it.
  std::string typed(const std::string& option) const;
  // Of the first video; empty where it is not told.
  std::string video() const { return videos.empty() ? "" : videos[0]; }
  std::string camera() const { return cameras.empty() ? "" : cameras[0]; }
  std::string video_mask() const { return masks.empty() ? "" : masks[0]; }
  size_t further_videos() const { return std::max({size_t{1}, videos.size(), cameras.size(), masks.size()}) - 1; }
};
/// Its options, bound to the fields of `stage`.
OptionTable options_of(FitStage& stage);
/// With what its recipe sets where nothing is said: fields and windows as PhysDreamer publishes them, an image loss
/// that its total variation counts against as there; else the tracked points, by one stiffness.
FitStage with_recipe(FitStage stage);
/// FitStage::periods as a number, infinite for "all"; throws Error{kUsage} for anything else.
double fitted_periods(const FitStage& stage);
/// Throws Error{kUsage} for what a fit of this kind would leave unused, by the name of its option.
void check_fit_stage(const FitStage& stage, bool with_video);
/// The same for any choice at all, when nothing is fitted: `where` says why ("with --no-video").
void check_no_fit_stage(const FitStage& stage, const std::string& where, const std::string& advice);
/// Throws Error{kInput} where this fit needs libtorch, which is loaded here and is not there.
void require_networks(const FitStage& stage);

/// Instead of a file: the material that `predict` found.
constexpr const char* kPredictedMaterial = "predicted";

/// What the material is fitted to.
enum class FitKind { kVideo, kMarkers, kReleased, kGuided, kKinematic };
FitKind kind_of(const FitStage& stage, const Scene& scene);
using FitInputs = StageInputs<FitStage>;
FitInputs inputs_of(const RunDirectory& run, const Scene& scene, const FitStage& stage);
nlohmann::json run_fit(const Context& context, RunDirectory& run, const Scene& scene, const FitStage& stage);

// The kinds.  `provenance` goes into the files that they write.
nlohmann::json fit_to_video(const Context& context, const RunDirectory& run, const FitInputs& in,
                            const std::string& provenance);
/// Without a video: E(x) and damping under given forces, by what stage.compare.guide thinks of the drawn motion
/// (PhysDreamer's setting turned round), or constants as Physics3D and DreamPhysics let a video model choose them.
nlohmann::json fit_to_guide(const Context& context, const RunDirectory& run, const FitInputs& in,
                            const std::string& provenance);
nlohmann::json fit_to_markers(const Context& context, const RunDirectory& run, const FitInputs& in,
                              const std::string& provenance);
/// A motion of the driving particles that looks like the video, into fit/trajectory.h5 (DreamGaussian4D, Ren et al.
/// 2023).
nlohmann::json fit_without_physics(const Context& context, const RunDirectory& run, const FitInputs& in,
                                   const std::string& provenance);
/// With stage.released_young: E = E0 + 1000 f(x), v0 = 0.1 g(x) of sim_fields.pt and velo_fields.pt, in SI units.
nlohmann::json take_released_fields(const Context& context, const RunDirectory& run, const FitInputs& in,
                                    const std::string& provenance);

}  // namespace pliant

#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/pipeline/label_photos.h"
#include "app/pipeline/material.h"
#include "app/pipeline/run_directory.h"
#include "gaussians/io/scene.h"
#include "gaussians/reconstruct/train_options.h"
#include "gaussians/reconstruct/training_photos.h"

namespace pliant {

/// Loads the scene that a run directory was made from.
Scene load_run_scene(const RunDirectory& run);
/// Records `source` in the run directory and loads it.
Scene attach_scene(const Context& context, RunDirectory& run, const std::filesystem::path& source,
                   const LoadOptions& options);

/// reconstruct: photos with cameras -> a scene that every other stage takes: point_cloud/iteration_N/point_cloud.ply,
/// cameras.json, transforms.json, photos/ (those that were undistorted or scaled), scene.json, results.json,
/// preview.png.
struct ReconstructStage {
  std::string photos;  ///< folder of the photos, when they are not beside the cameras
  TrainOptions train;  ///< train.render.background is also what photos with alpha are put on
  PhotoOptions photo;
  std::string start = "auto";  ///< auto, points, triangulate, random; see training_start.h
  std::string poses =
      "auto";                ///< a reading of the poses, see check_poses.h; auto: as given, unless another fits better
  int checkpoint_every = 0;  ///< iterations; 0 = about every minute
  bool joint = false;        ///< train the semantic attribute along with the scene -> segmentation.h5
  std::string masks;         ///< folder, of joint training; empty = the scene file's
  std::string splats;        ///< file, of joint training: start from this trained scene
};
nlohmann::json run_reconstruct(const Context& context, RunDirectory& run, const std::filesystem::path& source,
                               const ReconstructStage& stage);

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
nlohmann::json run_segment(const Context& context, RunDirectory& run, const Scene& scene, const SegmentStage& stage);

/// extract: one object -> objects/<id>_<name>/object.ply, background.ply.
struct ExtractStage {
  std::string object;  ///< id or name; empty = the scene file's, else the only one
  double threshold = 0.5;
  bool hull = false;  ///< what lies in the convex hull of the object belongs to it
};
nlohmann::json run_extract(const Context& context, RunDirectory& run, const Scene& scene, const ExtractStage& stage);

/// repair: the hole that the object left -> background_repaired.ply, repair.png.
struct RepairStage {
  std::string shadow = "repair";  ///< of the object on its support, where it is plain: repair or keep
  ModelChoice models;             ///< of which the inpainter fills holes
};
nlohmann::json run_repair(const Context& context, RunDirectory& run, const Scene& scene, const RepairStage& stage);

/// seed: solid samples and driving particles -> objects/.../particles.h5.
struct SeedStage {
  int particles = 8000;
  std::string drivers = "kmeans";  ///< how they are placed: kmeans, or pgas (denser where E is small)
  std::string material_file;  ///< material.h5 of any particles, whose nearest sample says what E is to pgas; empty =
                              ///< the same everywhere
  std::string physgaussian;   ///< file; a configuration of PhysGaussian whose cells the particles fill
  std::optional<double> pin_below;  ///< height along up, scene units
  bool pin_contact = true;          ///< pin where the object touches its support
};
nlohmann::json run_seed(const Context& context, RunDirectory& run, const Scene& scene, const SeedStage& stage);

/// Whether this run has been fitted.
bool is_fitted(const RunDirectory& run);

constexpr double kDampingTime = 1;  ///< s

/// simulate: material and interactions -> material.h5, interactions.json, trajectory.h5.
struct SimulateStage {
  std::string interactions;   ///< file; empty = one push sized to the stiffness
  std::string physgaussian;   ///< file; a configuration of PhysGaussian instead of material, interactions, fps, ...
  std::string compat;         ///< "physgaussian": its known defects are repeated
  MaterialValues material;    ///< command line's
  std::string material_file;  ///< material.h5 of any particles, whose nearest sample counts; instead of a fit's
  std::string velocity_file;  ///< velocity.h5 of any particles: how the motion starts; instead of a fit's
  double fps = 30, duration = 4;
  std::optional<double> damping_time;  ///< amplitude of motion decays as exp(-t / damping_time) [s]; 0 = none; default:
                                       ///< the fit's, else kDampingTime
  double push = 0.15;                  ///< peak deflection of the automatic push, share of the object's height
  bool gravity = true;
  std::string rest_shape = "captured";  ///< of a pinned body: captured (free of stress) or solve (loaded by gravity)
  double settle = 2;       ///< s, at most, that an unpinned body gets to come to rest before frame 0; 0 = none
  double sleep_speed = 0;  ///< m/s below which parts at rest are not computed; 0 = all are
  double flip_time = 0;    ///< s in which particles lose what the grid cannot hold of their motion; 0 = at once (APIC)
  bool obstacles = false;  ///< the rest of the scene's Gaussians are an obstacle
  bool use_fit = true;     ///< material, damping and start of a fit, where there is one and `material` names no E
  bool floor = true;       ///< the plane of the support is a floor, unless the interactions have a ground
};
/// The material that simulate will use, see material.h; with a configuration of PhysGaussian its own.
ObjectMaterial check_material(const Scene& scene, const SimulateStage& stage);
nlohmann::json run_simulate(const Context& context, RunDirectory& run, const Scene& scene, const SimulateStage& stage);

/// render: clip.mp4 from a fixed camera, clip_orbit.mp4 from a moving one.
struct RenderStage {
  std::string camera;  ///< name of the fixed camera; empty = the video's, else one that sees the object well
  bool orbit = true;
  bool frames = false;  ///< also clip/000000.png ..., which lose nothing
};
nlohmann::json run_render(const Context& context, RunDirectory& run, const Scene& scene, const RenderStage& stage);

/// export: numbered splat files of the moving scene, outside of the run directory.
struct ExportStage {
  std::string ply_sequence;         ///< folder; sequence.json there says what the files are
  std::string physgaussian_output;  ///< folder for simulation_ply/sim_*.h5 and .ply
  int every = 1;                    ///< take every Nth frame of the trajectory
  bool object_only = false;         ///< without the background
};
nlohmann::json run_export(const Context& context, RunDirectory& run, const Scene& scene, const ExportStage& stage);

/// report: report.html, self-contained.
void write_report(const RunDirectory& run, const Scene& scene, const std::string& command);

/// Folder of the extracted object, relative to the run directory.
std::string object_folder(const RunDirectory& run);

}  // namespace pliant

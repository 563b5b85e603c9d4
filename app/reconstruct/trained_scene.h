#pragma once

#include "app/reconstruct/reconstruct_stage.h"
#include "app/run/run_directory.h"
#include "gaussians/reconstruct/training_photos.h"

namespace pliant {

/// A trained scene and what it was trained on.
struct TrainedScene {
  const PhotoSet& set;
  const CameraFile& cameras;  ///< as read, with their lenses
  const TrainingPhotos& photos;
  const GaussianCloud& cloud;
  int iteration = 0;
  bool antialiased = false;
  bool z_is_up = false;                  ///< the splats that the training went on from say so
  std::optional<Vec3d> background = {};  ///< color behind it, where someone said one
};

/// Writes a scene folder in the layout of 3DGS: point_cloud/iteration_N/point_cloud.ply, cameras.json, and for exact
/// cameras transforms.json; photos/ and masks/ hold those that the training changed, and
/// mask_names.json the names of such masks where no labels of the source tell them; lenses.json has the lenses that
/// were removed from photos.  scene.json comes last; what it says besides is update_scene_file's.  What an earlier
/// training wrote there, or began to write, is removed; what lies in its place and is not of one, or was changed since,
/// is moved aside.
/// Returns sentences about what could not be kept.
std::vector<std::string> write_trained_scene(RunDirectory& run, const TrainedScene& scene);

/// Throws Error{kUsage} where the directory is that of another command, whose results a scene would replace.
void refuse_other_run(const RunDirectory& run);

/// Throws an Error where the scene.json of an earlier training, which a new one keeps, cannot be read any more.
void check_own_scene(const RunDirectory& run);

/// Throws Error{kUsage} where a scene in `folder` would replace what it is to be trained on.
void refuse_own_source(const std::filesystem::path& folder, const PhotoSet& set, const ReconstructStage& stage);

/// scene.json of a trained scene says what the source's says now, besides what the training made.  Keys for which that
/// has not changed since stay as the user left them.  Photos and masks that the training did not change are named,
/// there and in transforms.json, where the source (`cameras`, as read) has them now.
void update_scene_file(RunDirectory& run, const PhotoSet& set, const CameraFile& cameras);

}  // namespace pliant

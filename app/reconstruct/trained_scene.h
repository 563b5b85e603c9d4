#pragma once

#include "app/reconstruct/reconstruct_stage.h"
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
};

/// Writes a scene folder in the layout of 3DGS: point_cloud/iteration_N/point_cloud.ply, cameras.json, and for exact
/// cameras transforms.json; photos/ and masks/ hold those that the training changed, and
/// mask_names.json the names of such masks where no labels of the source tell them.  scene.json comes last; what it
/// says besides is update_scene_file's.  What an earlier training wrote there is removed.  Returns sentences about what
/// could not be kept.
std::vector<std::string> write_trained_scene(const std::filesystem::path& folder, const TrainedScene& scene);

/// Throws Error{kUsage} where a scene in `folder` would replace what it is to be trained on.
void refuse_own_source(const std::filesystem::path& folder, const PhotoSet& set, const ReconstructStage& stage);

/// scene.json of a trained scene says what the source's says now, besides what the training made.
void update_scene_file(const std::filesystem::path& folder, const PhotoSet& set);

}  // namespace pliant

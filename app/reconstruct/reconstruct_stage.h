#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "app/reconstruct/photo_set.h"
#include "app/run/options.h"
#include "app/run/stage_inputs.h"
#include "gaussians/reconstruct/train_options.h"
#include "gaussians/reconstruct/training_photos.h"

namespace pliant {

/// reconstruct: photos with cameras -> a scene that every other stage takes: point_cloud/iteration_N/point_cloud.ply,
/// cameras.json, transforms.json, photos/ (those that were undistorted or scaled), scene.json, results.json,
/// preview.png.
struct ReconstructStage {
  std::string photos;  ///< folder of the photos, when they are not beside the cameras
  TrainOptions train;
  std::string strategy = "mcmc";   ///< how Gaussians are added and removed: mcmc, classic, none
  std::vector<double> background;  ///< [3] in 0..1, behind the scene and behind photos with alpha; empty = the scene
                                   ///< file's, else black, and behind such photos another each time
  PhotoOptions photo;
  std::string start = "auto";  ///< auto, points, triangulate, random; see training_start.h
  std::string poses =
      "auto";                ///< a reading of the poses, see check_poses.h; auto: as given, unless another fits better
  int checkpoint_every = 0;  ///< iterations; 0 = about every minute
  bool joint = false;        ///< train the semantic attribute along with the scene -> segmentation.h5
  std::string masks;         ///< folder, of joint training; empty = the scene file's
  std::string mask_zero;     ///< what id 0 of these is: background, an object like others; empty = unlabelled
  std::vector<std::filesystem::path> splats;  ///< of joint training: start from the trained scene of these files, of
                                              ///< which the first refers to the others (ReadReport::files)
  std::optional<int> level;                   ///< of it that is read, of a streamed SOG
};
/// Its options, bound to the fields of `stage`.
OptionTable options_of(ReconstructStage& stage);
StageInputs<ReconstructStage> inputs_of(const PhotoSet& set, const CameraFile& cameras, const ReconstructStage& stage);
nlohmann::json run_reconstruct(const Context& context, RunDirectory& run, const std::filesystem::path& source,
                               const ReconstructStage& stage);

}  // namespace pliant

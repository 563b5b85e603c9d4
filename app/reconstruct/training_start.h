#pragma once

#include <nlohmann/json.hpp>

#include "app/reconstruct/reconstruct_stage.h"
#include "gaussians/io/cameras/sparse_points.h"

namespace pliant {

/// The Gaussians that a training begins with, and how they came about.
struct TrainingStart {
  GaussianCloud cloud;
  nlohmann::json description;  ///< {kind, points, sentence}
  std::vector<std::string> warnings = {};
  bool z_is_up = false;  ///< the file of a trained scene says that +z points up
};

/// Fewer points are no start: random Gaussians are a better one.
constexpr size_t kFewestStartPoints = 100;

/// As stage.start says: `points` of structure from motion, points triangulated from the photos, random ones, or (auto)
/// the first of these that are enough.  A kind that was asked for and is not to be had is a usage error.  Photos that
/// see hardly any of the triangulated points are warned about.
TrainingStart start_training(const Context& context, const ReconstructStage& stage, SparsePoints points,
                             const TrainingPhotos& photos);

/// The trained scene stage.splats, to go on from in small steps and with its Gaussians alone; `options` become so, and
/// antialiased where `settings` or the file say it.  Throws Error{kUsage} where options.sh_degree is below the splats'.
TrainingStart start_from_splats(const ReconstructStage& stage, const SceneFile& settings, TrainOptions& options);

}  // namespace pliant

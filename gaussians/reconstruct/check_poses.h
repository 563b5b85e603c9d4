#pragma once

#include <optional>
#include <string>
#include <vector>

#include "gaussians/io/cameras/camera_file.h"
#include "gaussians/io/cameras/sparse_points.h"
#include "gaussians/reconstruct/training_photos.h"

namespace pliant {

/// How a file of cameras may have been meant.
enum class PoseConvention {
  kAsGiven,         ///< as the format says
  kInverse,         ///< the inverse matrices are stored: camera to world where world to camera is due, or the reverse
  kFlipped,         ///< the camera's y and z axes point the other way: OpenGL where OpenCV is due, or the reverse
  kInverseFlipped,  ///< both
  kTurned,          ///< the photos lie upside down with regard to their cameras
};
constexpr PoseConvention kPoseConventions[] = {PoseConvention::kAsGiven, PoseConvention::kInverse,
                                               PoseConvention::kFlipped, PoseConvention::kInverseFlipped,
                                               PoseConvention::kTurned};

/// as-given, inverse, flipped, inverse-flipped, turned.
const char* name_of(PoseConvention convention);
std::optional<PoseConvention> pose_convention_named(const std::string& name);

/// The cameras of a file of `format` (CameraFile::format) read in another way.
std::vector<Camera> apply_convention(PoseConvention convention, const std::string& format, std::vector<Camera> cameras);
/// The cameras as given, from what apply_convention made of them.
std::vector<Camera> undo_convention(PoseConvention convention, const std::string& format, std::vector<Camera> cameras);

/// How well one reading agrees with the photos.
struct PoseFit {
  PoseConvention convention = PoseConvention::kAsGiven;
  double error = 0;  ///< px, median; infinite when most of it lies behind the cameras
  double share = 0;  ///< of observations or matches that agree, in [0, 1]
};

/// The readings compared by one kind of evidence.
struct PoseEvidence {
  std::vector<PoseFit> fits;  ///< of every convention, in their order; empty when there is too little evidence
  PoseConvention best = PoseConvention::kAsGiven;  ///< the one that is used, where none fits better
  int checked = 0;                                 ///< observations or matches
};

struct PoseReport {
  PoseEvidence points;   ///< by reprojection of points
  PoseEvidence matches;  ///< by the distance of feature matches from their epipolar lines
  std::string sentence;  ///< for the user
  std::vector<std::string> warnings;
};

struct PoseCheckOptions {
  int seeds = 8;         ///< photos, spread evenly, whose neighbours are matched with them
  int features = 1500;   ///< per photo
  bool refuse = true;    ///< another reading that fits clearly better is an error, else a warning
  double agreement = 3;  ///< px within which a match agrees, for photos of 1000 px, others in proportion
  /// Of --pose-convention: how the cameras have been read with apply_convention; none = as given, by nobody's choice.
  std::optional<PoseConvention> chosen = {};
};

/// Looks whether poses, photos and points belong together.  `points.observations` (may be empty) refer to the cameras
/// of `photos`; features of neighbouring photos are matched besides, because points say nothing about pixels.  Throws
/// Error{kInput} when all cameras are at one point, when coordinates are too large for their spread, and
/// (options.refuse) when another reading than the one that is used fits clearly better, else warns of it; warns when
/// the scene is so small that the renderer's near plane would cut it.
PoseReport check_poses(const PoseCheckOptions& options, const CameraFile& file, const TrainingPhotos& photos,
                       const SparsePoints& points);

}  // namespace pliant

#include "gaussians/reconstruct/check_poses.h"

namespace pliant {

const char* name_of(PoseConvention convention) {
  constexpr const char* kNames[] = {"as-given", "inverse", "flipped", "inverse-flipped", "turned"};
  return kNames[static_cast<int>(convention)];
}

std::optional<PoseConvention> pose_convention_named(const std::string& name) {
  for (const PoseConvention convention : kPoseConventions) {
    if (name == name_of(convention)) return convention;
  }
  return std::nullopt;
}

std::vector<Camera> apply_convention(PoseConvention convention, const std::string& format,
                                     std::vector<Camera> cameras) {
  const Eigen::DiagonalMatrix<double, 3> flip(1, -1, -1), turn(-1, -1, 1);
  const auto turned_by = [](const Eigen::DiagonalMatrix<double, 3>& axes, Eigen::Isometry3d& pose) {
    pose.linear() = (axes * pose.linear()).eval();
    pose.translation() = (axes * pose.translation()).eval();
  };
  const bool inverse = convention == PoseConvention::kInverse || convention == PoseConvention::kInverseFlipped;
  const bool flipped = convention == PoseConvention::kFlipped || convention == PoseConvention::kInverseFlipped;
  // The reader of transforms.json has flipped the axes of what it took for cameras: to have the matrices as they are
  // stored, that is undone first, and done again to what is the camera's side then.
  const bool opengl = format == "transforms.json";
  for (Camera& camera : cameras) {
    Eigen::Isometry3d& pose = camera.cam_from_world;
    if (inverse && opengl) turned_by(flip, pose);
    if (inverse) pose = pose.inverse();
    if (flipped != (inverse && opengl)) turned_by(flip, pose);
    if (convention == PoseConvention::kTurned) {
      turned_by(turn, pose);
      camera.cx = camera.width - camera.cx;
      camera.cy = camera.height - camera.cy;
      camera.distortion[2] *= -1;
      camera.distortion[3] *= -1;
    }
  }
  return cameras;
}

std::vector<Camera> undo_convention(PoseConvention convention, const std::string& format, std::vector<Camera> cameras) {
  // Each is its own inverse but one, whose two steps come in the other order with the other kind of format.
  const bool opengl = (format == "transforms.json") != (convention == PoseConvention::kInverseFlipped);
  return apply_convention(convention, opengl ? "transforms.json" : "", std::move(cameras));
}

}  // namespace pliant

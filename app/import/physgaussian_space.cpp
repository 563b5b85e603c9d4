#include "app/import/physgaussian_space.h"

#include <Eigen/Geometry>
#include <cmath>

#include "gaussians/base/error.h"

namespace pliant {
namespace {

/// All rotations of the configuration, the first applied first.
Mat3d rotation_of(const PhysGaussianConfig& config) {
  Mat3d R = Mat3d::Identity();
  for (size_t k = 0; k < config.rotation_degree.size(); ++k) {
    const double angle = config.rotation_degree[k] * 3.14159265358979324 / 180;
    R = Eigen::AngleAxisd(angle, Vec3d::Unit(config.rotation_axis[k])).toRotationMatrix() * R;
  }
  return R;
}

}  // namespace

std::vector<uint8_t> physgaussian_members(const PhysGaussianConfig& config, const GaussianCloud& cloud) {
  const Mat3d R = rotation_of(config);
  std::vector<uint8_t> member(cloud.size(), 0);
  for (size_t i = 0; i < cloud.size(); ++i) {
    const double opacity = 1 / (1 + std::exp(-static_cast<double>(cloud.opacity_logit[i])));
    if (!(opacity > config.opacity_threshold)) continue;
    const Vec3d x = R * cloud.position[i].cast<double>();
    bool inside = true;
    for (int a = 0; config.sim_area && a < 3; ++a)
      inside &= x[a] > (*config.sim_area)[2 * a] && x[a] < (*config.sim_area)[2 * a + 1];
    member[i] = inside;
  }
  return member;
}

SimulationSpace simulation_space(const PhysGaussianConfig& config, const GaussianCloud& cloud,
                                 const std::vector<uint8_t>& members) {
  CHECK(members.size() == cloud.size());
  SimulationSpace space;
  space.R = rotation_of(config);
  Vec3d low = Vec3d::Constant(INFINITY), high = -low;
  for (size_t i = 0; i < cloud.size(); ++i) {
    if (!members[i]) continue;
    const Vec3d x = space.R * cloud.position[i].cast<double>();
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  const double extent = (high - low).maxCoeff();
  if (!(extent > 0))
    throw usage_error("physgaussian", "sim_area",
                      "leaves no Gaussian above opacity_threshold " + std::to_string(config.opacity_threshold),
                      "sim_area is given after the rotations, in scene units");
  space.scale = config.scale / extent;
  space.offset = Vec3d::Ones() - space.scale * 0.5 * (low + high);
  return space;
}

}  // namespace pliant

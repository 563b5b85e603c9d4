#include "app/simulate/motion.h"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace pliant {

nlohmann::json describe_motion(const TrajectoryFile& trajectory, const ParticleFile& particles, const Vec3d& up,
                               double height, double quiet) {
  const Vec3f axis = up.cast<float>();
  float low = INFINITY, high = -INFINITY;
  for (const Vec3f& x : particles.driving_position) {
    low = std::min(low, axis.dot(x));
    high = std::max(high, axis.dot(x));
  }
  std::vector<size_t> tip;
  for (size_t p = 0; p < particles.driving_position.size(); ++p)
    if (axis.dot(particles.driving_position[p]) >= high - 0.1f * (high - low)) tip.push_back(p);

  double peak = 0, end = 0, before = 0, any = 0;
  for (const TrajectoryFile::Frame& frame : trajectory.frames) {
    Vec3d mean = Vec3d::Zero();
    for (size_t p : tip) mean += (frame.position[p] - particles.driving_position[p]).cast<double>();
    const double moved = mean.norm() / static_cast<double>(tip.size()) / height;
    peak = std::max(peak, moved);
    end = moved;
    if (frame.time <= quiet) before = std::max(before, moved);
    for (size_t p = 0; p < frame.position.size(); ++p)
      any = std::max(any, static_cast<double>((frame.position[p] - particles.driving_position[p]).norm()) / height);
  }
  return {{"tip_peak", peak}, {"tip_end", end}, {"tip_drift_before", before}, {"particle_peak", any}};
}

}  // namespace pliant

#include "app/page/driver_level.h"

#include "gaussians/render/bind.h"
#include "gaussians/render/deform_kernels.h"
#include "physics/body/driving_particles.h"

namespace pliant {

DriverLevel driver_level(const MovingScene& moving, const Scene& scene, int count) {
  const ParticleFile& file = moving.particles;
  if (count >= static_cast<int>(file.driving_position.size())) return {file.driving_position, moving.binding, true};
  SolidSamples samples;
  for (size_t s = 0; s < file.solid_position.size(); ++s) {
    if (file.solid_driver[s] < 0) continue;
    samples.position.push_back(file.solid_position[s]);
    samples.volume.push_back(file.solid_volume[s]);
  }
  DriverOptions options;
  options.count = count;
  DriverLevel level;
  level.rest = kmeans_drivers(options, samples).position;
  ParticleFile fewer = file;
  fewer.driving_position = level.rest;
  level.binding = bind_object(scene, fewer, moving.object);
  return level;
}

std::vector<DriverFrame> motion_of(const MovingScene& moving, const DriverLevel& level) {
  std::vector<DriverFrame> frames;
  if (level.full) {
    for (const TrajectoryFile::Frame& frame : moving.trajectory.frames) frames.push_back({frame.position, frame.F});
    return frames;
  }
  const std::vector<Vec3f>& drivers = moving.particles.driving_position;
  const Binding binding = pliant::bind({}, level.rest, drivers);
  for (const TrajectoryFile::Frame& frame : moving.trajectory.frames) {
    DriverFrame out{level.rest, std::vector<Mat3f>(level.rest.size(), Mat3f::Identity())};
    for (size_t i = 0; i < level.rest.size(); ++i) {
      int count = 0;
      float weight[Binding::kCount];
      Vec3f rest[Binding::kCount], now[Binding::kCount];
      Mat3f F[Binding::kCount];
      for (; count < Binding::kCount; ++count) {
        const int d = binding.driver[i * Binding::kCount + count];
        if (d < 0) break;
        weight[count] = binding.weight[i * Binding::kCount + count];
        rest[count] = drivers[d];
        now[count] = frame.position[d];
        F[count] = frame.F[d];
      }
      if (count == 0) continue;
      const RigidFit<float> fit = fit_rigid<float>(count, weight, rest, now, F);
      out.position[i] = carried_position<float>({}, fit, level.rest[i]);
      out.F[i] = fit.F;
    }
    frames.push_back(std::move(out));
  }
  return frames;
}

}  // namespace pliant

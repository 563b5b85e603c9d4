#include "physics/body/clusters.h"

#include "gaussians/base/error.h"
#include "gaussians/base/nearest.h"
#include "gaussians/base/portable.h"

namespace pliant {

void check_count(const SolidSamples& samples, int count) {
  if (samples.size() == 0)
    throw usage_error("seed", "samples", "there are none", "choose an object with visible Gaussians");
  if (count < 1)
    throw usage_error("seed", "count", "is " + std::to_string(count), "give a positive number of particles");
}

void assign_nearest(const SolidSamples& samples, DrivingParticles& drivers) {
  const NearestPoints tree(drivers.position);
  drivers.sample_driver.resize(samples.size());
  parallel_for(
      static_cast<std::ptrdiff_t>(samples.size()),
      [&](std::ptrdiff_t i) {
        thread_local std::vector<NearestPoints::Hit> hits;
        tree.query(samples.position[i], 1, hits);
        drivers.sample_driver[i] = hits[0].index;
      },
      256);
}

void update_centres(const SolidSamples& samples, DrivingParticles& drivers) {
  std::vector<Vec3d> sum(drivers.size(), Vec3d::Zero());
  std::vector<double> volume(drivers.size(), 0);
  for (size_t i = 0; i < samples.size(); ++i) {
    const int d = drivers.sample_driver[i];
    sum[d] += static_cast<double>(samples.volume[i]) * samples.position[i].cast<double>();
    volume[d] += samples.volume[i];
  }
  for (size_t d = 0; d < drivers.size(); ++d) {
    if (!(volume[d] > 0)) continue;
    drivers.position[d] = (sum[d] / volume[d]).cast<float>();
    drivers.volume[d] = static_cast<float>(volume[d]);
  }
}

}  // namespace pliant

#include "app/simulate/driver_level.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "app/import/interactions.h"
#include "gaussians/base/morton.h"
#include "gaussians/base/nearest.h"
#include "gaussians/render/bind.h"
#include "gaussians/render/deform_kernels.h"
#include "physics/body/driving_particles.h"
#include "physics/body/links.h"

namespace pliant {
namespace {

constexpr size_t kSamplesPerDriver = 12;

/// Solid samples with the thickness of the part that their driver lies in.
SolidSamples samples_of(const ParticleFile& file) {
  SolidSamples samples;
  samples.position = file.solid_position;
  samples.volume = file.solid_volume;
  if (!file.driving_thickness.empty())
    for (const int d : file.solid_driver) samples.thickness.push_back(d < 0 ? 0 : file.driving_thickness[d]);
  samples.spacing = static_cast<float>(std::cbrt(samples.total_volume() / static_cast<double>(samples.size())));
  return samples;
}

/// What hangs together in `file` and nothing else does so in `out`, the same samples with other drivers.
void keep_links(const ParticleFile& file, ParticleFile& out) {
  const SolidSamples all = samples_of(file);
  std::vector<int> kept;
  for (size_t i = 0; i < all.size(); ++i)
    if (out.solid_driver[i] >= 0) kept.push_back(static_cast<int>(i));
  // What only the larger cells simulate lies at a pin.
  const SolidSamples samples = all.select(kept);
  const std::vector<int> nearest = k_nearest(file.driving_position, samples.position, 1);
  std::vector<int> before;
  DrivingParticles drivers{out.driving_position,  out.driving_volume, {},
                           out.driving_thickness, out.driving_rod,    static_cast<float>(out.cell_size)};
  for (size_t k = 0; k < kept.size(); ++k) {
    const int driver = file.solid_driver[kept[k]];
    before.push_back(driver >= 0 ? driver : nearest[k]);
    drivers.sample_driver.push_back(out.solid_driver[kept[k]]);
  }
  const auto linked = [&](int i, int k) {
    const std::array pair{std::min(before[i], before[k]), std::max(before[i], before[k])};
    return pair[0] == pair[1] || std::binary_search(file.driving_links.begin(), file.driving_links.end(), pair);
  };
  separate_drivers(linked, samples, drivers);
  for (size_t k = 0; k < kept.size(); ++k) out.solid_driver[kept[k]] = drivers.sample_driver[k];
  out.driving_position = drivers.position;
  out.driving_volume = drivers.volume;
  out.driving_thickness = drivers.thickness;
  out.driving_rod = drivers.rod;
  out.driving_links = inherited_links(before, file.driving_links, drivers.sample_driver);
}

}  // namespace

ParticleFile with_drivers(const ParticleFile& file, const Scene& scene, int count) {
  if (count >= static_cast<int>(file.driving_position.size())) return file;
  std::vector<Region> pins;
  for (const nlohmann::json& row : nlohmann::json::parse(file.pinned_json))
    pins.push_back(parse_region(row, {scene.metres_per_unit, scene.up}, "particles.h5"));
  const SolidSamples all = samples_of(file);
  // Some of the samples are enough to place fewer drivers; all of them then go where the nearest of those goes.
  std::vector<int> order = morton_order(all.position);
  const auto follows = [&](int i) { return !file.solid_follows.empty() && file.solid_follows[i] >= 0; };
  std::erase_if(order, follows);
  const size_t stride = std::max<size_t>(1, order.size() / (kSamplesPerDriver * static_cast<size_t>(count)));
  std::vector<int> some;
  for (size_t k = stride / 2; k < order.size(); k += stride) some.push_back(order[k]);
  SolidSamples samples = all.select(some);
  for (float& volume : samples.volume) volume *= static_cast<float>(order.size()) / static_cast<float>(some.size());
  samples.spacing = all.spacing * std::cbrt(static_cast<float>(stride));
  const SimulatedPart part = select_simulated(samples, pins, count);
  DriverOptions options;
  options.count = count;
  const DrivingParticles drivers = kmeans_drivers(options, samples.select(part.kept));
  std::vector<int> driver(samples.size(), -1);
  for (size_t k = 0; k < part.kept.size(); ++k) driver[part.kept[k]] = drivers.sample_driver[k];
  ParticleFile out = file;
  const std::vector<int> nearest = k_nearest(samples.position, all.position, 1);
  for (size_t i = 0; i < all.size(); ++i) out.solid_driver[i] = follows(static_cast<int>(i)) ? -1 : driver[nearest[i]];
  for (size_t k = 0; k < some.size(); ++k) out.solid_driver[some[k]] = driver[k];
  out.driving_position = drivers.position;
  out.driving_volume = drivers.volume;
  out.driving_thickness = drivers.thickness;
  out.driving_rod = drivers.rod;
  out.cell_size = drivers.cell_size;
  if (!file.driving_links.empty()) keep_links(file, out);
  return out;
}

Binding bind_level(const ParticleFile& file, const ParticleFile& level) {
  const std::vector<Vec3f>& points = level.driving_position;
  std::vector<int> own = own_drivers(file, points);
  // Its own samples say more of where a driver belongs than the nearest ones, which may be of another part.
  std::vector<float> nearest(own.size(), std::numeric_limits<float>::infinity());
  for (size_t s = 0; !own.empty() && s < level.solid_position.size(); ++s) {
    const int point = level.solid_driver[s], driver = file.solid_driver[s];
    if (point < 0 || driver < 0) continue;
    const float distance = (level.solid_position[s] - points[point]).squaredNorm();
    if (distance >= nearest[point]) continue;
    nearest[point] = distance;
    own[point] = driver;
  }
  return pliant::bind({}, points, file.driving_position, {.links = file.driving_links, .own = own});
}

std::vector<DriverFrame> motion_of(const MovingScene& moving, const ParticleFile& level) {
  const std::vector<Vec3f>&drivers = moving.particles.driving_position, &points = level.driving_position;
  std::vector<DriverFrame> frames;
  const bool same = drivers == points;
  const Binding binding = same ? Binding{} : bind_level(moving.particles, level);
  for (const TrajectoryFile::Frame& frame : moving.trajectory.frames) {
    if (same) {
      frames.push_back({frame.position, frame.F});
      continue;
    }
    DriverFrame out{points, std::vector<Mat3f>(points.size(), Mat3f::Identity())};
    for (size_t i = 0; i < points.size(); ++i) {
      const GatheredDrivers<float> gathered(binding, static_cast<std::ptrdiff_t>(i), drivers, frame.position, frame.F);
      if (gathered.count == 0) continue;
      const RigidFit<float> fit = gathered.fit();
      out.position[i] = carried_position<float>({}, fit, points[i]);
      out.F[i] = fit.F;
    }
    frames.push_back(std::move(out));
  }
  return frames;
}

std::optional<TrajectoryFile::Memory> memory_of(const MovingScene& moving, const ParticleFile& level) {
  const std::vector<Vec3f>&drivers = moving.particles.driving_position, &points = level.driving_position;
  if (!moving.trajectory.memory || drivers == points) return moving.trajectory.memory;
  const TrajectoryFile::Memory& all = *moving.trajectory.memory;
  const Binding binding = bind_level(moving.particles, level);
  TrajectoryFile::Memory out;
  for (size_t i = 0; i < points.size(); ++i) {
    Mat3f F = Mat3f::Zero(), F_viscous = Mat3f::Zero();
    float history = 0, sum = 0;
    for (int k = 0; k < Binding::kCount; ++k) {
      const int d = binding.driver[i * Binding::kCount + k];
      if (d < 0) break;
      const float weight = binding.weight[i * Binding::kCount + k];
      F += weight * all.F[d];
      F_viscous += weight * all.F_viscous[d];
      history += weight * all.history[d];
      sum += weight;
    }
    out.F.push_back(sum > 0 ? F : Mat3f::Identity());
    out.F_viscous.push_back(sum > 0 ? F_viscous : Mat3f::Identity());
    out.history.push_back(history);
  }
  return out;
}

}  // namespace pliant

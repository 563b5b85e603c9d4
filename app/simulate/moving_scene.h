#pragma once

#include <span>
#include <vector>

#include "app/run/run_directory.h"
#include "app/store/particles.h"
#include "app/store/trajectory.h"
#include "gaussians/base/binding.h"
#include "gaussians/base/gaussian_cloud.h"
#include "gaussians/io/scene/scene.h"

namespace pliant {

/// A simulated run as it is drawn: the object follows its driving particles in front of the background.
struct MovingScene {
  GaussianCloud object, background;  ///< at rest
  ParticleFile particles;
  TrajectoryFile trajectory;
  Binding binding;           ///< object's Gaussians to driving particles; pinned ones follow none
  bool antialiased = false;  ///< the scene was trained with mip-splatting

  size_t moving() const;  ///< Gaussians that follow a particle
  GaussianCloud object_at(const TrajectoryFile::Frame& frame) const;
  /// Background, then object.
  GaussianCloud all_at(const TrajectoryFile::Frame& frame) const;
};

/// [N] driver of the part that each of the points [N, 3] (scene units, at rest) shows: that of the nearest simulated
/// sample, so that of two leaves that nearly touch a Gaussian belongs to its own.  Empty where the drivers have no
/// links.
std::vector<int> own_drivers(const ParticleFile& particles, std::span<const Vec3f> points);

/// The object's Gaussians to its driving particles.  Those of a disconnected piece move as one with the nearest
/// simulated part; those in a pinned region are rigid and follow none.
Binding bind_object(const Scene& scene, const ParticleFile& particles, const GaussianCloud& object);

/// The scene without the object: repaired, where that was done since the object was extracted, else with its hole.
std::filesystem::path background_of(const RunDirectory& run);

/// The files of a moving scene by role: object, background, particles, trajectory.  A usage error says so when the run
/// has not been simulated.
InputFiles moving_scene_files(const RunDirectory& run);

/// The same with the motion that `simulate --recording` wrote, and its particles.  A usage error of --recorded says so
/// when there is none.
InputFiles recorded_scene_files(const RunDirectory& run);
/// Throws Error{kUsage} unless that motion moves the splats that are the object now.
void check_recorded_object(const InputFiles& files);

/// `files` as one of these gave them; of the scene antialiased, up and metres_per_unit are used.  Throws
/// Error{kInput} where the trajectory is of another number of particles.
MovingScene load_moving_scene(const InputFiles& files, const Scene& scene);

}  // namespace pliant

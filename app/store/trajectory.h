#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "gaussians/base/types.h"

namespace pliant {

/// trajectory.h5, shaped like H5MD 1.1 (de Buyl et al. 2014): /particles/<object>/{position, velocity, F}/
/// {value [T, M, ...], step [T], time [T]}, float32, one compressed chunk per frame.
struct TrajectoryFile {
  struct Frame {
    double time = 0;                        ///< s
    int64_t step = 0;                       ///< substeps since time 0
    std::vector<Vec3f> position, velocity;  ///< [M, 3] scene units, m/s
    std::vector<Mat3f> F;                   ///< [M, 3, 3] deformation from the captured shape
  };
  /// What laws that yield, flow or relax remember.
  struct Memory {
    std::vector<Mat3f> F, F_viscous;  ///< [M, 3, 3] elastic parts: of the deformation, in the relaxing branch
    std::vector<float> history;       ///< [M] see LawMemory
  };
  std::string object = "object";  ///< name of the group, see group_name
  double fps = 0;
  double metres_per_unit = 1;
  double cell_size = 0;      ///< scene units
  Vec3d up = Vec3d::Zero();  ///< unit; zero = unknown
  std::vector<Frame> frames;
  std::optional<Memory> memory;  ///< in the first frame; stored as /particles/<object>/memory

  /// The state at a time in s: the frame itself where there is one, else positions on cubics that keep the velocities
  /// of both frames beside it (Hermite), velocities and F linear; the first or last frame outside of the clip.
  Frame at(double time) const;
};

/// The name of an object as HDF5 takes it for a group: without a '/', and not a single dot.
std::string group_name(std::string object);

void write_trajectory(const std::filesystem::path& file, const TrajectoryFile& trajectory,
                      const std::string& provenance_json);
/// What write_trajectory was given besides the motion.
std::string read_trajectory_provenance(const std::filesystem::path& file);
/// Reads the object of that name; an empty name takes the only one.
TrajectoryFile read_trajectory(const std::filesystem::path& file, const std::string& object = "");

}  // namespace pliant

#include "app/import/physgaussian_output.h"

#include <Eigen/LU>
#include <cstdio>
#include <optional>

#include "app/store/hdf5_file.h"
#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"

namespace fs = std::filesystem;

namespace pliant {
namespace {

/// One frame in simulation space; matrices of shape (components, N) as PhysGaussian stores them.
struct SimFrame {
  std::vector<float> x, v, F, C;
};

/// Velocity gradient from the change of F to a neighbouring frame.
Mat3d velocity_gradient(const Mat3d& F, const Mat3d& other, double dt) {
  return dt == 0 || std::abs(F.determinant()) < 1e-12 ? Mat3d::Zero().eval() : Mat3d((other - F) / dt * F.inverse());
}

SimFrame frame_in_space(const TrajectoryFile& trajectory, size_t f, const SimulationSpace& space) {
  const TrajectoryFile::Frame& frame = trajectory.frames[f];
  const size_t n = frame.position.size(), last = trajectory.frames.size() - 1;
  const TrajectoryFile::Frame& other = trajectory.frames[f < last ? f + 1 : (f > 0 ? f - 1 : f)];
  const double dt = other.time - frame.time;
  SimFrame out;
  out.x.resize(3 * n);
  out.v.resize(3 * n);
  out.F.resize(9 * n);
  out.C.resize(9 * n);
  for (size_t i = 0; i < n; ++i) {
    const Vec3d x = space.from_scene(frame.position[i].cast<double>()), v = space.R * frame.velocity[i].cast<double>();
    const Mat3d F = space.R * frame.F[i].cast<double>() * space.R.transpose();
    const Mat3d C = velocity_gradient(F, space.R * other.F[i].cast<double>() * space.R.transpose(), dt);
    for (int a = 0; a < 3; ++a) {
      out.x[a * n + i] = static_cast<float>(x[a]);
      out.v[a * n + i] = static_cast<float>(v[a]);
      for (int b = 0; b < 3; ++b) {
        out.F[(3 * a + b) * n + i] = static_cast<float>(F(a, b));
        out.C[(3 * a + b) * n + i] = static_cast<float>(C(a, b));
      }
    }
  }
  return out;
}

std::string name_of(size_t frame, const char* extension) {
  char name[40];
  std::snprintf(name, sizeof name, "sim_%010zu.%s", frame, extension);
  return name;
}

std::string ply_of(const SimFrame& frame) {
  const size_t n = frame.x.size() / 3;
  std::string bytes = "ply\nformat binary_little_endian 1.0\nelement vertex " + std::to_string(n) +
                      "\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
  for (size_t i = 0; i < n; ++i)
    for (int a = 0; a < 3; ++a) bytes.append(reinterpret_cast<const char*>(&frame.x[a * n + i]), sizeof(float));
  return bytes;
}

/// The frame of a file of such a name.
std::optional<size_t> frame_of(const std::string& name) {
  size_t frame = 0;
  for (const char* extension : {"h5", "ply"})
    if (std::sscanf(name.c_str(), "sim_%10zu.", &frame) == 1 && name == name_of(frame, extension)) return frame;
  return std::nullopt;
}

}  // namespace

void write_physgaussian_output(const fs::path& folder, const PhysGaussianOutput& what, const TrajectoryFile& trajectory,
                               const SimulationSpace& space) {
  const fs::path target = folder / "simulation_ply";
  fs::create_directories(target);
  for (size_t f = 0; f < trajectory.frames.size(); ++f) {
    const SimFrame frame = frame_in_space(trajectory, f, space);
    const size_t n = trajectory.frames[f].position.size();
    if (what.h5) {
      write_hdf5(target / name_of(f, "h5"), [&](Hdf5Writer& out) {
        const float time = static_cast<float>(trajectory.frames[f].time);
        out.dataset("x", frame.x.data(), {3, n});
        out.dataset("time", &time, {1, 1});
        out.dataset("f_tensor", frame.F.data(), {9, n});
        out.dataset("v", frame.v.data(), {3, n});
        out.dataset("C", frame.C.data(), {9, n});
      });
    }
    if (what.ply) write_text(target / name_of(f, "ply"), ply_of(frame));
  }
}

void remove_physgaussian_frames(const fs::path& folder, size_t first) {
  std::vector<fs::path> later;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder / "simulation_ply", ignored)) {
    const std::optional<size_t> frame = frame_of(entry.path().filename().string());
    if (frame && *frame >= first) later.push_back(entry.path());
  }
  for (const fs::path& file : later) fs::remove(file);
}

}  // namespace pliant

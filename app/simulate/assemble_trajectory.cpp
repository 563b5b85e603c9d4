#include "app/simulate/assemble_trajectory.h"

#include <Eigen/LU>

#include "physics/mpm/whole_deformation.h"

namespace pliant {
namespace {

/// From the captured to the unloaded shape: frame 0 has the deformation of the load and, on top, that of the start.
std::vector<Mat3f> unloading(const SimulationState& start, const SimulationState& first) {
  std::vector<Mat3f> out = whole_deformation(start);
  const std::vector<Mat3f> both = whole_deformation(first);
  for (size_t i = 0; i < out.size(); ++i) out[i] = (both[i].inverse() * out[i]).eval();
  return out;
}

/// `before`: see `unloading`.  A body that goes on carrying its weight counts as unstressed in the shape in which it
/// stands, in its relaxing branch too.
TrajectoryFile::Memory remembered(const SimulationState& state, const std::vector<Mat3f>& before, const Mat3f& R) {
  TrajectoryFile::Memory out;
  for (size_t i = 0; i < state.size(); ++i) {
    const Mat3f F = before.empty() ? state.F[i] : Mat3f(state.F[i] * before[i]);
    out.F.push_back(R.transpose() * F * R);
    out.F_viscous.push_back(before.empty() ? Mat3f(R.transpose() * state.memory[i].F_viscous * R) : out.F.back());
    out.history.push_back(state.memory[i].history);
  }
  return out;
}

}  // namespace

TrajectoryFile assemble_trajectory(const FrameStore& frames, int count, const SimulatedBody& body,
                                   const SimulationState& start, bool loaded) {
  TrajectoryFile out;
  out.metres_per_unit = body.space.scale;
  out.cell_size = body.particles.cell_size / body.space.scale;
  const Mat3f R = body.space.R.cast<float>();
  const std::vector<Mat3f> before = loaded ? unloading(start, frames.frame(0)) : std::vector<Mat3f>();
  const bool carries = !flows(body.particles.materials[0].law);
  for (int f = 0; f < count; ++f) {
    const SimulationState state = frames.frame(f);
    if (f == 0 && !state.memory.empty()) out.memory = remembered(state, carries ? before : std::vector<Mat3f>(), R);
    TrajectoryFile::Frame frame;
    frame.time = state.time;
    frame.step = state.substeps;
    frame.F = whole_deformation(state);
    for (size_t i = 0; i < before.size(); ++i) frame.F[i] = (frame.F[i] * before[i]).eval();
    for (Mat3f& F : frame.F) F = R.transpose() * F * R;
    for (const Vec3f& x : state.x) frame.position.push_back(body.space.to_scene(x.cast<double>()).cast<float>());
    for (const Vec3f& v : state.v) frame.velocity.push_back(R.transpose() * v);
    out.frames.push_back(std::move(frame));
  }
  return out;
}

}  // namespace pliant

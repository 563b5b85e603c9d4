#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "gaussians/base/types.h"
#include "physics/laws/law.h"

namespace pliant {

/// Particles at rest; everything in SI units.
template <class T>
struct BasicParticles {
  std::vector<Vec3<T>> position;  ///< [N, 3] at rest, m
  std::vector<T> volume;          ///< [N] V0, m^3
  std::vector<T> mass;            ///< [N] kg
  std::vector<T> young;           ///< [N] E, Pa
  std::vector<T> poisson;         ///< [N] nu
  T cell_size = 0;                ///< grid spacing dx, m

  std::vector<Material> materials = {Material{}};  ///< at least one
  std::vector<uint16_t> material_index;            ///< [N] into `materials`; empty = all of the first
  std::vector<uint16_t> object;                    ///< [N] bodies that touch but do not stick; empty = one body

  /// Pairs that hang together at rest; where there are any, a Lagrangian grid lets parts that they do not lead to move
  /// apart, however near they are.  Empty = what shares a cell hangs together.
  std::vector<std::array<int, 2>> links;

  size_t size() const { return position.size(); }
  const Material& material(size_t i) const { return materials[material_index.empty() ? 0 : material_index[i]]; }
  /// Whether the law of any particle has a memory.
  bool has_memory() const;
  double total_mass() const;
  double total_volume() const;
};

/// Everything that moves.  Saved and restored at a frame border, the simulation continues bit for bit.
template <class T>
struct BasicSimulationState {
  double time = 0;  ///< s
  int frame = 0;
  int64_t substeps = 0;              ///< taken since time 0
  std::vector<Vec3<T>> x, v;         ///< [N, 3] position m, velocity m/s
  std::vector<Mat3<T>> C, F;         ///< [N, 3, 3] affine velocity field 1/s, elastic deformation gradient
  std::vector<LawMemory<T>> memory;  ///< [N], or empty when no law has a memory; F is then the whole deformation

  /// [nodes, 3] m and m/s of the nodes of a Lagrangian grid, whose motion is that of the body; where they are empty, as
  /// at a start, they follow from the particles.
  std::vector<Vec3<T>> node_displacement, node_velocity;
  std::vector<T> quiet_time;  ///< [N] s for which the neighbourhood has been at rest; empty unless bodies may sleep

  size_t size() const { return x.size(); }
};

using Particles = BasicParticles<float>;
using SimulationState = BasicSimulationState<float>;

/// At rest: x = position, v = C = 0, F = I, no memory of anything, time 0.
template <class T>
BasicSimulationState<T> initial_state(const BasicParticles<T>& particles);

extern template struct BasicParticles<float>;
extern template struct BasicParticles<double>;
extern template BasicSimulationState<float> initial_state(const BasicParticles<float>&);
extern template BasicSimulationState<double> initial_state(const BasicParticles<double>&);

}  // namespace pliant

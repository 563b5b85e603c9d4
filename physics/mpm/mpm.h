#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "physics/loads/step_loads.h"
#include "physics/mpm/contact_list.h"
#include "physics/mpm/kernels/kernels.h"
#include "physics/mpm/mpm_data.h"
#include "physics/mpm/mpm_options.h"
#include "physics/mpm/particles.h"
#include "physics/mpm/step_tape.h"

namespace pliant {

/// Mass, momentum and angular momentum about the origin.
struct Totals {
  double mass = 0;
  Vec3d momentum = Vec3d::Zero(), angular = Vec3d::Zero();
};

/// Elastic bodies in moving least squares MPM (Hu et al. 2018) with APIC transfers (Jiang et al. 2015) on a
/// block-sparse grid that follows the particles.  Nodes lie at origin + dx * integers.  One step is
///   m_i = sum w m_p, (m v)_i = sum w m_p (v_p + C_p (x_i - x_p)) - dt sum V0 tau (4 / dx^2) w (x_i - x_p)
///   v_i <- v_i + dt g, boundary conditions
///   v_p = sum w v_i, C_p = (4 / dx^2) sum w v_i (x_i - x_p)^T, F <- (I + dt C) F, x <- x + dt v.
/// With MpmOptions::lagrangian weights and distances are those at rest, so that they never change.  The motion is that
/// of the nodes, and particles follow it: with d = X_i - X_p
///   u_p = sum w u_i, F = I + G, G = (4 / dx^2) sum w u_i d^T, x = X + u_p
///   v_i <- exp(-rate dt) v_i - (dt / m_i) sum w (V0 P (4 / dx^2) d + k (u_i - u_p - G d)) + dt g, boundary conditions
///   u_i <- u_i + dt v_i,
/// k that of MpmOptions::stabilization.
template <class T>
class Mpm {
 public:
  Mpm(const BasicParticles<T>& particles, double dx, const Vec3d& origin, const MpmOptions& options = {});

  /// Load bits of every particle, in the order of the particles.
  void set_load_bits(const std::vector<uint32_t>& bits);
  /// Surface elements [m^2] of every particle at rest, which wind acts on.
  void set_exposure(std::vector<Vec3<T>> exposure);

  /// Takes over a state.  Particles that leave [low, high] are put back and counted, but for Lagrangian runs.
  void load(const BasicSimulationState<T>& state, const Vec3d& low, const Vec3d& high);
  /// Writes x, v, C, F in the order of the particles.
  void store(BasicSimulationState<T>& state) const;
  /// In a Lagrangian run: x and F of the loaded state are from now on what the displacements of the nodes make of them.
  void drop_undisplaced() { data_.undisplaced.clear(); }

  /// Takes up to `count` steps on all threads.  Before step k, prepare(k) sets the loads; check() after it returns
  /// false to stop.  False when stopped or when a particle ceased to be finite.  Equal for any number of threads.
  /// What the steps read is added to `tape` if there is one.
  bool advance(int count, T dt, StepLoads<T>& loads, const std::function<void(int)>& prepare,
               const std::function<bool()>& check, StepTape<T>* tape = nullptr);

  /// All that a continuation since the last `load` needs, bit for bit.
  class Snapshot;
  Snapshot save() const;
  void restore(const Snapshot& snapshot);
  /// Bytes of a snapshot, and of one step on a tape with the present blocks.
  size_t snapshot_bytes() const {
    return data_.record.size() * (sizeof(ParticleRecord<T>) + 2 * sizeof(int)) +
           3 * data_.node_displacement.size() * sizeof(Node<T>) +
           data_.side.size() * (sizeof(LawSide<T>) + 6 * sizeof(T));
  }
  size_t tape_bytes() const {
    return data_.record.size() * ((options_.lagrangian ? 0 : sizeof(TapeParticle<T>)) + sizeof(int)) +
           (data_.node.size() + data_.old_node.size() + 2 * data_.node_displacement.size()) * sizeof(Node<T>) +
           data_.side.size() * (sizeof(LawMemory<T>) + 6 * sizeof(T));
  }

  /// Wakes all that sleeps if the gravity, pins, colliders or marks of `loads` differ from those of the last call since
  /// `load`; every step begins with one.
  void wake_on_change(const StepLoads<T>& loads);

  /// The three parts of a step, on one thread.
  void particles_to_grid(T dt, const StepLoads<T>& loads);
  void update_grid(T dt, const StepLoads<T>& loads);
  void grid_to_particles(T dt);

  bool finite() const { return finite_; }
  /// m/s, of particles after the last step; in Lagrangian runs of nodes, from the mean velocity, see NodeFrame.
  double max_speed() const { return max_speed_; }
  int64_t strays() const { return strays_; }
  /// Momentum [N s] that the colliders, then the pins, then the body loads gave to the body in the last step.
  const std::vector<Vec3d>& impulses() const { return impulse_; }
  int64_t particle_updates() const { return updates_; }  ///< since construction; particles asleep are left out

  /// Mass, centre of mass, mean velocity and second moments of some particles; equal for any number of threads.
  struct Motion {
    double mass = 0;
    Vec3d centre = Vec3d::Zero(), velocity = Vec3d::Zero();
    Mat3d second = Mat3d::Zero();  ///< [kg m^2] sum of m r r^T, r from the centre of mass
    /// Tensor of inertia [kg m^2] about the centre.
    Mat3d inertia() const { return second.trace() * Mat3d::Identity() - second; }
  };
  Motion motion_of(std::span<const int> particles) const;

  /// Of the nodes between particles_to_grid and update_grid (momenta) or after update_grid (velocities).
  Totals grid_totals(bool velocities) const;
  /// Of the particles of an Eulerian run, the affine part of APIC included.
  Totals particle_totals() const;

  /// J in the nodes of a Lagrangian run after a step: of their motion, half a step before their displacement, and of
  /// the stabilization.
  struct NodeEnergy {
    double kinetic = 0, stabilization = 0;
  };
  NodeEnergy node_energy() const;

  /// Records, order, links and patches as they are now.
  const MpmData<T>& data() const { return data_; }

 private:
  ParticlePlace<double> place_of(int particle) const;
  std::array<int, 3> corner_of(const T* x) const;  // the lowest node of the stencil at x
  BlockGrid::Coordinates block_of(const T* x, int object) const;
  void load_record(int i, const BasicSimulationState<T>& state, ParticleRecord<T>& r);
  void fit_blocks();
  void load_rest(const BasicSimulationState<T>& state);
  void store_rest(BasicSimulationState<T>& state) const;
  ParticleRun<T> run_of(int b);
  void reorder_chunk(int chunk);
  bool sleeping() const { return options_.sleep_speed > 0; }
  void carry_rest();
  bool scatter_can_wait(int b, T dt, const StepLoads<T>& loads);
  void measure_motion(int n);
  bool gather_can_wait(int b, T dt);
  void watch_rest(int b, T dt);
  void apply_laws(int b, T dt, const T* grid_C);
  void set_given_stress(const ParticleRecord<T>& r, const Mat3<T>& F);
  void apply_body_loads(int b, T dt, const StepLoads<T>& loads);
  void scatter_block(int b, T dt, const StepLoads<T>& loads);
  void sum_node_block(int n);
  void update_node_block(int n, T dt, const StepLoads<T>& loads);
  void apply_conditions(int n, const StepLoads<T>& loads);
  void condition_node_block(int n, T dt, const StepLoads<T>& loads);
  ElasticRun<T> elastic_run(int b, T dt, const StepLoads<T>& loads) const;
  void elastic_block(int b, T dt, const StepLoads<T>& loads);
  void find_gains(int b, T dt, const StepLoads<T>& loads);
  void follow_block(int b);
  void add_contacts(int b, T dt, const StepLoads<T>& loads);
  bool touching() const { return options_.lagrangian && options_.contact && !contacts_.empty(); }
  bool meeting_on_nodes() const { return !options_.lagrangian && data_.grid.has_siblings(); }
  void find_kept(T dt);
  void collect_node_reports();
  void displace_node_block(int n, T dt);
  void find_pairs();
  void find_rest_constants();
  void load_nodes(const BasicSimulationState<T>& state);
  void store_nodes(BasicSimulationState<T>& state) const;
  void find_undisplaced();
  T flip(T dt) const;
  void gather_block(int b, T dt, const StepLoads<T>& loads);
  void damp_affine(int b, T strain_rate_kept, T spin_kept);
  void collect_reports();
  void clear_impulses(const StepLoads<T>& loads);
  void record_block(int b, TapeStep<T>& step) const;
  void record_node_block(int n, TapeStep<T>& step) const;

  MpmData<T> data_;
  std::vector<ParticleRecord<T>> rest_;     // in the order of the particles, only constants
  std::vector<BlockGrid::Link> links_;      // see BasicParticles, in Lagrangian runs
  std::vector<Vec3<T>> gain_;               // [slots] m/s, what loads give to particles, in Lagrangian runs
  std::vector<uint8_t> loaded_;             // [particle blocks] whether any particle has load bits, likewise
  std::vector<T> kept_;                     // [nodes] share of its velocity that a node keeps in a step of kept_dt_
  T kept_dt_ = 0;                           // s
  double mass_ = 0;                         // kg, of all
  Vec3<T> drift_ = Vec3<T>::Zero();         // m/s, mean velocity before the step
  std::vector<NodeReport<T>> node_report_;  // of the last step
  ContactList<T> contacts_;
  std::vector<Vec3<T>> where_, moving_;  // [slots] x and v of particles that may touch
  bool viscous_ = false;                 // whether the stress of any material depends on the strain rate
  std::vector<int> moved_;               // places in their block of the particles that left it, block by block
  std::vector<GatherReport<T>> report_;  // of the last gather, per particle block
  const MpmKernels<T>* kernels_;
  StressKind uniform_;  // law of all particles if a kernel for it alone will do, else kGiven
  std::vector<Vec3d> node_impulse_, particle_impulse_;  // [node blocks, colliders and pins], [particle blocks, loads]
  std::vector<Vec3d> impulse_;                          // their sums

  MpmOptions options_;
  std::vector<BlockRest<T>> rest_of_block_;  // [particle blocks], with sleep_speed only
  std::vector<NodeMotion<T>> node_motion_;   // [node blocks], likewise
  Vec3<T> last_gravity_ = Vec3<T>::Zero();   // of the last step, whose change wakes all
  std::vector<int> last_conditions_;         // likewise; empty = not known

  static constexpr int kReorderChunk = 2048;
  std::vector<ParticleRecord<T>> spare_record_;
  int64_t moves_since_reorder_ = 0, updates_ = 0;
  bool finite_ = true;
  double max_speed_ = 0;
  int64_t strays_ = 0;
};

template <class T>
class Mpm<T>::Snapshot {
  friend class Mpm;
  std::vector<ParticleRecord<T>> record_;
  std::vector<int> slot_;
  BlockGrid grid_;
  std::vector<Node<T>> node_displacement_, node_displacement_rest_, node_velocity_;
  std::vector<LawSide<T>> side_;
  std::vector<T> given_stress_;
  std::vector<BlockRest<T>> rest_of_block_;
  int64_t moves_since_reorder_;
};

/// A law with nothing but Lame parameters; not of kGiven.
const Material& plain_material(StressKind kind);
/// First Piola-Kirchhoff stress P [9] of such a law, for any F [9].
template <class T>
void exact_piola(StressKind kind, const T* F, T mu, T lambda, T* P);

extern template class Mpm<float>;
extern template class Mpm<double>;

}  // namespace pliant

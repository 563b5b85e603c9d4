#pragma once

#include <functional>
#include <span>
#include <vector>

#include "physics/mpm/contact_list.h"
#include "physics/mpm/kernels/kernels.h"
#include "physics/mpm/kernels/step_adjoint_view.h"
#include "physics/mpm/mpm_data.h"
#include "physics/mpm/particles.h"
#include "physics/mpm/step_tape.h"

namespace pliant {

/// Derivatives of a scalar L with respect to what a particle remembers.
template <class T>
struct MemoryGradient {
  Mat3<T> F_total = Mat3<T>::Zero(), F_viscous = Mat3<T>::Zero();
  T history = 0;
};

/// Derivatives of a scalar L with respect to a state.
template <class T>
struct StateGradient {
  std::vector<Vec3<T>> x, v;                                        ///< [N, 3]
  std::vector<Mat3<T>> C, F;                                        ///< [N, 3, 3]
  std::vector<MemoryGradient<T>> memory = {};                       ///< [N] or empty = zero
  std::vector<Vec3<T>> node_displacement = {}, node_velocity = {};  ///< [nodes, 3] or empty = zero

  static StateGradient zero(size_t n) {
    return {std::vector<Vec3<T>>(n, Vec3<T>::Zero()),
            std::vector<Vec3<T>>(n, Vec3<T>::Zero()),
            std::vector<Mat3<T>>(n, Mat3<T>::Zero()),
            std::vector<Mat3<T>>(n, Mat3<T>::Zero()),
            {},
            {},
            {}};
  }
};

/// Derivatives of L with respect to what acts during one substep.
struct StepLoadsGradient {
  Vec3d gravity = Vec3d::Zero();
  double velocity_scale = 0;
  std::vector<double> density;         ///< of each object, as far as any touch
  std::vector<BodyLoadGradient> body;  ///< in the order of StepLoads::body
};

/// Derivatives of L with respect to the constants of the particles, over all steps gone back through.
template <class T>
struct ParticleGradient {
  std::vector<T> mass;                    ///< [N] at fixed volume
  std::vector<T> mu, lambda;              ///< [N] Lame parameters
  std::vector<T> viscosity_time;          ///< [N] Kelvin-Voigt, of the loads and of the material together
  std::vector<T> damping_rate;            ///< [N] of the material
  std::vector<BranchGradient<T>> branch;  ///< [N] of the material, or empty where none is viscoelastic
};

/// Goes back through recorded steps of `Mpm`: the exact derivative of each line of a step, by hand.  Sums are taken in
/// a fixed order, so results are equal bit for bit for any number of threads.  Not differentiated: the choice of
/// nodes under a particle (weights are continuous there), and the place to which a stray is put back.
template <class T>
class StepAdjoint {
 public:
  /// `solver` takes the steps; both must outlive this.
  StepAdjoint(const BasicParticles<T>& particles, const MpmData<T>& solver);

  /// Sets the derivatives with respect to `state`, the state after the last step of `tape`.
  void load(const StateGradient<T>& gradient, const BasicSimulationState<T>& state, const StepTape<T>& tape);
  /// Goes back through the steps of `tape`, last one first.  After step k, loads(k, gradient) is called, which may add
  /// what the particles did to the loads (`motion_adjoint`).
  void reverse(const StepTape<T>& tape, const std::function<void(int, const StepLoadsGradient&)>& loads);
  /// Derivatives with respect to `state`, that before the first step, which is the first of `tape`.
  void store(const BasicSimulationState<T>& state, const StepTape<T>& tape, StateGradient<T>& gradient);

  /// Centre of mass and mean velocity of some particles at the start of a step; the functions below it want to be
  /// called for the same step afterwards.
  struct Motion {
    Vec3d centre = Vec3d::Zero(), velocity = Vec3d::Zero();
    double mass = 0;
  };
  Motion motion_of(const TapeStep<T>& step, std::span<const int> particles);
  /// The way back: adds to the derivatives by the particles at the start of the step, which was the last gone through.
  void motion_adjoint(const TapeStep<T>& step, std::span<const int> particles, const Motion& motion,
                      const Vec3d& by_centre, const Vec3d& by_velocity);
  /// Tensor of inertia [kg m^2] about the centre of mass.
  Mat3d inertia_of(const TapeStep<T>& step, std::span<const int> particles, const Vec3d& centre) const;
  void inertia_adjoint(const TapeStep<T>& step, std::span<const int> particles, const Vec3d& centre,
                       const Mat3d& by_inertia);
  ParticleGradient<T> particle_gradient() const;
  size_t bytes() const;

 private:
  ParticlePlace<double> place_of(const TapeStep<T>& step, int particle) const;
  AdjointRecord<T>& followed_record(int particle);
  void set_constants(AdjointRecord<T>& record, const ParticleRecord<T>& of) const;
  void begin_step(const StepTape<T>& tape, const TapeStep<T>& step);
  AdjointRun<T> run_of(const TapeStep<T>& step, int b) const;
  NodeBlock<T> node_block(const TapeStep<T>& step, std::vector<Node<T>>& nodes, int n) const;
  void find_velocities(const TapeStep<T>& step, int n);
  void find_conditioned_velocities(const TapeStep<T>& step, int n);
  void reverse_affine_damping(const TapeStep<T>& step, int b, const Node<T>* velocity);
  void reverse_return_maps(const TapeStep<T>& step, int b, T* by_grid_C);
  void reverse_gather(const TapeStep<T>& step, int b);
  void reverse_conditions(const TapeStep<T>& step, int n);
  void reverse_contact(const TapeStep<T>& step, int n);
  void reverse_update(const TapeStep<T>& step, int n);
  ElasticAdjointRun<T> elastic_run(const TapeStep<T>& step, int b) const;
  void load_node_gradient(const StateGradient<T>& gradient, const TapeStep<T>& last);
  void reverse_follow(const TapeStep<T>& step, int b);
  void reverse_displacement(const TapeStep<T>& step, int n);
  void sum_node_gradient(const BlockGrid& grid, int n);
  void reverse_push(const TapeStep<T>& step, int n);
  void reverse_impulses(const TapeStep<T>& step, int b);
  void reverse_load_nodes(const TapeStep<T>& first, const BasicSimulationState<T>& state, StateGradient<T>& gradient);
  void follow_block(const TapeStep<T>& step, int b);
  void add_contacts(const TapeStep<T>& step, int b, std::vector<T>& gain) const;
  void reverse_contacts(const TapeStep<T>& step, int b);
  void reverse_undisplaced();
  void reverse_projections(const BasicSimulationState<T>& state);
  void add_node_constants(ParticleGradient<T>& by) const;
  std::vector<T> gains(const TapeStep<T>& step, int b, const TapeParticle<T>* particle) const;
  void reverse_scatter(const TapeStep<T>& step, int b);
  std::vector<T> loaded_velocities(const TapeStep<T>& step, int b) const;
  void reverse_body_loads(const TapeStep<T>& step, int b, const TapeParticle<T>* particle, const T* by_gains);
  void reverse_given_stress(const TapeStep<T>& step, int b, const T* by_stress);
  StepLoadsGradient sum_loads(const TapeStep<T>& step) const;

  const BasicParticles<T>& particles_;
  const MpmData<T>& solver_;
  const MpmKernels<T>& forward_;
  const AdjointKernels<T>& kernels_;
  StressKind uniform_;                             // law of all particles, or kGiven
  std::vector<AdjointRecord<T>> record_;           // in block order of the last step loaded
  std::vector<MemoryGradient<T>> memory_;          // by ParticleRecord::side
  std::vector<BranchGradient<T>> by_branch_;       // likewise, summed over the steps done
  std::vector<int> slot_;                          // of particle i in record_
  std::vector<int> place_;                         // of particle i in the step of `motion_of`
  AdjointRun<T> run_;                              // what the blocks of the present step have in common
  std::vector<Node<T>> velocity_;                  // [node blocks, 4, 4, 4] after the conditions
  std::vector<Node<T>> updated_;                   // before the conditions
  std::vector<Node<T>> before_contact_;            // before contact between objects, where there is any
  std::vector<Node<T>> by_contact_mass_;           // see ContactGradient
  std::vector<double> by_density_;                 // [node blocks]
  std::vector<Node<T>> patch_;                     // [particle blocks, 6, 6, 6] derivatives by them
  std::vector<Node<T>> adj_node_;                  // [node blocks, 4, 4, 4] summed; then by momentum and mass
  std::vector<Node<T>> old_patch_, adj_old_node_;  // the same for velocities before the step, where flip > 0
  // Of a Lagrangian grid, whose patch_ and old_patch_ hold derivatives by displacement and velocity: [nodes] by
  // velocity and displacement after the step, by the stabilization and the damping, [slots, 12] by `undisplaced`.
  std::vector<Vec3<T>> adj_velocity_, adj_displacement_;
  std::vector<T> adj_stabilization_, adj_damping_, adj_undisplaced_;
  std::vector<uint8_t> followed_;  // [particle blocks] whether records hold derivatives by what follows the nodes
  std::vector<T> kept_;            // [nodes] as in Mpm
  ContactList<T> contacts_;
  std::vector<Vec3<T>> where_, moving_;       // [slots] x and v of particles that may touch
  std::vector<T> by_gain_;                    // [slots, 3] derivatives by what loads and contact give to particles
  bool viscous_ = false;                      // whether the stress of any material depends on the strain rate
  std::vector<BodyLoadGradient> block_sums_;  // [particle blocks, body loads]
  std::vector<StepLoadsGradient> node_sums_;  // [node blocks]
};

extern template class StepAdjoint<float>;
extern template class StepAdjoint<double>;

}  // namespace pliant

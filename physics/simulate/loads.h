#pragma once

#include <string>
#include <vector>

#include "physics/mpm/adjoint/step_adjoint.h"
#include "physics/mpm/mpm.h"
#include "physics/simulate/interaction.h"
#include "physics/simulate/simulate.h"

namespace pliant {

/// A pin from the start on.  A row of nodes that stands still would put the clamp wherever the rows happen to lie; so
/// particles up to kClampReach cells outside its surface are tied to their places by springs as stiff as the material
/// is over a cell, which act through the splines and know nothing of rows, and nodes stand still only deeper inside,
/// where next to no motion arrives.  The reach makes up for what the springs give: it was set by the first frequency of
/// a cantilever against finite elements.
constexpr double kClampReach = 0.5, kClampSpring = 2, kClampDepth = 0.75;

/// Whether an instant lies in the substep of length dt that begins at t: in exactly one of them, although the ends of
/// neighbors agree to within rounding alone.
inline bool starts_within(double instant, double t, double dt) {
  const double share = (instant - t) / dt + 1e-6;
  return share >= 0 && share < 1;
}

/// Derivatives of a scalar L with respect to what a schedule is made of.
struct LoadsGradient {
  std::vector<Vec3d> vector;         ///< [interactions] by Interaction::vector
  std::vector<double> touched_mass;  ///< [interactions] by the touched mass
  std::vector<double> weight;        ///< [interactions] by Interaction::mass, as far as gravity pulls at it
  std::vector<double> max_force;     ///< [interactions] by the default largest force of a grab
  double body_mass = 0;
  Vec3d gravity = Vec3d::Zero();  ///< by SimulateOptions::gravity
  double damping_time = 0;
  std::vector<double> density;  ///< [objects] by the mean density of each, as far as any touch

  explicit LoadsGradient(size_t interactions)
      : vector(interactions, Vec3d::Zero()),
        touched_mass(interactions, 0.0),
        weight(interactions, 0.0),
        max_force(interactions, 0.0) {}
};

/// When it ends [s]: a grab or finger without a duration ends with its path, unless that is a single point.
double end_of(const Interaction& interaction);

/// Turns an interaction script into what acts during each substep.
template <class T>
class LoadSchedule {
 public:
  /// Marks the touched particles; `particles` are without the weights.  Throws Error{kUsage} when a force, impulse,
  /// grab, gust or weight touches none.
  LoadSchedule(const SimulateOptions& options, const BasicParticles<T>& particles,
               const std::vector<Interaction>& interactions);

  const std::vector<uint32_t>& bits() const { return bits_; }
  const std::vector<std::string>& warnings() const { return warnings_; }
  /// Force [N] that grab k does not exceed.
  double max_force(size_t k) const { return entries_[k].max_force; }
  const Interaction& operator[](size_t k) const { return entries_[k].interaction; }
  /// Replaces the path of grab or finger `k`, which ends with it if it has no duration.
  void set_path(size_t k, const std::vector<Interaction::PathPoint>& path);
  /// Whether some interaction blows on the surface of the body.
  bool has_wind() const;
  /// Whether a pin that reaches the body is active at time t.
  bool pinned(double t) const;
  /// Whether the gravity under which the body was captured is cancelled at time t: a pin holds it then and did so as it
  /// was captured, and none of its material flows.
  bool cancels_gravity(double t) const {
    return options_.rest_shape == RestShapeMode::kCaptured && !flows_ &&
           options_.held_as_captured.value_or(pinned(0)) && pinned(t);
  }
  /// Loads of the substep [t, t + dt]; a load that starts or ends inside it acts for its part of it.  `source` holds
  /// the numbers of the interactions.
  void at(double t, double dt, const Mpm<T>& solver, StepLoads<T>& loads) const;
  size_t size() const { return entries_.size(); }
  /// Speed [m/s] of the fastest point of a collider near the body during [t, t + dt].
  double collider_speed(double t, double dt) const;
  /// The way back of `at` for the recorded step [t, t + dt], from derivatives by its loads: adds to `gradient`, and to
  /// the particles at the start of the step what they did to the loads.
  void at_adjoint(double t, double dt, const TapeStep<T>& step, const StepLoadsGradient& by_loads,
                  StepAdjoint<T>& particles, LoadsGradient& gradient) const;
  /// Adds to by_mass [N], by the masses with weights, what those of the touched particles, of the body and of its
  /// objects did; returns the derivatives by the mass of each weight [interactions].
  std::vector<double> add_by_mass(const BasicParticles<T>& particles, const LoadsGradient& gradient,
                                  std::vector<T>& by_mass) const;
  /// Adds to by_young [m^2] what the stiffness of grabbed material did through the largest force.
  void add_by_young(const BasicParticles<T>& particles, const LoadsGradient& gradient, std::vector<T>& by_young) const;

 private:
  struct Entry {
    Interaction interaction;
    double end = 0;
    uint32_t bit = 0;
    double mass = 0;            // touched, with weights, kg
    double volume = 0;          // touched, at rest, m^3
    double length = 0;          // of a grab: that of a bar of what it touches, m
    double max_force = 0;       // of a grab, N
    std::vector<int> touched;   // only of what depends on their motion
    bool reaches_body = false;  // only of a pin
    bool sprung = false;        // only of a pin: held by springs behind its surface
  };

  void grab_adjoint(const Entry& entry, double t, double dt, const TapeStep<T>& step, const Vec3d& by_acceleration,
                    StepAdjoint<T>& particles, size_t number, LoadsGradient& gradient) const;
  void torque_adjoint(const Entry& entry, double part, const TapeStep<T>& step, const BodyLoadGradient& by_load,
                      StepAdjoint<T>& particles, Vec3d& by_torque) const;
  void add_grab(const Entry& entry, double t, double dt, const Mpm<T>& solver, StepLoads<T>& loads) const;
  void add_torque(const Entry& entry, double part, const Mpm<T>& solver, StepLoads<T>& loads) const;
  /// Numbers of the rows of gravity, pins, colliders and fingers that act at time t, each with 1 if it is on its way
  /// along its path then, else 0.
  std::vector<int> acting(double t) const;

  SimulateOptions options_;
  bool flows_ = false;  // the material of any particle
  double body_mass_ = 0, body_size_ = 0, cell_size_ = 0;
  Vec3d body_middle_ = Vec3d::Zero();     // at rest
  std::vector<double> density_, volume_;  // of each object
  std::vector<Entry> entries_;
  std::vector<uint32_t> bits_;
  std::vector<std::string> warnings_;
};

extern template class LoadSchedule<float>;
extern template class LoadSchedule<double>;

}  // namespace pliant

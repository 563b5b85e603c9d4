#pragma once

#include <optional>

#include "fitting/modal/modal_search.h"

namespace pliant {

/// Shapes of which the start of a roll-out is made up: x = X + sum a unit u, F = 1 + sum a unit G; v and C alike from
/// amplitudes of their own.
class StartShapes {
 public:
  /// The strongest modes of a motion.
  static StartShapes of_modes(const VibrationModes& modes, const ModalMotion& motion, const Particles& particles,
                              int most);
  /// Smooth displacements along each axis (smooth_field.h), at most `most` along each, and their velocities at `rate`
  /// [1/s]; `length` [m] over which they are alike, 0 = .35 of the box's diagonal.
  static StartShapes smooth(const Particles& particles, int most, double rate, double length = 0);

  size_t size() const { return shape_.size(); }
  /// Amplitudes of the displacement and the velocity of a modal motion at time t, by least squares in kinetic energy.
  std::vector<double> displacement_of(const VibrationModes& modes, const ModalMotion& motion,
                                      const Particles& particles, double t) const;
  std::vector<double> velocity_of(const VibrationModes& modes, const ModalMotion& motion, const Particles& particles,
                                  double t) const;
  /// The state with these amplitudes; those of velocities are of unit * rate.
  SimulationState state(const Particles& particles, std::span<const double> displacement,
                        std::span<const double> velocity) const;

 private:
  struct Shape {
    std::vector<Vec3f> u;  // [N] m
    std::vector<Mat3f> G;  // [N] of u
    double rate = 1;       // 1/s
  };
  std::vector<double> amplitudes_of(const SimulationState& state, const Particles& particles, bool velocity) const;

  std::vector<Shape> shape_;
};

}  // namespace pliant

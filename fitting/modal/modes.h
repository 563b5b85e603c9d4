#pragma once

#include <string>
#include <vector>

#include "physics/simulate/simulate.h"

namespace pliant {

struct ModesOptions {
  int most = 10;              ///< modes
  int snapshots = 32;         ///< of every free motion
  double highest = 12;        ///< modes above this multiple of the lowest frequency are left out
  double speed = 1e-4;        ///< of the free motions, share of the speed of sound: small, so that they are linear
  int most_substeps = 40000;  ///< of a free motion
  GridKind grid = GridKind::kAutomatic;
};

/// Small free vibrations of a held body, undamped: x = X + sum of amplitude * shape, F = 1 + sum of amplitude *
/// gradient.
struct VibrationModes {
  std::vector<double> omega;                 ///< [m] rad/s, ascending; proportional to sqrt(E) when all E change alike
  std::vector<double> decay;                 ///< [m] 1/s at which the transfers alone damp them
  std::vector<std::vector<Vec3d>> shape;     ///< [m][N] m, of unit modal mass: sum of mass |shape|^2 = 1
  std::vector<std::vector<Mat3d>> gradient;  ///< [m][N] of the shape
  double seconds = 0;

  size_t size() const { return omega.size(); }
  /// Of the same body with all E times `factor`.
  VibrationModes stiffer(double factor) const;
};

/// Rayleigh-Ritz on snapshots: the body swings freely from three translations and three rotations about its centre
/// until each has come back once, the principal components of what it passed through are the trial shapes (Sirovich
/// 1987), and their stiffness is the strain energy of their gradients.  Frequency and decay are then measured over the
/// first period of each mode.  Throws Error{kUsage} when nothing holds the body.
VibrationModes vibration_modes(const ModesOptions& options, const Particles& particles,
                               const std::vector<Interaction>& interactions);

}  // namespace pliant

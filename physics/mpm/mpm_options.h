#pragma once

namespace pliant {

/// Choices of the solver that change what it computes.
struct MpmOptions {
  /// s; 0 = APIC, which loses in every step, however short, the part of v and C that the grid cannot represent.
  /// Otherwise particles lose it within this time: new = grid + exp(-dt / flip_time) (old - grid's of the old), for v
  /// as in FLIP (Brackbill and Ruppel 1986) and for C alike; x and F move with the grid's velocity.
  double flip_time = 0;
  /// Stencils stay those of the rest positions (Total Lagrangian MPM, de Vaucorbeil, Nguyen and Hutchinson 2020): what
  /// is connected at rest stays connected however far it is stretched, and what is apart does not stick when it meets.
  /// The motion is that of the nodes, which get their velocity from the particles at the start only.  For elastic
  /// laws, without flip_time and sleep.
  bool lagrangian = false;
  /// Share of 2 mu with which such runs resist what the particles do not see of the nodes' displacement: the energy
  /// sum V (share mu / dx^2) w |u_i - u - (F - I) (X_i - X)|^2, which is zero for affine motion and unchanged by
  /// rotations.  Without it the nodes on which few particles depend could turn those about at no cost.
  double stabilization = 0.05;
  /// Whether parts of a Lagrangian run push each other apart where they meet, with StepLoads::object_friction.
  bool contact = true;
  /// m/s; 0 = off.  Blocks whose particles and nodes stay slower than this for `sleep_time` are not computed until
  /// something near them moves or a load changes.
  double sleep_speed = 0;
  double sleep_time = 0.1;  ///< s
};

}  // namespace pliant

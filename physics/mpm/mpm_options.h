#pragma once

namespace pliant {

/// Choices of the solver that change what it computes.
struct MpmOptions {
  /// s; 0 = APIC.  Otherwise particles keep of their velocity what the grid cannot represent, and lose it within this
  /// time: v = PIC + exp(-dt / flip_time) (FLIP - PIC), with APIC's C.  APIC alone loses it in every step, however
  /// short.
  double flip_time = 0;
  /// m/s; 0 = off.  Blocks whose particles and nodes stay slower than this for `sleep_time` are not computed until
  /// something near them moves or a load changes.
  double sleep_speed = 0;
  double sleep_time = 0.1;  ///< s
};

}  // namespace pliant

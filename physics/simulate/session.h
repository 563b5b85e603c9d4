#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "physics/simulate/simulator.h"

namespace pliant {

/// What a person may change while a body moves.
struct SessionSettings {
  double young_scale = 1;         ///< times Young's modulus of every particle, and the other moduli of its law
  double damping_time = 0;        ///< s, see SimulateOptions
  Vec3d gravity = {0, 0, -9.81};  ///< m/s^2; what differs from that of the options acts, even where a pin holds
  int max_substeps = 0;           ///< of a frame; 0 = that of SimulateOptions
};

/// A body that someone plays with: it advances frame by frame, and what acts on it may change between frames.  What was
/// done, done again at the same frames, gives the same motion bit for bit.
class Session {
 public:
  /// `held`: interactions that act from the start, such as pins and floor; numbers 0, 1, ...  Where the options do not
  /// say whether a pin held the body as it was captured, its pins and its laws do.
  Session(const SimulateOptions& options, Particles particles, const std::vector<Interaction>& held,
          SimulationState start);

  const SimulationState& state() const { return state_; }
  const Particles& particles() const { return particles_; }
  const SessionSettings& settings() const { return settings_; }
  /// Whether a pin held the body as it was captured, so that its gravity is cancelled while any pin holds it; false
  /// where its material flows.
  bool held_as_captured() const { return *options_.held_as_captured; }

  /// From the next frame on.
  void set(const SessionSettings& settings);
  /// Begins an interaction now, whatever its `start`; returns its number.  A pin is one that did not hold the body as
  /// it was captured, before the first frame too.  A grab without a path takes hold of what its
  /// region holds where that is now.  Throws Error{kUsage} as `simulate` does; the session is as it was then.
  int begin(Interaction interaction);
  /// Target of a grab, or place of a finger, at the end of the next frame [m]; what its path had planned after now is
  /// given up.
  void move(int number, const Vec3d& target);
  /// Lets go now.
  void end(int number);
  /// One frame.  Throws Error{kNumerical} where no time step is small enough; the state is that of the last frame.
  /// `glance` is called after every time step, and may ask for `state_within`.
  void advance(const std::function<void()>& glance = {});
  /// How far the frame under way has come: what can be shown while it takes long.  Frame and time are those before it.
  SimulationState state_within() const;

  /// Whether an interaction has not ended yet, by `end` or by its duration; an impulse ends with its frame.
  bool acts(int number) const;
  /// Mean force of an interaction in the last frame [N]; zero once it has ended.
  Vec3d force(int number) const;
  /// Everything that was begun, with times since the session began and whole paths.
  const std::vector<Interaction>& history() const { return history_; }
  int substeps() const { return substeps_; }  ///< of the last frame

 private:
  struct Active {
    int number;                   // in history_
    bool moved = false;           // in the next frame
    Vec3d force = Vec3d::Zero();  // N, mean of the last frame
  };

  Active* find(int number);
  std::vector<Interaction> acting() const;
  void rebuild();

  SimulateOptions options_;
  const Particles original_;
  Particles particles_;
  SimulationState state_;
  SessionSettings settings_;
  std::vector<Active> active_;
  std::vector<Interaction> history_;
  SimulateSummary summary_;
  std::unique_ptr<Simulator<float>> simulator_;  // null until it is needed again
  int substeps_ = 0;
};

}  // namespace pliant

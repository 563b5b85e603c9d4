#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>

#include "app/live/live_command.h"

namespace pliant {

/// What a step says beside the state.
struct LiveAnswer {
  int substeps = 0;
  double ms = 0;                                     ///< wall time
  std::vector<std::pair<int, Vec3d>> forces;         ///< mean in the frame of what acts, by number [N]
  std::vector<std::pair<int, Vec3d>> holds;          ///< where grabs that began took hold [m]
  std::string failed;                                ///< why the solver failed and was started anew; empty = it did not
  std::vector<std::pair<int, std::string>> refused;  ///< what could not begin, by number, and why; all else goes on
};

/// A body under commands, which survives what a person may do to it: where the solver fails, it goes on from the last
/// good frame without what was begun and with the settings of the body; where it fails there too, from that frame
/// without velocities, else from the start.  What cannot begin is refused and does no harm; the number of an
/// interaction is free again when its duration has passed.  The same commands at the same frames give the same motion
/// bit for bit.
class LiveSession {
 public:
  LiveSession(const SimulateOptions& options, const Particles& particles, const std::vector<Interaction>& held,
              const SimulationState& start);

  /// Commands in order, then a frame.  Throws Error{kNumerical} where not even the start can be simulated.  `glance`
  /// is called after every time step, and may ask for `state_within`, or throw Error{kInterrupted}, which ends the
  /// session.
  LiveAnswer step(std::span<const LiveCommand> commands, const std::function<void()>& glance = {});

  const SimulationState& state() const { return session_->state(); }
  std::optional<SimulationState> state_within() const;  ///< of the frame under way, see Session; none if not finite
  const Particles& particles() const { return particles_; }
  int held_at_start() const { return held_at_start_; }
  int frames() const { return frames_; }  ///< since the start, failures included
  double time() const { return frames_ / options_.fps; }
  /// Commands so far with the frame before which they took effect: [[frame, command], ...].
  const nlohmann::json& history() const { return history_; }

 private:
  struct Active {
    Active() = default;
    explicit Active(int number) : in_session(number) {}
    int in_session = 0;
    bool follows = false;       // a path that `move` goes on with
    std::optional<Vec3d> hold;  // of a grab, m
  };

  int max_substeps(double young_scale) const;
  void open(const SimulationState& start);
  void begin(const LiveCommand& command, LiveAnswer& answer);
  void apply(const LiveCommand& command, LiveAnswer& answer);
  void forget_ended();
  void recover(const SimulationState& good, const std::function<void()>& glance);

  SimulateOptions options_;
  Particles particles_;
  SimulationState first_;
  std::map<int, Interaction> held_;  // that have not ended
  int held_at_start_ = 0;
  std::map<int, Active> active_;
  std::unique_ptr<Session> session_;
  nlohmann::json history_ = nlohmann::json::array();
  int frames_ = 0;
};

}  // namespace pliant

#pragma once

#include "app/live/live_session.h"
#include "app/simulate/moving_scene.h"
#include "app/simulate/session_body.h"

namespace pliant {

/// A simulated run to play with.
struct LiveScene {
  Scene scene;
  MovingScene moving;
  SessionSetup setup;
  std::string object;        ///< its name
  nlohmann::json simulated;  ///< see record_of_motion

  InteractionFrame frame() const { return {scene.metres_per_unit, scene.up}; }
  size_t drivers() const { return moving.particles.driving_position.size(); }
};

/// Throws Error{kUsage} naming `what` where the object cannot be played with.
LiveScene load_live_scene(const RunDirectory& run, const Scene& scene, const std::string& what);

/// What a session begins with: the body of a level of driving particles in the state of a frame of the motion.
struct LiveStart {
  size_t drivers = 0;    ///< driving particles of the level; 0 = as many as it has
  int clustered_to = 0;  ///< number that with_drivers made them for; 0 = those of the simulation
  size_t frame = 0;
};

struct LiveBody {
  ParticleFile level;
  SimulatedBody body;
  SimulationState state;

  /// Throws Error{kInput} naming `where` and the field where the scene has no such level or frame.
  LiveBody(const LiveScene& scene, const LiveStart& start, const std::string& where);
};

}  // namespace pliant

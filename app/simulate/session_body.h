#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/run/run_directory.h"
#include "app/simulate/driver_level.h"
#include "app/simulate/simulated_body.h"

namespace pliant {

/// What someone needs to go on playing with a simulated object: what it is made of and what holds it.
struct SessionSetup {
  std::string refused;      ///< why it cannot be, as a sentence; empty = it can
  SimulateOptions options;  ///< fps: of a session's frames
  ElasticSamples solid;
  Material material;
  bool remembers = false;         ///< the law has a memory: a session starts with the first frame, of which it is known
  std::vector<Interaction> held;  ///< pins, floor, and what of the script stands or hangs there to the end
  /// What of the script (interactions.json) is part of a session, to its end: [{row, held: its number among `held`;
  /// null = gravity}].
  nlohmann::json script = nlohmann::json::array();
  double height = 0;  ///< of the object, m
};

/// The material at solid samples in `positions`; `session`: what the simulation's summary says of it.
ElasticSamples simulated_material(const RunDirectory& run, const nlohmann::json& session,
                                  const std::vector<Vec3f>& positions);

/// What `simulate` made the motion from (see record_of), but for how long: {seed, options, scene, found, inputs}.
nlohmann::json record_of_motion(const RunDirectory& run);

/// Of the simulation that is in the run directory.  What the script does for a time, as pushes and pins that end, is
/// not part of a session.  Throws Error{kUsage} where its material or scale has since been replaced.
SessionSetup session_setup(const RunDirectory& run, const Scene& scene, const MovingScene& moving);

/// The state of a level's particles in frame `f` of the motion: velocities are central differences of its frames.
/// `memory`: of that frame, where the law of the particles has one.
SimulationState state_of(const std::vector<DriverFrame>& motion, size_t f, double fps, double metres_per_unit,
                         const Particles& particles, const std::optional<TrajectoryFile::Memory>& memory);

}  // namespace pliant

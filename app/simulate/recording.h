#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "app/run/run_directory.h"
#include "gaussians/io/scene/scene.h"
#include "physics/simulate/session.h"

namespace pliant {

/// recording.json, which a clip.html saves: what a person did to the object.  Times and frames count from its begin.
struct Recording {
  struct Change {
    int frame = 0;
    SessionSettings settings;
  };
  struct Release {
    int frame = 0, held = 0;  ///< number of a pin or floor that was let go
  };
  size_t drivers = 0;      ///< driving particles of the level that moved
  int clustered_to = 0;    ///< number that with_drivers made them for; 0 = those of the simulation
  size_t start_frame = 0;  ///< of the clip
  int frames = 0;          ///< of the session
  double fps = 60;
  std::vector<Change> settings;
  std::vector<Interaction> interactions;
  std::vector<Release> released;
};

/// Throws Error{kInput} naming the file and the field.
Recording parse_recording(const std::string& text, const Scene& scene, const std::string& file);

/// Does it again with the native solver and writes the motion of the level's particles to recording.h5 in the object's
/// folder.
nlohmann::json replay_recording(const Context& context, RunDirectory& run, const Scene& scene,
                                const std::filesystem::path& file);

}  // namespace pliant

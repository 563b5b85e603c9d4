#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "app/live/live_scene.h"
#include "app/run/run_directory.h"

namespace pliant {

/// recording.json, which a clip.html or `pliant view` saves: what a person did to the object.  Times and frames count
/// from its begin.  The file of a page (version 1) has interactions, which a person can read and change; that of `view`
/// (version 2) has the commands themselves, which give the same motion bit for bit.
struct Recording {
  struct Change {
    int frame = 0;
    SessionSettings settings;
  };
  struct Release {
    int frame = 0, held = 0;  ///< number of a pin or floor that was let go
  };
  LiveStart start;
  int frames = 0;  ///< of the session
  int held = -1;   ///< interactions that act from the start, which have the first numbers; -1 = not told
  double fps = 60;
  std::vector<Change> settings;
  std::vector<Interaction> interactions;
  std::vector<Release> released;
  std::vector<std::pair<int, LiveCommand>> commands;  ///< and the frame before which they take effect; version 2
};

/// Throws Error{kInput} naming the file and the field.
Recording parse_recording(const std::string& text, const Scene& scene, const std::string& file);

/// A file of version 2: what was done to `session` since it began.
nlohmann::json recording_json(const LiveStart& start, double fps, const LiveSession& session);

/// Does it again with the native solver and writes the motion of the level's particles to recording.h5, and these to
/// recording_particles.h5, in the object's folder.
nlohmann::json replay_recording(const Context& context, RunDirectory& run, const Scene& scene,
                                const std::filesystem::path& file);

}  // namespace pliant

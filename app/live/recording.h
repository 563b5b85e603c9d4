#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
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
  int held = -1;  ///< interactions that act from the start, which have the first numbers; -1 = not told (earlier files)
  double fps = 60;
  std::string object;        ///< name; empty = not told
  nlohmann::json simulated;  ///< see record_of_motion; null = not told
  std::vector<Change> settings;
  std::vector<Interaction> interactions;
  std::vector<Release> released;
  std::vector<std::pair<int, LiveCommand>> commands;  ///< and the frame before which they take effect; version 2
};

/// Throws Error{kInput} naming the file and the field.
Recording parse_recording(const std::string& text, const Scene& scene, const std::string& file);

/// The text of a file of version 2, one command a line.  It is made of what is new alone: a session may last for hours.
class RecordingText {
 public:
  RecordingText(const LiveScene& scene, const LiveStart& start);
  /// What was done to `session`, the same one each time, since it began.
  std::string of(const LiveSession& session);

 private:
  nlohmann::json head_;
  std::string rows_;
  size_t count_ = 0;
};

/// Does it again with the native solver and writes the motion of the level's particles to recording.h5, and these to
/// recording_particles.h5, in the object's folder; the provenance of the former has the hash of "object", its
/// object.ply.  Another object than the recording names is refused, and one that was extracted since it was simulated;
/// where it was simulated otherwise since, that is said.  `duration` [s]: of a longer recording only the beginning.
nlohmann::json replay_recording(const Context& context, RunDirectory& run, const Scene& scene,
                                const std::filesystem::path& file, std::optional<double> duration = {});

}  // namespace pliant

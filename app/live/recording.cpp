#include "app/live/recording.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "app/import/interactions.h"
#include "app/run/attach_scene.h"
#include "app/simulate/session_body.h"
#include "app/store/particles.h"
#include "app/store/trajectory.h"
#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"
#include "physics/mpm/whole_deformation.h"

namespace pliant {
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr int kMostFrames = 1'000'000;
constexpr double kMostMemory = 8e9;  // bytes of all frames of a replay

const json& required(const json& row, const char* field, const std::string& file) {
  if (!row.is_object() || !row.contains(field))
    throw input_error(file, field, "is missing", "save the recording again");
  return row[field];
}

double number(const json& row, const char* field, const std::string& file, double low, double high) {
  const json& value = required(row, field, file);
  if (!value.is_number() || !(value.get<double>() >= low && value.get<double>() <= high))
    throw input_error(file, field, "is " + value.dump(), fmt::format("give a number from {:g} to {:g}", low, high));
  return value;
}

const json& rows_of(const json& all, const char* field, const std::string& file) {
  static const json none = json::array();
  if (!all.contains(field)) return none;
  if (!all[field].is_array()) throw input_error(file, field, "is not an array", "save the recording again");
  return all[field];
}

/// What happens between two frames.
void apply(const Recording& recording, int frame, Session& session, std::vector<int>& number) {
  for (const Recording::Release& release : recording.released)
    if (release.frame == frame) session.end(release.held);
  for (const Recording::Change& change : recording.settings)
    if (change.frame == frame) session.set(change.settings);
  for (size_t k = 0; k < recording.interactions.size(); ++k) {
    const Interaction& it = recording.interactions[k];
    const auto at = [&](double time) { return static_cast<int>(std::lround(time * recording.fps)) == frame; };
    if (number[k] >= 0 && std::isfinite(it.end()) && at(it.end())) session.end(number[k]);
    if (number[k] < 0 && at(it.start)) number[k] = session.begin(it);
  }
}

/// Numbers of interactions count from those that act from the start, which the script of the run may have changed.
/// Where it is not told how many these were, there were no more than the least number that was begun.  What is let go
/// is one of them.
void check_held(const Recording& recording, size_t held, const std::string& file) {
  const auto other = [&](int there) {
    return input_error(file, "held",
                       fmt::format("counts {} interactions that act from the start, here are {}", there, held),
                       "simulate with the interactions that acted when it was recorded");
  };
  if (recording.held >= 0 && recording.held != static_cast<int>(held)) throw other(recording.held);
  for (const Recording::Release& release : recording.released)
    if (release.held >= static_cast<int>(held))
      throw input_error(
          file, "unpinned",
          fmt::format("lets go of interaction {} of those that act from the start, here are {}", release.held, held),
          "simulate with the interactions that acted when it was recorded");
  if (recording.held >= 0) return;
  for (const auto& [frame, command] : recording.commands)
    if (command.kind == LiveCommand::Kind::kBegin && command.number < static_cast<int>(held))
      throw other(command.number);
}

/// Throws where another object was moved, and says where this one was simulated otherwise.
void check_object(const Context& context, const Recording& recording, const LiveScene& live, const std::string& file) {
  if (!recording.simulated.is_object()) return;
  // An object that was only renamed has the same splats; where they did not count, the same particles.
  const json::json_pointer splats("/inputs/object"), particles("/inputs/particles");
  const auto in_both = [&](const json::json_pointer& input) {
    return recording.simulated.contains(input) && live.simulated.contains(input);
  };
  const json::json_pointer& told = in_both(splats) ? splats : particles;
  const bool same = in_both(told) && recording.simulated[told] == live.simulated[told];
  if (!recording.object.empty() && recording.object != live.object && !same)
    throw input_error(file, "object", fmt::format("is '{}', here is '{}'", recording.object, live.object),
                      "extract and simulate the object that was moved");
  const std::string difference = first_difference(recording.simulated, live.simulated);
  if (!difference.empty())
    context.progress.warn("simulate: " + file + " was recorded on another motion: " + difference);
}

/// Throws where all frames of a replay would need too much memory.
void check_memory(const Recording& recording, size_t drivers, const std::string& file) {
  constexpr size_t kBytes = 2 * sizeof(Vec3f) + sizeof(Mat3f);  // of a particle in a frame
  const double bytes = 1.0 * kBytes * static_cast<double>(drivers) * recording.frames;
  if (bytes > kMostMemory)
    throw input_error(file, "frames",
                      fmt::format("are {} of {} driving particles, which would need {:.0f} GB of memory",
                                  recording.frames, drivers, bytes / 1e9),
                      fmt::format("shorten the replay with --duration X of at most {:.0f} s, or use fewer driving "
                                  "particles",
                                  std::floor(kMostMemory / bytes * recording.frames / recording.fps)));
}

/// Leaves out what follows after so many seconds; a recording that is not longer stays, which is said.
void shorten(const Context& context, Recording& recording, double duration, const std::string& file) {
  const double seconds = recording.frames / recording.fps;
  if (duration > seconds)
    context.progress.warn(
        fmt::format("simulate: {} ends after {:.2f} s, before --duration {:g}", file, seconds, duration));
  recording.frames = std::min(recording.frames, std::max(1, static_cast<int>(std::lround(duration * recording.fps))));
}

}  // namespace

Recording parse_recording(const std::string& text, const Scene& scene, const std::string& file) {
  const json all = json::parse(text, nullptr, false);
  if (all.is_discarded() || required(all, "format", file) != "pliant-recording")
    throw input_error(file, "format", "is not that of a recording",
                      "give a recording.json that a clip.html or `pliant view` has saved");
  const double version = number(all, "version", file, 1, INFINITY);
  if (version != 1 && version != 2)
    throw input_error(file, "version", "is " + all["version"].dump(), "use a later version of Pliant");
  Recording out;
  out.start.drivers = static_cast<size_t>(number(all, "drivers", file, 1, 1e9));
  out.start.clustered_to = static_cast<int>(number(all, "clustered_to", file, 0, 1e9));
  out.start.frame = static_cast<size_t>(number(all, "start_frame", file, 0, 1e9));
  out.frames = static_cast<int>(number(all, "frames", file, 0, kMostFrames));
  out.fps = number(all, "solver_fps", file, 1, 1000);
  const InteractionFrame frame{scene.metres_per_unit, scene.up};
  if (all.contains("held")) out.held = static_cast<int>(number(all, "held", file, 0, 1e6));
  if (all.contains("object") && !all["object"].is_string())
    throw input_error(file, "object", "is " + all["object"].dump().substr(0, 60), "give a name");
  if (all.contains("simulated") && !all["simulated"].is_object())
    throw input_error(file, "simulated", "is " + all["simulated"].dump().substr(0, 60), "leave it out");
  out.object = all.value("object", "");
  out.simulated = all.value("simulated", json());
  if (version == 2) {
    required(all, "commands", file);
    for (const json& row : rows_of(all, "commands", file)) {
      if (!row.is_array() || row.size() != 2 || !row[0].is_number_integer() || !(row[0] >= 0 && row[0] <= out.frames))
        throw input_error(file, "commands", "has " + row.dump().substr(0, 60), "give [frame, command]");
      out.commands.emplace_back(row[0].get<int>(), parse_command(row[1], frame, file));
      if (out.commands.size() > 1 && out.commands.back().first < out.commands[out.commands.size() - 2].first)
        throw input_error(file, "commands", "go back in time", "give them in the order of their frames");
    }
    return out;
  }
  for (const json& row : rows_of(all, "settings", file)) {
    Recording::Change change;
    change.frame = static_cast<int>(number(row, "frame", file, 0, kMostFrames));
    change.settings.young_scale = number(row, "young_scale", file, 1e-6, 1e6);
    change.settings.damping_time = number(row, "damping_time", file, 0, 1e9);
    const json& gravity = required(row, "gravity", file);
    if (!gravity.is_array() || gravity.size() != 3)
      throw input_error(file, "gravity", "is " + gravity.dump(), "give three numbers");
    for (int a = 0; a < 3; ++a) {
      if (!gravity[a].is_number()) throw input_error(file, "gravity", "is " + gravity.dump(), "give three numbers");
      change.settings.gravity[a] = gravity[a];
    }
    out.settings.push_back(change);
  }
  out.interactions = parse_interactions(rows_of(all, "interactions", file).dump(), frame, file);
  for (const json& row : rows_of(all, "unpinned", file))
    out.released.push_back({static_cast<int>(number(row, "frame", file, 0, kMostFrames)),
                            static_cast<int>(number(row, "held", file, 0, 1e6))});
  return out;
}

RecordingText::RecordingText(const LiveScene& scene, const LiveStart& start)
    : head_({{"format", "pliant-recording"},
             {"version", 2},
             {"drivers", start.drivers},
             {"clustered_to", start.clustered_to},
             {"start_frame", start.frame},
             {"solver_fps", scene.setup.options.fps},
             {"object", scene.object},
             {"simulated", scene.simulated}}) {}

std::string RecordingText::of(const LiveSession& session) {
  for (; count_ < session.history().size(); ++count_)
    rows_ += (count_ > 0 ? ",\n" : "\n") + session.history()[count_].dump();
  head_["frames"] = session.frames();
  head_["held"] = session.held_at_start();
  std::string out = head_.dump();
  out.pop_back();  // its brace
  return out + ",\n\"commands\": [" + rows_ + "\n]}\n";
}

json replay_recording(const Context& context, RunDirectory& run, const Scene& scene, const fs::path& file,
                      std::optional<double> duration) {
  Recording recording = parse_recording(read_text(file), scene, file.string());
  if (duration) shorten(context, recording, *duration, file.string());
  const std::string folder = object_folder(run);
  run.hold();
  LiveScene live = load_live_scene(run, scene, "--recording");
  live.setup.options.fps = recording.fps;
  check_object(context, recording, live, file.string());
  check_held(recording, live.setup.held.size(), file.string());
  const LiveBody start(live, recording.start, file.string());
  check_memory(recording, start.level.driving_position.size(), file.string());

  TrajectoryFile out;
  out.object = live.moving.trajectory.object;
  out.fps = recording.fps;
  out.metres_per_unit = scene.metres_per_unit;
  out.cell_size = start.level.cell_size;
  out.up = scene.up;
  const float units = static_cast<float>(1 / scene.metres_per_unit);
  int64_t steps = 0;
  const auto keep = [&](const SimulationState& state, int frame) {
    TrajectoryFile::Frame kept{frame / recording.fps, steps, {}, state.v, whole_deformation(state)};
    for (const Vec3f& x : state.x) kept.position.push_back(units * x);
    out.frames.push_back(std::move(kept));
  };
  const auto replay = [&](auto& session, auto&& advance) {
    keep(session.state(), 0);
    context.progress.begin("recording", recording.frames);
    for (int f = 0; f < recording.frames; ++f) {
      if (context.interrupted())
        throw Error(Failure::kInterrupted, "simulate", "", "interrupted", "run the same command again");
      steps += advance(f);
      keep(session.state(), f + 1);
      context.progress.done(f + 1);
    }
    context.progress.end();
  };
  const SimulateOptions& options = live.setup.options;
  if (recording.commands.empty()) {
    Session session(options, start.body.particles, live.setup.held, start.state);
    std::vector<int> number(recording.interactions.size(), -1);
    replay(session, [&](int f) {
      apply(recording, f, session, number);
      session.advance();
      return session.substeps();
    });
  } else {
    LiveSession session(options, start.body.particles, live.setup.held, start.state);
    auto next = recording.commands.begin();
    replay(session, [&](int f) {
      std::vector<LiveCommand> now;
      for (; next != recording.commands.end() && next->first <= f; ++next) now.push_back(next->second);
      return session.step(now).substeps;
    });
  }
  const fs::path target = run / (folder + "/recording.h5");
  const std::string provenance =
      json({{"recording", hash_of_input(file)}, {"object", hash_of_input(run / (folder + "/object.ply"))}}).dump();
  // No motion lies beside particles of another one, whatever fails in between.
  fs::remove(target);
  write_particles(run / (folder + "/recording_particles.h5"), start.level, provenance);
  write_trajectory(target, out, provenance);
  context.progress.say(fmt::format("simulate: {} frames of {} driving particles in {}", recording.frames,
                                   recording.start.drivers, target.string()));
  return {{"file", target.string()}, {"frames", recording.frames}, {"drivers", recording.start.drivers}};
}

}  // namespace pliant

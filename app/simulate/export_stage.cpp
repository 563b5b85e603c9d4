#include "app/simulate/export_stage.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <set>

#include "app/import/material_fields.h"
#include "app/import/physgaussian_output.h"
#include "app/run/attach_scene.h"
#include "app/simulate/moving_scene.h"
#include "app/simulate/session_body.h"
#include "app/store/particles.h"
#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/splats/ply.h"

namespace pliant {
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr const char* kRecord = "sequence.json";

bool is_frame(const std::string& name) {
  return name.rfind("frame_", 0) == 0 && name.find('/') == std::string::npos && fs::path(name).extension() == ".ply";
}

/// Removes what a killed export had not finished.
void remove_unfinished(const fs::path& folder) {
  std::vector<fs::path> unfinished;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (name[0] == '.' && name.find(".tmp") != std::string::npos && is_frame(name.substr(1)))
      unfinished.push_back(entry);
  }
  for (const fs::path& file : unfinished) fs::remove(file);
}

/// Makes `folder` ready for the sequence that `record` describes.  It must be new, empty, or hold (part of) the same
/// sequence; one that differs is removed when `overwrite` is given.  Files of other kinds are never touched.
void claim_folder(const fs::path& folder, const json& record, bool overwrite) {
  if (fs::exists(folder) && !fs::is_directory(folder))
    throw usage_error("--ply-sequence", folder.string(), "is a file", "give a folder");
  std::error_code failed;
  fs::create_directories(folder, failed);
  if (failed) throw usage_error("--ply-sequence", folder.string(), failed.message(), "give a writable folder");

  std::set<std::string> replaced;
  if (fs::exists(folder / kRecord)) {
    const json before = json::parse(read_text(folder / kRecord), nullptr, false);
    if (!before.is_object() || !before.contains("frames") || !before["frames"].is_array())
      throw input_error((folder / kRecord).string(), "frames", "is not a record of a sequence", "give another folder");
    remove_unfinished(folder);
    const std::string changed = first_difference(before, record, "value");
    if (changed.empty()) return;
    if (!overwrite)
      throw usage_error(folder.string(), "", "contains another sequence: " + changed,
                        "give --overwrite to replace it, or another folder");
    for (const json& frame : before["frames"]) {
      const std::string name = frame.is_object() ? frame.value("file", "") : "";
      if (is_frame(name)) replaced.insert(name);
    }
  }
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (name != kRecord && !replaced.count(name))
      throw usage_error("--ply-sequence", folder.string(), "holds '" + name + "', which is not part of a sequence",
                        "give a new or an empty folder");
  }
  for (const std::string& name : replaced) fs::remove(folder / name);
  write_text(folder / kRecord, record.dump(2) + "\n");
}

InputFiles exported_files(const RunDirectory& run, const ExportStage& stage) {
  if (!stage.recorded) return moving_scene_files(run);
  InputFiles files = recorded_scene_files(run);
  check_recorded_object(files);
  return files;
}

/// The files that PhysGaussian writes of its particles, in the space of the simulation.
json export_physgaussian(const Context& context, const RunDirectory& run, const ExportStage& stage) {
  const InputFiles inputs = exported_files(run, stage);
  const fs::path folder = stage.physgaussian_output;
  if (fs::exists(folder) && !(fs::is_directory(folder) && (fs::is_empty(folder) || context.overwrite)))
    throw usage_error("--physgaussian-output", folder.string(), "exists",
                      "give a new or an empty folder, or --overwrite");
  const json space = run.summary("simulate", "run `pliant simulate` first")["space"];
  SimulationSpace simulated;
  simulated.scale = space["scale"];
  for (int i = 0; i < 3; ++i) {
    simulated.offset[i] = space["offset"][i];
    for (int k = 0; k < 3; ++k) simulated.R(i, k) = space["rotation"][i][k];
  }
  const TrajectoryFile trajectory = read_trajectory(inputs.at("trajectory"));
  write_physgaussian_output(folder, {}, trajectory, simulated);
  remove_physgaussian_frames(folder, trajectory.frames.size());
  context.progress.say(fmt::format("wrote {} frames of {} particles to {}", trajectory.frames.size(),
                                   trajectory.frames[0].position.size(), (folder / "simulation_ply").string()));
  return {{"folder", folder.string()}, {"frames", trajectory.frames.size()}};
}

/// The material that was simulated, at the solid samples.
json export_material(const Context& context, const RunDirectory& run, const Scene& scene, const ExportStage& stage) {
  const fs::path file = stage.material;
  if (!is_material_field(file))
    throw usage_error("--material", file.string(), "is neither .npz nor .ply", "end the name with .npz or .ply");
  if (fs::exists(file) && !context.overwrite)
    throw usage_error("--material", file.string(), "exists", "give another name, or --overwrite");
  check_simulated_with(run, scene);
  const json session = run.summary("simulate", "run `pliant simulate` first").value("session", json::object());
  if (!session.contains("uniform") && !session.contains("material_file"))
    throw usage_error(run.path().string(), "simulate",
                      "was run by an earlier version, which did not record its material",
                      "run `pliant simulate` again");
  ParticleFile particles = read_particles(run / (object_folder(run) + "/particles.h5"));
  ElasticSamples solid = simulated_material(run, session, particles.solid_position);
  MaterialFile material;
  material.young = std::move(solid.young);
  material.poisson = std::move(solid.poisson);
  material.density = std::move(solid.density);
  material.position = std::move(particles.solid_position);
  write_material_field(file, material);
  context.progress.say(fmt::format("wrote the material at {} points to {}", material.young.size(), file.string()));
  return {{"file", file.string()}, {"points", material.young.size()}};
}

}  // namespace

json run_export(const Context& context, RunDirectory& run, const Scene& scene, const ExportStage& stage) {
  if (stage.ply_sequence.empty() + stage.physgaussian_output.empty() + stage.material.empty() != 2)
    throw usage_error("export", "", "needs exactly one output",
                      "give --ply-sequence FOLDER, --physgaussian-output FOLDER, --material FILE or --html FILE");
  if (!stage.material.empty()) return export_material(context, run, scene, stage);
  if (!stage.physgaussian_output.empty()) return export_physgaussian(context, run, stage);
  const InputFiles inputs = exported_files(run, stage);
  const MovingScene moving = load_moving_scene(inputs, scene);
  const TrajectoryFile& trajectory = moving.trajectory;

  json record = {{"pliant", PLIANT_VERSION},
                 {"content", stage.object_only ? "object" : "object and background"},
                 {"every", stage.every},
                 {"fps", trajectory.fps / stage.every},
                 {"metres_per_unit", trajectory.metres_per_unit},
                 {"up", {scene.up[0], scene.up[1], scene.up[2]}},
                 {"antialiased", moving.antialiased},
                 {"z_is_up", scene.report.z_is_up},
                 {"inputs", json::object()},
                 {"frames", json::array()}};
  if (stage.recorded) record["recorded"] = true;
  for (const auto& [role, file] : inputs) record["inputs"][role] = hash_of_input(file);
  std::vector<const TrajectoryFile::Frame*> frames;
  for (size_t f = 0; f < trajectory.frames.size(); f += stage.every) {
    record["frames"].push_back(
        {{"file", fmt::format("frame_{:04d}.ply", frames.size())}, {"time", trajectory.frames[f].time}});
    frames.push_back(&trajectory.frames[f]);
  }
  const fs::path folder = stage.ply_sequence;
  claim_folder(folder, record, context.overwrite);

  // Frames are renamed into place when whole, so that those which are there need not be written again.
  int written = 0;
  context.progress.begin("export", static_cast<int>(frames.size()));
  for (size_t k = 0; k < frames.size(); ++k) {
    if (context.interrupted())
      throw Error(Failure::kInterrupted, "export", "", "interrupted", "run the same command to continue");
    const fs::path file = folder / record["frames"][k]["file"].get<std::string>();
    if (!fs::exists(file)) {
      write_ply(file, stage.object_only ? moving.object_at(*frames[k]) : moving.all_at(*frames[k]), moving.antialiased,
                scene.report.z_is_up);
      ++written;
    }
    context.progress.done(static_cast<int>(k) + 1);
  }
  context.progress.end();
  context.progress.say(fmt::format("wrote {} of {} frames to {}", written, frames.size(), folder.string()));
  return {{"folder", folder.string()},
          {"frames", frames.size()},
          {"written", written},
          {"fps", record["fps"]},
          {"gaussians", moving.object.size() + (stage.object_only ? 0 : moving.background.size())}};
}

OptionTable options_of(ExportStage& stage) {
  return {"export",
          {{.name = "ply-sequence",
            .field = &stage.ply_sequence,
            .help = "Folder for frame_0000.ply and so on, one file per frame",
            .value = "DIR"},
           {.name = "physgaussian-output",
            .field = &stage.physgaussian_output,
            .help = "Folder for h5 and ply files as PhysGaussian writes them",
            .value = "DIR"},
           {.name = "material",
            .field = &stage.material,
            .help = "File for E, nu and rho of the object: .npz as VoMP writes, or .ply with x, y, z, density, E, nu",
            .value = "FILE"},
           {.name = "every",
            .field = &stage.every,
            .help = "Write every Nth frame of the trajectory; files are numbered without gaps",
            .low = 1,
            .high = 1e6},
           {.name = "recorded",
            .field = &stage.recorded,
            .help = "Write what was done by hand, recording.h5 of `simulate --recording`, not the simulated motion"},
           {.name = "object-only", .field = &stage.object_only, .help = "Leave the background out"}}};
}

}  // namespace pliant

#include "app/run/attach_scene.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "app/run/physdreamer_scene.h"
#include "app/run/scene_parts.h"
#include "gaussians/base/error.h"
#include "gaussians/io/files/utf8.h"

namespace pliant {
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

/// What a run directory records of the scene at `place`: a trained scene within the directory moves with it.
json recorded(const RunDirectory& run, const fs::path& place, const LoadOptions& options) {
  const fs::path within = place.lexically_relative(fs::weakly_canonical(run.path()));
  const bool inside = !within.empty() && *within.begin() != ".." && within != ".";
  json record = {{"source", (inside ? within : place).string()}};
  if (options.orbit_views) record["orbit_views"] = *options.orbit_views;
  if (options.level) record["level"] = *options.level;
  if (options.up) record["up"] = {options.up->x(), options.up->y(), options.up->z()};
  if (options.metres_per_unit) record["metres_per_unit"] = *options.metres_per_unit;
  if (options.object_height > 0) record["object_height"] = options.object_height;
  if (options.antialiased) record["antialiased"] = true;
  return record;
}

/// Refuses a name that a record in JSON cannot hold.
void check_name(const std::string& name) {
  const std::string shown = as_utf8(name);
  if (shown != name) throw input_error(shown, "", "its name is not UTF-8", "rename it");
}

/// Refuses a scene whose files or photographs have such names.
void check_names(const Scene& scene) {
  for (const fs::path& file : scene.report.files) check_name(file.string());
  for (const Camera& camera : scene.cameras) check_name(camera.name);
}

Scene load_any_scene(const fs::path& source, const LoadOptions& options) {
  Scene scene = load_scene(source, options);
  if (const auto folder = physdreamer_folder(scene)) take_physdreamer_settings(scene, *folder);
  return scene;
}

/// Whether the objects of a run were found in just the splats of this scene.
bool has_splats_of(const RunDirectory& run, const Scene& scene) {
  const json segment = run.last_record("segment");
  if (segment.is_null()) return false;
  StageKey key;
  key.inputs = record_of({ScenePart::kSplats}, scene).files;
  return splats_of(segment.value("inputs", json::object())) == record_of(key, 0)["inputs"];
}

/// Keeps the up direction of a run that was made with the mean of the cameras' picture-up.
void keep_mean_up(const RunDirectory& run, Scene& scene, const LoadOptions& options) {
  const json segment = run.last_record("segment");
  const json up = segment.is_object() ? segment.value("scene", json::object()).value("up", json()) : json();
  if (options.up || scene.settings.up || scene.cameras_are_orbit || !up.is_array() || up.size() != 3) return;
  const Eigen::Vector3d recorded(up[0], up[1], up[2]);
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Camera& camera : scene.cameras) mean -= camera.cam_from_world.linear().row(1).transpose();
  if ((recorded - mean.normalized()).norm() > 1e-9 || recorded == scene.up) return;
  scene.up = recorded;
  scene.up_source = "mean up of the cameras, with which this run was made";
}

}  // namespace

fs::path place_of_scene(const fs::path& source) {
  const fs::path place = fs::absolute(source);
  std::error_code none;
  if (fs::is_directory(place, none) || !place.has_filename()) return fs::weakly_canonical(place);
  return fs::weakly_canonical(place.parent_path()) / place.filename();
}

fs::path recorded_place(const RunDirectory& run) {
  const fs::path source = run.scene().value("source", std::string()), folder = fs::weakly_canonical(run.path());
  // A full path to a trained scene in the run directory is that of the folder before it was moved or copied.
  std::error_code none;
  const bool elsewhere = !fs::exists(source, none) || is_run_directory(source.parent_path());
  if (source.is_absolute() && source.filename() == "scene" && elsewhere &&
      fs::exists(folder / "scene/scene.json", none))
    return folder / "scene";
  return folder / source;
}

bool is_recorded_scene(const RunDirectory& run, const fs::path& source) {
  if (!run.scene().is_object()) return false;
  const fs::path known = recorded_place(run);
  return known == place_of_scene(source) || known == fs::weakly_canonical(source);
}

LoadOptions recorded_options(const RunDirectory& run) {
  LoadOptions options;
  const json& record = run.scene();
  if (!record.is_object()) return options;
  if (record.contains("orbit_views")) options.orbit_views = record["orbit_views"].get<int>();
  if (record.contains("level")) options.level = record["level"].get<int>();
  if (record.contains("up")) options.up = Eigen::Vector3d(record["up"][0], record["up"][1], record["up"][2]);
  if (record.contains("metres_per_unit")) options.metres_per_unit = record["metres_per_unit"].get<double>();
  options.object_height = record.value("object_height", 0.0);
  options.antialiased = record.value("antialiased", false);
  return options;
}

Scene attach_scene(const Context& context, RunDirectory& run, const fs::path& source, const LoadOptions& options) {
  if (is_run_directory(source)) {
    const RunDirectory given = RunDirectory::open(source);
    throw usage_error(source.string(), "", "is a run directory, not a scene",
                      given.scene().is_object()
                          ? "give its scene, " + recorded_place(given).string() + ", with --out " + source.string()
                          : std::string("give a scene"));
  }
  check_name(run.path().string());
  const bool known = is_recorded_scene(run, source);
  // Where the run reads the file that a link leads to, it goes on so.
  const fs::path place = known && !context.overwrite ? recorded_place(run) : place_of_scene(source);
  check_name(place.string());
  const json record = recorded(run, place, options);
  Scene scene = load_any_scene(place, options);
  if (!context.overwrite) keep_mean_up(run, scene, options);
  check_names(scene);
  refuse_unused(options, scene);
  if (known && place != place_of_scene(source) && !context.overwrite)
    context.progress.say(
        fmt::format("scene: this run goes on reading {} itself, to which {} is a link (--overwrite: "
                    "with what lies beside the link)",
                    place.string(), source.string()));
  const bool moved = !known && !context.overwrite && has_splats_of(run, scene);
  if (moved) context.progress.say("scene: the scene of this run is now at " + place.string());
  json before = run.scene();
  if (known || moved) before["source"] = record["source"];
  run.set_scene(record, context.overwrite || known || moved);
  if (before != record) forget_assumed_height(run, scene);
  warn_of_scene(context, scene);
  context.progress.say(fmt::format("scene: {} Gaussians, {} cameras{}; up: {}", scene.cloud.size(),
                                   scene.cameras.size(), scene.cameras_are_orbit ? " (orbit)" : "", scene.up_source));
  scale_by_object(run, scene);
  if (scene.scale_is_assumed && scene.object_height == 0)
    context.progress.say(
        "scene: the length of a unit is unknown and assumed to be 1 m unless the label tells the height of the object "
        "(--metres-per-unit, --object-height)");
  return scene;
}

void warn_of_scene(const Context& context, const Scene& scene) {
  for (const std::string& warning : scene.warnings) context.progress.warn(warning);
}

void refuse_unused(const LoadOptions& options, const Scene& scene) {
  if (options.orbit_views && !scene.cameras_are_orbit)
    throw usage_error("--orbit-views", std::to_string(*options.orbit_views), "does nothing: the scene has cameras",
                      "leave it out");
}

Scene load_run_scene(const RunDirectory& run) {
  if (!run.scene().is_object())
    throw usage_error(run.path().string(), "scene", "is not recorded", "run `pliant segment SCENE --out DIR` first");
  const fs::path place = recorded_place(run);
  if (std::error_code none; !fs::exists(place, none))
    throw input_error(place.string(), "", "does not exist, and is the scene of " + run.path().string(),
                      "where it has moved, say so with the options of before: `pliant run NEWSCENE --out " +
                          run.path().string() + "`");
  const LoadOptions options = recorded_options(run);
  Scene scene = load_any_scene(place, options);
  keep_mean_up(run, scene, options);
  scale_by_object(run, scene);
  return scene;
}

}  // namespace pliant
